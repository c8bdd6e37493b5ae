"""A corridor with alike doors on both sides and a hall at its end (Zhuang et al. 2005, figure 3).

x runs along the middle line of the corridor, which begins at x = 0; y = 0 is the middle line. The
paper's floor is not given in figures, so the doors stand where `seed` puts them, as irregularly as
in a building. Closed leaves lie behind the face of the wall; behind open doors there is a room.
The topological map is made by hand from the doors: a node on the middle line at every door, doors
that face each other sharing one, and edges from node to node.
"""

import itertools
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pilotage.core.grid import UNKNOWN, GridGeometry, OccupancyMap
from pilotage.robot.simulator.floor_canvas import FloorCanvas
from pilotage.topology.features import KINDS, Features
from pilotage.topology.topological_map import Edge, Node, TopologicalMap

CELL = 0.05
HALF_WIDTH = 1.2
"""m from the middle line to the walls."""
WALL = 0.2
RECESS = 0.15
"""m from the face of the wall to a closed leaf."""
DOOR_WIDTH = 0.9
ROOM_DEPTH = 3.5
HALL = 7.0
"""m along x and across of the hall at the corridor's end."""

BOUND_WITHIN = 6.0
"""m along the corridor within which a node is bound to doors and corners: what is seen from it."""
SHARED_WITHIN = 1.2
"""m along the corridor within which two doors share a node."""
FEATURE_SIGMA = 0.02
"""m that the place of a feature is known to."""

FIRST_DOOR, LEAST_GAP, MOST_GAP = 1.5, 1.9, 4.5
"""m to the first door of a side at least, and from one to the next, middle to middle."""
MODULE_GAPS = 2.4, 3.6, 4.8
"""m from door to door in a building that is planned in modules of 1.2 m."""
REGULAR_GAP = 3.0
SHARE_OPEN = 0.35

Spacing = Literal["irregular", "modular", "regular"]


@dataclass(frozen=True)
class CorridorDoor:
    """A door at `x` m, on the left (`side` 1) or the right (-1) of somebody who walks along x."""

    x: float
    side: int
    is_open: bool


@dataclass(frozen=True)
class Corridor:
    """A corridor of `length` m with its doors."""

    length: float
    doors: tuple[CorridorDoor, ...]
    has_hall: bool = True


def corridor_of(length: float, seed: int, spacing: Spacing = "irregular") -> Corridor:
    """Return a corridor with doors; the same seed gives the same.

    They stand irregularly, in modules, or all closed, at equal distances and facing each other, so
    that the corridor looks the same from both ends.
    """
    rng = np.random.default_rng([seed, 4])
    doors = []
    for side in (1, -1):
        x = FIRST_DOOR + (0.0 if spacing == "regular" else rng.uniform(0.0, 2.0))
        while x <= length - FIRST_DOOR:
            place = round(x / CELL) * CELL
            is_open = spacing != "regular" and bool(rng.random() < SHARE_OPEN)
            doors.append(CorridorDoor(place, side, is_open))
            x += _gap(spacing, rng)
    return Corridor(length, tuple(sorted(doors, key=lambda door: (door.x, door.side))))


def _gap(spacing: Spacing, rng: np.random.Generator) -> float:
    if spacing == "irregular":
        return float(rng.uniform(LEAST_GAP, MOST_GAP))
    return float(rng.choice(MODULE_GAPS)) if spacing == "modular" else REGULAR_GAP


def floor_of(corridor: Corridor) -> OccupancyMap:
    """Return the floor as its map shows it: unknown wherever nobody can look."""
    deep = max(HALF_WIDTH + WALL + ROOM_DEPTH, HALL / 2.0) + WALL
    canvas = FloorCanvas(corridor.length + HALL, 2.0 * deep, CELL, margin=2.0 * WALL)
    drawing = _Drawing(canvas, deep)
    drawing.space(0.0, -HALF_WIDTH, corridor.length, HALF_WIDTH)
    if corridor.has_hall:
        drawing.hall(corridor.length)
    for door in corridor.doors:
        if door.is_open:
            drawing.room(_room_of(corridor, door), door.side)
    for door in corridor.doors:
        drawing.doorway(door)
    floor = canvas.to_map()
    rows, cols = floor.geometry.shape
    x, y, _ = floor.geometry.origin
    moved = GridGeometry(rows, cols, CELL, (x, y - deep, 0.0))
    return OccupancyMap(moved, floor.cells)


def walkable(corridor: Corridor) -> OccupancyMap:
    """Return the corridor alone, where people walk about."""
    alone = floor_of(Corridor(corridor.length, (), corridor.has_hall))
    cells = alone.cells.copy()
    cells[:, alone.geometry.cells_of([[corridor.length, 0.0]])[0, 1] :] = UNKNOWN
    return OccupancyMap(alone.geometry, cells)


