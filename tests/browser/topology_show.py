"""A scripted topology service beside robot and planner: places, ways, pairs, arrivals."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from browser.live_gateway import LiveGateway
from browser.planning_show import FIRST, PlanningShow
from browser.show import MAP_ID, heartbeat
from pilotage.bus.fabric import RefusedError
from pilotage_schemas.commands import Nothing
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Part
from pilotage_schemas.planning import GazeCommand
from pilotage_schemas.sensors import Landmark, LandmarkSightings, VerticalEdges
from pilotage_schemas.topology import (
    Edge,
    Feature,
    MatchedPairs,
    Node,
    NodeArrival,
    Relocalization,
    Route,
    RouteFloor,
    StoredTopology,
    TopologicalMap,
    TopologyBuild,
    TopologyList,
    TopologyLoad,
    TopologyLoaded,
    TopologyRoute,
    TopologySave,
    TopologySaved,
)

CORRIDOR_Y = 6.5
UP, DOWN = math.pi / 2, -math.pi / 2
NORTH = ((3.2, 5.4), (9.35, 11.2), (15.5, 13.4), (21.65, 24.8))
"""Of each room above the corridor: x of its door and of its place."""
SOUTH = ((3.7, 6.9), (11.85, 9.2), (20.5, 24.0))
DOOR_NORTH, DOOR_SOUTH = 7.78, 5.22
WIDTH = 1.1
HERE = 4
"""The place in the corridor nearest to the robot of the show."""

Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Places:
    """What the topology service tells; replaced by the test as it goes."""

    map_id: str = MAP_ID
    at: int | None = HERE
    is_silent: bool = False
    lines: int = 5
    features: int = 3
    shift: float = 0.3
    """How far what is seen lies beside what the map has [m]."""

    has_ways: bool = True
    extra: tuple[Node, ...] = ()
    kept: tuple[str, ...] = field(default=("ground floor",))
    gaze: float | None = None
    """Where the camera is told to look; None without a camera."""


class TopologyShow(PlanningShow):
    """Publishes what its `places` say, and does what it is asked."""

    def __init__(self, gateway: LiveGateway) -> None:
        super().__init__(gateway)
        self.script = replace(FIRST, topology="ready")
        self.places = Places()
        self._told: Places | None = None
        self._queue: list[Relocalization] = []
        for name in ("build", "save", "load", "route", "list"):
            gateway.answer("topology", f"topology_{name}", getattr(self, name))

    def put(self, **changes: object) -> None:
        """Let the topology service go on differently."""
        self.places = replace(self.places, **changes)  # type: ignore[arg-type]  # names are the fields

    def begin_anew(self) -> None:
        """Be as at first, nothing asked yet."""
        super().begin_anew()
        self.script = replace(FIRST, topology="ready")
        self.places = Places()

    def find_again(self, node: int) -> None:
        """Let tracking have failed, and the pose be found again at a node."""
        now = self.gateway.clock.now_ns()
        pose = Pose2(x=15.5, y=6.5, theta=0.0)
        found = {"node": node, "pose": pose, "covariance": np.eye(3), "matched": 3}
        found |= {"stamp_ns": now, "frame_id": "map", "cause": "recovered"}
        self._queue.append(Relocalization.model_validate(found))

    def build(self, request: TopologyBuild) -> TopologyLoaded:
        self._note("topology_build", request)
        return TopologyLoaded(map_id=MAP_ID, nodes=23, edges=22)

    def save(self, request: TopologySave) -> TopologySaved:
        self._note("topology_save", request)
        self.put(kept=(*self.places.kept, request.name))
        return TopologySaved(name=request.name, map_id=MAP_ID, path=f"/maps/{request.name}")

    def load(self, request: TopologyLoad) -> TopologyLoaded:
        self._note("topology_load", request)
        return TopologyLoaded(map_id=MAP_ID, nodes=23, edges=22)

    def list(self, _request: Nothing) -> TopologyList:
        stored = [
            {"name": name, "map_id": MAP_ID, "floor": "0", "nodes": 23, "edges": 22, "saved_ns": 1}
            for name in self.places.kept
        ]
        return TopologyList(topologies=tuple(map(StoredTopology.model_validate, stored)))

    def route(self, request: TopologyRoute) -> Route:
        self._note("topology_route", request)
        if request.end == room(0):
            raise RefusedError("no way leads there")
        return Route(nodes=ROUTE, edges=(), cost=9.0, way=ROUTE_WAY, floors=(FLOOR,))

    def tick(self) -> None:
        """Publish one round; the graph and an arrival whenever they change."""
        super().tick()
        places, now = self.places, self.gateway.clock.now_ns()
        if places.is_silent:
            return
        was, self._told = self._told, places
        if self._ticks % 5 == 0:
            self._tell("topology", "heartbeat", heartbeat(now, "topology"))
        if was is None or graph_of(was) != graph_of(places):
            self._tell("topology", "topology", topology(now, places))
        if (was is None or was.at != places.at) and places.at is not None:
            self._tell("topology", "node_arrival", arrival(now, places.at))
        if places.gaze is not None:
            self._tell("planner", "gaze_command", gaze(now, places.gaze))
            self._tell("robot", "landmarks", landmarks(now))
            self._tell("robot", "vertical_edges", vertical_edges(now))
        while self._queue:
            self._tell("topology", "relocalization", self._queue.pop())
        if self._ticks % 2 == 0:
            self._tell("localizer", "matched_lines", matched_lines(now, places))
            self._tell("topology", "matched_features", matched_features(now, places))

    def _note(self, name: str, request: Part) -> None:
        self.asked.append((name, request))
        if self.refusal:
            raise RefusedError(self.refusal)


def graph_of(places: Places) -> tuple[object, ...]:
    """Return what the graph depends on."""
    return places.map_id, places.has_ways, places.extra


def room(i: int) -> int:
    """Return the number of the place in room `i`: those to the north come first."""
    return 20 + i


def door(i: int) -> int:
    """Return the number of the place in the door of room `i`."""
    return 10 + i


def crossings() -> list[float]:
    """Return x of the places of the corridor: before each door, from west to east."""
    return sorted(x for x, _ in (*NORTH, *SOUTH))


def nodes() -> list[Node]:
    """Return the places of corridor, doors and rooms, each with the features near it."""
    spots = [(x, CORRIDOR_Y, 0.0) for x in crossings()]
    along = [node(i, "node", f"Corridor {i}", spot) for i, spot in enumerate(spots)]
    doors = [node(door(i), "door", f"Door {i}", spot) for i, spot in enumerate(doorways())]
    return [*along, *doors, *rooms()]


def rooms() -> list[Node]:
    """Return the places of the rooms."""
    north = [(x, 9.5, UP) for _, x in NORTH]
    south = [(x, 2.6, DOWN) for _, x in SOUTH]
    return [node(room(i), "node", f"Room {i}", spot) for i, spot in enumerate(north + south)]


def doorways() -> list[tuple[float, float, float]]:
    """Return the middle of each door and the heading of who goes through it."""
    north = [(x, DOOR_NORTH, UP) for x, _ in NORTH]
    return north + [(x, DOOR_SOUTH, DOWN) for x, _ in SOUTH]


def node(number: int, kind: str, name: str, place: tuple[float, float, float]) -> Node:
    """Return a place with the features within 3.5 m of it."""
    x, y, theta = place
    near = [f for f in features() if math.hypot(f.pose.x - x, f.pose.y - y) < 3.5]
    pose = Pose2(x=x, y=y, theta=theta)
    fields = {"id": number, "kind": kind, "name": name, "pose": pose, "features": tuple(near)}
    return Node.model_validate(fields)


def features() -> list[Feature]:
    """Return doors, a passage in the corridor, and the corners of its ends and of a room."""
    found = [feature("door", x, y, heading, WIDTH) for x, y, heading in doorways()]
    found.append(feature("passage", 7.0, CORRIDOR_Y, 0.0, 2.3))
    found += [feature("corner", 0.15, 7.7, -math.pi / 4), feature("corner", 0.15, 5.3, math.pi / 4)]
    found += [feature("corner", 18.45, 7.85, 3 * math.pi / 4)]
    found += [feature("corner", 12.45, 7.85, math.pi / 4)]
    return found


def feature(kind: str, x: float, y: float, theta: float, width: float | None = None) -> Feature:
    """Return a feature."""
    pose = Pose2(x=x, y=y, theta=theta)
    return Feature.model_validate({"kind": kind, "pose": pose, "width": width})


def edges(*, has_ways: bool = True) -> list[Edge]:
    """Return the ways: along the corridor, to each door and on into its room, round its jamb.

    Without ways of their own they are straight from place to place.
    """
    by_id = {node.id: node.pose for node in nodes()}
    along = crossings()
    ends: list[tuple[int, int, str, Points | None]] = [
        (i, i + 1, "corridor", None) for i in range(len(along) - 1)
    ]
    for i, (x, y, heading) in enumerate(doorways()):
        beyond = y + 0.9 * math.sin(heading)
        place = by_id[room(i)]
        bent: Points = ((x, CORRIDOR_Y), (x, beyond), (place.x, place.y))
        ends.append((along.index(x), room(i), "door", bent))
    made = []
    for k, (start, end, kind, way) in enumerate(ends):
        straight = tuple((by_id[i].x, by_id[i].y) for i in (start, end))
        points: Points = way if way and has_ways else straight
        fields = {"id": 1000 + k, "start": start, "end": end, "cost": length(points)}
        made.append(Edge.model_validate(fields | {"way": points_of(points), "kind": kind}))
    return made


def length(points: Points) -> float:
    """Return how long a way is [m]."""
    return float(np.hypot(*np.diff(np.array(points), axis=0).T).sum())


def points_of(points: Points) -> NDArray[np.float32]:
    """Return a way's points as messages have them."""
    return np.array(points, np.float32).reshape(-1, 2)


