"""A robot that is driven by hand, a localizer on a fake fabric, and what it says."""

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from localizer_world import ANGLE_MIN, ANGLE_STEP, BEARINGS, RANGE_MAX, ROUND, START, error, flat
from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import Deployment
from pilotage.bus.fabric import Sample
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.method import LocalizationMethod
from pilotage.localizer.service import LocalizerService
from pilotage.mapper.messages import grid_message
from pilotage_schemas.codec import decode
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.localization import Belief, PoseEstimate
from pilotage_schemas.message import Message, Part
from pilotage_schemas.sensors import (
    Heading,
    LaserScan,
    Odometry,
    RobotDescription,
    SensorMount,
    SonarScan,
)

WORLD = flat()
LASER = np.array([0.12, 0.0, 0.1])
"""The laser sits ahead of the robot's centre and looks a little to the left."""

STANDING = (0.0, 0.0, 0.0)
SONAR = np.zeros((16, 3), np.float32)
SONAR[:, 2] = np.arange(16) * math.tau / 16


def pose2(pose: np.ndarray) -> Pose2:
    return Pose2(x=float(pose[0]), y=float(pose[1]), theta=float(pose[2]))


@dataclass
class Bench:
    """A robot that is driven by hand, the localizer, and what it has said."""

    folder: Path | None = None
    settings: LocalizerSettings = field(default_factory=lambda: LocalizerSettings(headings=36))
    world: OccupancyMap = WORLD
    fabric: FakeFabric = field(default_factory=FakeFabric)
    clock: HandClock = field(default_factory=HandClock)
    pose: np.ndarray = field(default_factory=lambda: np.array(START))
    odom: np.ndarray = field(default_factory=lambda: np.array([7.0, -3.0, 2.0]))
    poses: list[PoseEstimate] = field(default_factory=list)
    beliefs: list[Belief] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._listen("pose", PoseEstimate, self.poses)
        self._listen("belief", Belief, self.beliefs)
        self.robot = Node("robot", "demo", self.fabric, self.clock)
        self.mapper = Node("mapper", "demo", self.fabric, self.clock)
        self.asking = Node("gateway", "demo", self.fabric, self.clock)
        self.begin_localizer()

    def begin_localizer(self) -> None:
        self.node = Node("localizer", "demo", self.fabric, self.clock)
        self.service = LocalizerService(self.settings, self.node, Deployment(run_dir=self.folder))
        self.fabric.pump = self.step
        self.step()

    def step(self) -> None:
        self.node.step()

    def crash_localizer(self) -> None:
        self.fabric._subscribers = self.fabric._subscribers[:2]
        self.begin_localizer()

    def put_map(self, world: OccupancyMap | None = None) -> None:
        grid = grid_message(world or self.world, "flat", self.clock.now_ns())
        self.put("map", grid, by=self.mapper)

    def put(self, topic: str, message: Message, by: Node | None = None) -> None:
        (by or self.robot).publisher(topic).publish(message)
        self.node.step()

    def describe(self, frame: str = "laser") -> None:
        mount = SensorMount(frame_id=frame, kind="laser", pose=pose2(LASER))
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

    def begin(self) -> None:
        self.put_map()
        self.describe()

    def odometry(self) -> Odometry:
        return Odometry(
            stamp_ns=self.clock.now_ns(),
            frame_id="odom",
            pose=pose2(self.odom),
            twist=Twist2(vx=0.0, vy=0.0, omega=0.0),
            covariance=np.eye(3),
        )

    def say_odometry(self) -> None:
        self.put("odometry", self.odometry())

    def scan(self) -> LaserScan:
        ranges = cast_scan(self.world, se2.compose(self.pose, LASER), BEARINGS, RANGE_MAX)
        return LaserScan(
            stamp_ns=self.clock.now_ns(),
            frame_id="laser",
            angle_min=ANGLE_MIN,
            angle_increment=ANGLE_STEP,
            range_min=0.05,
            range_max=RANGE_MAX,
            ranges=ranges.astype(np.float32),
        )

    def sonar(self) -> SonarScan:
        ranges = cast_scan(self.world, self.pose, SONAR[:, 2], 4.0)
        return SonarScan(
            stamp_ns=self.clock.now_ns(),
            frame_id="base_link",
            mounts=SONAR,
            ranges=ranges.astype(np.float32),
            cone=0.4,
            range_min=0.05,
            range_max=4.0,
        )

    def heading(self) -> Heading:
        stamp_ns = self.clock.now_ns()
        return Heading(stamp_ns=stamp_ns, frame_id="map", yaw=float(self.pose[2]), sigma=0.1)

    def go(self, step: tuple[float, float, float], seconds: float = 1.0) -> PoseEstimate:
        self.clock.advance(seconds)
        self.pose, self.odom = se2.compose(self.pose, step), se2.compose(self.odom, step)
        self.say_odometry()
        self.put("scan", self.scan())
        return self.latest()

    def latest(self) -> PoseEstimate:
        """The pose after a further odometry message, which carries the newest estimate."""
        self.clock.advance(0.1)
        self.say_odometry()
        return self.poses[-1]

    def drive_round(self) -> None:
        for step in [STANDING, *ROUND]:
            self.go(step)
        assert self.poses[-1].state == "localized"

    @property
    def method(self) -> LocalizationMethod:
        """The method at work."""
        method = self.service._at.method
        assert method is not None
        return method

    def ask(self, query: str, request: Part) -> Part:
        return self.asking.ask(query, request)

    def is_right(self, within: float = 0.1) -> bool:
        said = self.poses[-1].pose
        away, turn = error([said.x, said.y, said.theta], self.pose)
        return away < within and turn < 0.06

    def _listen(self, topic: str, kind: type[Message], heard: list) -> None:  # type: ignore[type-arg]  # of either kind
        def hear(sample: Sample) -> None:
            heard.append(decode(kind, sample.payload))

        self.fabric.declare_subscriber(f"pilotage/@v1/demo/{topic}", "latest_wins", hear)
