"""A mapper on a fake fabric with a clock turned by hand, and a robot in a small flat."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from dead_reckoning_mapping import DeadReckoningMapping
from localizer_world import ANGLE_MIN, ANGLE_STEP, BEARINGS, RANGE_MAX, ROUND, START, flat
from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import Deployment
from pilotage.bus.fabric import Sample
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.mapper.config import MapperSettings
from pilotage.mapper.messages import pose_of
from pilotage.mapper.method import MappingMethod
from pilotage.mapper.service import MapperService
from pilotage_schemas.codec import decode
from pilotage_schemas.commands import Done, MapLoaded, MapStart, Nothing
from pilotage_schemas.geometry import Twist2
from pilotage_schemas.localization import Belief, PoseEstimate
from pilotage_schemas.mapping import GridPatch, MappedPath, MappingStatus, OccupancyGrid
from pilotage_schemas.message import Message, Part
from pilotage_schemas.sensors import LaserScan, Odometry, RobotDescription, SensorMount

LASER = np.array([0.1, 0.0, 0.0])
STAND = (0.0, 0.0, 0.0)
HEARD: dict[str, type[Message]] = {
    "map": OccupancyGrid,
    "map_patch": GridPatch,
    "mapped_path": MappedPath,
    "mapping_status": MappingStatus,
    "pose": PoseEstimate,
}
Some = TypeVar("Some", bound=Message)


@dataclass
class MapperBench:
    """The mapper, a robot driven by hand, and all that was heard of the mapper, by topic."""

    folder: Path | None = None
    settings: MapperSettings = field(default_factory=MapperSettings)
    make: Callable[[str], MappingMethod] = lambda _sensor: DeadReckoningMapping()
    world: OccupancyMap = field(default_factory=flat)
    fabric: FakeFabric = field(default_factory=FakeFabric)
    clock: HandClock = field(default_factory=HandClock)
    truth: np.ndarray = field(default_factory=lambda: np.array(START))
    odom: np.ndarray = field(default_factory=lambda: np.array([7.0, -3.0, 2.0]))
    heard: dict[str, list[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for topic, kind in HEARD.items():
            self.heard[topic] = self.listen(topic, kind)
        self.robot = Node("robot", "demo", self.fabric, self.clock)
        self.localizer = Node("localizer", "demo", self.fabric, self.clock)
        self.asking = Node("gateway", "demo", self.fabric, self.clock)
        self.begin_mapper()

    def begin_mapper(self) -> None:
        """Start the mapper, as the launcher does after a crash too."""
        self.node = Node("mapper", "demo", self.fabric, self.clock)
        deployment = Deployment(run_dir=self.folder)
        self.service = MapperService(self.settings, self.node, deployment, self.make)
        self.fabric.pump = self.step
        self.step()

    def crash(self) -> None:
        """Let the mapper die between two handlers, and start again."""
        self.fabric._subscribers = self.fabric._subscribers[: len(HEARD)]
        self.fabric._kept.clear()
        self.begin_mapper()
        self.describe()

    def listen(self, topic: str, kind: type[Some], history: int = 1) -> list[Some]:
        heard: list[Some] = []

        def hear(sample: Sample) -> None:
            heard.append(decode(kind, sample.payload))

        key = f"pilotage/@v1/demo/{topic}"
        self.fabric.declare_subscriber(key, "never_drop", hear, history)
        return heard

    def step(self) -> None:
        self.node.step()

    def ask(self, query: str, request: Part) -> Part:
        return self.asking.ask(query, request)

    def put(self, topic: str, message: Message, by: Node | None = None) -> None:
        (by or self.robot).publisher(topic).publish(message)
        self.step()

    def describe(self) -> None:
        mount = SensorMount(frame_id="laser", kind="laser", pose=pose_of(LASER))
        self.put(
            "description",
            RobotDescription(
                stamp_ns=self.clock.now_ns(),
                frame_id="base_link",
                name="demo",
                driver="hand",
                footprint=np.zeros((0, 2), np.float32),
                mounts=(mount,),
                max_linear=1.0,
                max_angular=2.0,
                commands=(),
            ),
        )

    def say_odometry(self) -> None:
        self.put(
            "odometry",
            Odometry(
                stamp_ns=self.clock.now_ns(),
                frame_id="odom",
                pose=pose_of(self.odom),
                twist=Twist2(vx=0.0, vy=0.0, omega=0.0),
                covariance=np.eye(3),
            ),
        )

    def scan(self, frame_id: str = "laser") -> LaserScan:
        ranges = cast_scan(self.world, se2.compose(self.truth, LASER), BEARINGS, RANGE_MAX)
        return LaserScan(
            stamp_ns=self.clock.now_ns(),
            frame_id=frame_id,
            angle_min=ANGLE_MIN,
            angle_increment=ANGLE_STEP,
            range_min=0.05,
            range_max=RANGE_MAX,
            ranges=ranges.astype(np.float32),
        )

    def go(self, *steps: tuple[float, float, float], scans: bool = True) -> None:
        """Drive in steps of 0.3 s, each with odometry every 0.1 s and a scan."""
        for step in steps:
            for _ in range(3):
                part = np.array(step) / 3.0
                self.clock.advance(0.1)
                self.truth, self.odom = se2.compose(self.truth, part), se2.compose(self.odom, part)
                self.say_odometry()
            if scans:
                self.put("scan", self.scan())

    def believe(self, map_id: str) -> None:
        """Say as the localizer that it believes something on this map."""
        belief = Belief(
            stamp_ns=self.clock.now_ns(),
            frame_id="map",
            map_id=map_id,
            method="markov",
            samples=np.zeros((0, 4), np.float32),
            entropy=0.0,
            modes=(),
        )
        self.put("belief", belief, by=self.localizer)

    @property
    def status(self) -> MappingStatus:
        """What the mapper said last of itself."""
        said: MappingStatus = self.heard["mapping_status"][-1]
        return said


def pieced_together(grids: Iterable[OccupancyGrid], patches: Iterable[GridPatch]) -> np.ndarray:
    """Return the cells that someone has who heard these: the last map, its patches laid over it."""
    last = list(grids)[-1]
    cells = last.cells.copy()
    for patch in patches:
        if patch.map_id == last.map_id:
            rows, cols = patch.cells.shape
            cells[patch.row : patch.row + rows, patch.col : patch.col + cols] = patch.cells
    return cells


def described(folder: Path) -> MapperBench:
    """Return a mapper that knows the robot."""
    bench = MapperBench(folder)
    bench.describe()
    return bench


def half_mapped(folder: Path) -> MapperBench:
    """Return a mapper that has mapped half of the flat."""
    bench = described(folder)
    assert isinstance(bench.ask("map_start", MapStart()), Done)
    bench.go(STAND, *ROUND[:8])
    return bench


def stopped(bench: MapperBench) -> MapLoaded:
    reply = bench.ask("map_stop", Nothing())
    assert isinstance(reply, MapLoaded)
    return reply