def topology(now: int, places: Places) -> TopologicalMap:
    """Return the graph."""
    return TopologicalMap(
        stamp_ns=now,
        frame_id="map",
        map_id=places.map_id,
        nodes=(*nodes(), *places.extra),
        edges=tuple(edges(has_ways=places.has_ways)),
    )


def arrival(now: int, number: int) -> NodeArrival:
    """Return that the robot has reached a place."""
    place = next(node for node in nodes() if node.id == number)
    fields = {"stamp_ns": now, "frame_id": "map", "node": number, "name": place.name}
    return NodeArrival.model_validate(fields | {"matched": 2, "bound": 3, "pose": place.pose})


def matched_lines(now: int, places: Places) -> MatchedPairs:
    """Return the corridor's walls, piece by piece, seen beside where they are."""
    pieces = [(13.0, 5.3, 14.8, 5.3), (13.0, 7.7, 14.8, 7.7), (16.2, 7.7, 18.2, 7.7)]
    pieces += [(16.4, 5.3, 18.4, 5.3), (18.6, 5.3, 19.8, 5.3), (18.6, 7.7, 19.8, 7.7)]
    expected = np.array(pieces[: places.lines], np.float32).reshape(-1, 4)
    return pairs(now, "line", expected, places.shift)


def matched_features(now: int, places: Places) -> MatchedPairs:
    """Return a corner, a door and another corner, seen beside where they are."""
    both = [(12.45, 7.85, 12.45, 7.85), (14.95, 7.78, 16.05, 7.78), (18.45, 7.85, 18.45, 7.85)]
    expected = np.array(both[: places.features], np.float32).reshape(-1, 4)
    found = pairs(now, "corner", expected, places.shift)
    kinds = ("corner", "door", "corner")[: places.features]
    return found.model_copy(update={"kinds": kinds, "node": HERE})


