"""A robot that is driven by hand through a flat, the topology service, and what it says."""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import Deployment
from pilotage.bus.fabric import Sample
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.mapper.messages import grid_message
from pilotage.topology.config import TopologySettings
from pilotage.topology.service import TopologyService
from pilotage_schemas.codec import decode
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.localization import PoseEstimate, State
from pilotage_schemas.mapping import MappedPath, MappingStatus, OccupancyGrid
from pilotage_schemas.message import Message, Part
from pilotage_schemas.sensors import LaserScan, Odometry, RobotDescription, SensorMount
from pilotage_schemas.topology import (
    MatchedPairs,
    NodeArrival,
    Relocalization,
    TopologicalMap,
)

CELL = 0.05
LASER = np.array([0.12, 0.0, 0.0])
BEARINGS = np.linspace(-math.pi / 2.0, math.pi / 2.0, 361)
REACH = 12.0
CUPBOARDS = (
    *(((16, 28), (120, 140)), ((16, 24), (206, 226)), ((60, 80), (110, 120))),
    *(((90, 100), (226, 236)), ((244, 264), (20, 44)), ((200, 216), (4, 12))),
    *(((252, 264), (70, 90)), ((180, 196), (94, 104))),
)
"""Rows and columns of each, from and to."""

HEARD: dict[str, type[Message]] = {
    "topology": TopologicalMap,
    "node_arrival": NodeArrival,
    "relocalization": Relocalization,
    "matched_features": MatchedPairs,
}


def flat() -> OccupancyMap:
    """A corridor of 12 m x 2 m with a room of 5 m on either side, each behind a door of 0.9 m.

    Cupboards stand along the walls of the rooms, by whose corners a robot can be found.
    """
    rows, cols = 280, 240
    cells = np.full((rows, cols), 100, np.int8)
    cells[120:160, 4:236] = 0
    cells[164:264, 4:104] = cells[16:116, 110:236] = 0
    for rows_of, cols_of in CUPBOARDS:
        cells[slice(*rows_of), slice(*cols_of)] = 100
    cells[160:164, 40:58] = cells[116:120, 170:188] = 0
    return OccupancyMap(GridGeometry(rows, cols, CELL), cells)


FLAT = flat()


def pose2(pose: np.ndarray) -> Pose2:
    return Pose2(x=float(pose[0]), y=float(pose[1]), theta=float(pose[2]))