def topology_of(corridor: Corridor) -> TopologicalMap:
    """Return the nodes at the doors, each bound to the doors and corners near it, and the edges."""
    found = features_of(corridor)
    nodes = [
        Node(
            number,
            "node",
            f"node {number + 1}",
            np.array([x, 0.0, 0.0]),
            found.chosen(np.abs(found.poses[:, 0] - x) <= BOUND_WITHIN),
        )
        for number, x in enumerate(_stops(corridor))
    ]
    edges = [
        Edge(
            len(nodes) + start.id,
            start.id,
            end.id,
            "corridor",
            float(end.pose[0] - start.pose[0]),
            np.array([start.pose[:2], end.pose[:2]]),
        )
        for start, end in itertools.pairwise(nodes)
    ]
    return TopologicalMap("corridor", tuple(nodes), tuple(edges))


def features_of(corridor: Corridor) -> Features:
    """Return the doors of a corridor and the corners at its beginning and its end, in map."""
    doors = [(door.x, door.side * HALF_WIDTH, door.side * np.pi / 2.0) for door in corridor.doors]
    corners = [(0.0, side * HALF_WIDTH, -side * np.pi / 4.0) for side in (1, -1)]
    facing = 0.25 * np.pi if corridor.has_hall else -0.75 * np.pi
    ends = [(corridor.length, side * HALF_WIDTH, side * facing) for side in (1, -1)]
    poses = np.array([*doors, *corners, *ends]).reshape(-1, 3)
    kinds = np.full(len(poses), KINDS.index("corner"))
    kinds[: len(doors)] = KINDS.index("door")
    widths = np.where(kinds == KINDS.index("door"), DOOR_WIDTH, np.nan)
    covariances = np.tile(FEATURE_SIGMA**2 * np.eye(2), (len(poses), 1, 1))
    return Features(kinds, poses, widths, covariances)


def _stops(corridor: Corridor) -> list[float]:
    """Return where along the middle line nodes are set."""
    groups: list[list[float]] = []
    for door in corridor.doors:
        if groups and door.x - groups[-1][0] <= SHARED_WITHIN:
            groups[-1].append(door.x)
        else:
            groups.append([door.x])
    return [float(np.mean(group)) for group in groups]


def _room_of(corridor: Corridor, door: CorridorDoor) -> tuple[float, float]:
    """Return where the room behind a door begins and ends along x."""
    same = [other.x for other in corridor.doors if other.side == door.side]
    before = max((x for x in same if x < door.x), default=-np.inf)
    after = min((x for x in same if x > door.x), default=np.inf)
    begin = max((before + door.x) / 2.0, door.x - 2.0, WALL)
    end = min((door.x + after) / 2.0, door.x + 2.0, corridor.length - WALL)
    return begin + WALL / 2.0, end - WALL / 2.0


@dataclass(frozen=True)
class _Drawing:
    """A canvas whose middle line lies `deep` m above its lower edge."""

    canvas: FloorCanvas
    deep: float

    def floor(self, x0: float, y0: float, x1: float, y1: float) -> None:
        self.canvas.floor((x0, y0 + self.deep, x1, y1 + self.deep))

    def solid(self, x0: float, y0: float, x1: float, y1: float) -> None:
        self.canvas.solid((x0, y0 + self.deep, x1, y1 + self.deep))

    def space(self, x0: float, y0: float, x1: float, y1: float) -> None:
        """Lay floor within walls."""
        self.solid(x0 - WALL, y0 - WALL, x1 + WALL, y1 + WALL)
        self.floor(x0, y0, x1, y1)

    def hall(self, x: float) -> None:
        """Lay the hall, open to the corridor that ends at x."""
        self.space(x + WALL, -HALL / 2.0, x + HALL, HALL / 2.0)
        self.floor(x - WALL, -HALF_WIDTH, x + 2.0 * WALL, HALF_WIDTH)

    def room(self, along: tuple[float, float], side: int) -> None:
        """Lay a room behind the wall of a side."""
        near, far = HALF_WIDTH + WALL, HALF_WIDTH + WALL + ROOM_DEPTH
        y0, y1 = sorted((side * near, side * far))
        self.space(along[0], y0, along[1], y1)

    def doorway(self, door: CorridorDoor) -> None:
        """Cut a doorway, through the wall or as deep as its closed leaf."""
        depth = WALL if door.is_open else RECESS
        y0, y1 = sorted((door.side * HALF_WIDTH, door.side * (HALF_WIDTH + depth)))
        self.floor(door.x - DOOR_WIDTH / 2.0, y0, door.x + DOOR_WIDTH / 2.0, y1)