def pairs(now: int, kind: str, expected: NDArray[np.float32], shift: float) -> MatchedPairs:
    """Return pairs whose seen side lies `shift` to the north of what is expected."""
    seen = expected + np.array([0.0, shift, 0.0, shift], np.float32)
    fields = {"stamp_ns": now, "frame_id": "map", "kinds": (kind,) * len(expected)}
    return MatchedPairs.model_validate(fields | {"seen": seen, "expected": expected})


def gaze(now: int, pan: float) -> GazeCommand:
    """Return where the camera is told to look."""
    return GazeCommand(stamp_ns=now, frame_id="camera", pan=pan)


def landmarks(now: int) -> LandmarkSightings:
    """Return one landmark 2 m to the left of the robot."""
    fields = {"kind": "beacon", "range": 2.0, "bearing": math.pi / 2}
    sighting = Landmark.model_validate(fields | {"range_sigma": 0.1, "bearing_sigma": 0.02})
    return LandmarkSightings(stamp_ns=now, frame_id="camera", sightings=(sighting,))


def vertical_edges(now: int) -> VerticalEdges:
    """Return the edges of a door ahead."""
    bearings = np.array([0.3, -0.3], np.float32)
    return VerticalEdges(stamp_ns=now, frame_id="camera", bearings=bearings, sigma=0.01)


ROUTE = (4, 5, 6, room(3))
ROUTE_WAY = points_of(((15.5, 6.5), (20.5, 6.5), (21.65, 6.5), (21.65, 8.68), (24.8, 9.5)))
FLOOR = RouteFloor(name="", floor="", nodes=4, edges=3, points=5)