@dataclass
class TopologyBench:
    """The topology service of robot `demo` on a fake bus, and the services around it."""

    folder: Path | None = None
    settings: TopologySettings = field(default_factory=TopologySettings)
    world: OccupancyMap = field(default_factory=lambda: FLAT)
    fabric: FakeFabric = field(default_factory=FakeFabric)
    clock: HandClock = field(default_factory=HandClock)
    pose: np.ndarray = field(default_factory=lambda: np.array([1.5, 7.0, 0.0]))
    odom: np.ndarray = field(default_factory=lambda: np.array([3.0, -2.0, 1.0]))
    way: list[tuple[int, np.ndarray]] = field(default_factory=list)
    heard: dict[str, list[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for topic in HEARD:
            self._listen(topic)
        self.robot = Node("robot", "demo", self.fabric, self.clock)
        self.mapper = Node("mapper", "demo", self.fabric, self.clock)
        self.localizer = Node("localizer", "demo", self.fabric, self.clock)
        self.asking = Node("gateway", "demo", self.fabric, self.clock)
        self.begin()

    def begin(self) -> None:
        self.node = Node("topology", "demo", self.fabric, self.clock)
        self.service = TopologyService(self.settings, self.node, Deployment(run_dir=self.folder))
        self.fabric.pump = self.step
        self.step()

    def crash(self) -> None:
        """End the service without a word and begin it anew."""
        self.fabric._subscribers = self.fabric._subscribers[: len(HEARD)]
        self.begin()

    def step(self) -> None:
        self.node.step()

    def put(self, by: Node, topic: str, message: Message) -> None:
        by.publisher(topic).publish(message)
        self.step()

    def put_map(self, world: OccupancyMap | None = None) -> OccupancyGrid:
        grid = grid_message(world or self.world, "flat", self.clock.now_ns())
        self.put(self.mapper, "map", grid)
        return grid

    def put_growing_map(self, map_id: str = "growing-1") -> None:
        grid = grid_message(self.world, "in the making", self.clock.now_ns(), map_id)
        self.put(self.mapper, "map", grid)

    def put_status(self, mode: str, since_ns: int = 5) -> None:
        fields = {"stamp_ns": self.clock.now_ns(), "frame_id": "map", "since_ns": since_ns}
        status = MappingStatus.model_validate(fields | {"mode": mode})
        self.put(self.mapper, "mapping_status", status)

    def put_path(self, shift: tuple[float, float, float]) -> None:
        """Let the mapper say that the robot was elsewhere all the time."""
        stamps, poses = zip(*self.way, strict=True)
        ages = (self.clock.now_ns() - np.array(stamps)) / 1e9
        path = MappedPath(
            stamp_ns=self.clock.now_ns(),
            frame_id="map",
            map_id="growing-1",
            poses=(np.array(poses) + shift).astype(np.float32),
            ages=ages.astype(np.float32),
        )
        self.put(self.mapper, "mapped_path", path)

    def describe(self) -> None:
        description = RobotDescription(
            stamp_ns=self.clock.now_ns(),
            frame_id="base_link",
            name="demo",
            driver="hand",
            footprint=np.zeros((0, 2), np.float32),
            mounts=(SensorMount(frame_id="laser", kind="laser", pose=pose2(LASER)),),
            max_linear=1.0,
            max_angular=2.0,
            commands=(),
        )
        self.put(self.robot, "description", description)

    def look(
        self,
        state: State | None = "localized",
        error: tuple[float, float, float] = (0.0, 0.0, 0.0),
        owner: Node | None = None,
    ) -> None:
        """Let a fifth of a second pass, and let all speak; `error` of the pose that is told."""
        self.clock.advance(0.2)
        now_ns = self.clock.now_ns()
        self.way.append((now_ns, self.pose))
        still = Twist2(vx=0.0, vy=0.0, omega=0.0)
        odometry = Odometry(
            stamp_ns=now_ns,
            frame_id="odom",
            pose=pose2(self.odom),
            twist=still,
            covariance=np.eye(3),
        )
        self.put(self.robot, "odometry", odometry)
        if state is not None:
            estimate = PoseEstimate(
                stamp_ns=now_ns,
                frame_id="map",
                pose=pose2(self.pose + error),
                covariance=0.01 * np.eye(3),
                state=state,
                confidence=0.9,
            )
            self.put(owner or self.localizer, "pose", estimate)
        self.put(self.robot, "scan", self.scan())

    def scan(self) -> LaserScan:
        laser = se2.compose(self.pose, LASER)
        ranges = cast_scan(FLAT, laser, BEARINGS, REACH)
        return LaserScan(
            stamp_ns=self.clock.now_ns(),
            frame_id="laser",
            angle_min=float(BEARINGS[0]),
            angle_increment=float(BEARINGS[1] - BEARINGS[0]),
            range_min=0.05,
            range_max=REACH,
            ranges=ranges.astype(np.float32),
        )

    def move(self, step: tuple[float, float, float]) -> None:
        """Move the robot in its own frame; odometry notices."""
        self.pose = se2.compose(self.pose, np.array(step))
        self.odom = se2.compose(self.odom, np.array(step))

    def carry(self, pose: tuple[float, float, float]) -> None:
        """Put the robot elsewhere; odometry does not notice."""
        self.pose = np.array(pose)

    def ride(self, *waypoints: tuple[float, float], **said: Any) -> None:  # noqa: ANN401 - as look
        """Drive from point to point in steps of 0.1 m, looking at each."""
        for x, y in waypoints:
            ahead = np.array([x, y]) - self.pose[:2]
            turn = math.remainder(math.atan2(ahead[1], ahead[0]) - self.pose[2], math.tau)
            for _ in range(math.ceil(abs(turn) / 0.2)):
                self.move((0.0, 0.0, turn / math.ceil(abs(turn) / 0.2)))
                self.look(**said)
            steps = max(1, round(float(np.hypot(*ahead)) / 0.1))
            for _ in range(steps):
                self.move((float(np.hypot(*ahead)) / steps, 0.0, 0.0))
                self.look(**said)

    def ask(self, query: str, request: Part) -> Any:  # noqa: ANN401 - the caller knows its reply
        return self.asking.ask(query, request)

    def _listen(self, topic: str) -> None:
        found = self.heard.setdefault(topic, [])

        def hear(sample: Sample) -> None:
            found.append(decode(HEARD[topic], sample.payload))

        self.fabric.declare_subscriber(f"pilotage/@v1/demo/{topic}", "latest_wins", hear)
