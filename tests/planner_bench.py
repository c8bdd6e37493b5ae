"""A planner on a fake fabric, and a robot that does what it says, in a drawn world."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from drawing import draw
from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import Deployment
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.motion import arc
from pilotage.core.raycast import cast_scan
from pilotage.planner.config import PlannerSettings
from pilotage.planner.service import PlannerService
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.localization import Belief, Mode, PoseEstimate
from pilotage_schemas.mapping import MappingStatus, OccupancyGrid
from pilotage_schemas.message import Message, Part
from pilotage_schemas.planning import PlanningStatus, VelocityCommand
from pilotage_schemas.sensors import (
    LaserScan,
    Odometry,
    RobotDescription,
    RobotStatus,
    SensorMount,
)

TWINS = draw(
    """
    ######################
    #......#......#......#
    #......#......#......#
    #......#......#......#
    #......#......#......#
    #...#..#...#..#......#
    #...#..#...#..#......#
    ##..######..###......#
    #....................#
    #....................#
    #....................#
    ######################
    """,
    resolution=0.25,
)
"""Two rooms alike, with doors to a corridor that has one more niche at its end."""

ANGLES = np.linspace(-2.35, 2.35, 95)
REACH = 8.0
SAID_OF_STILL = np.eye(3) * 1e-4


def pose2(pose: np.ndarray) -> Pose2:
    return Pose2(x=float(pose[0]), y=float(pose[1]), theta=float(pose[2]))


@dataclass
class Bench:
    """The planner, the robot it drives, and a localizer that says what a test wants."""

    folder: Path | None = None
    settings: PlannerSettings = field(default_factory=PlannerSettings)
    world: OccupancyMap = TWINS
    pose: np.ndarray = field(default_factory=lambda: np.array([3.0, 0.6, 0.0]))
    places: list[np.ndarray] = field(default_factory=list)
    """Where else the robot could be, to its localizer."""
    state: str = "localized"
    commands: tuple[str, ...] = ("velocity", "stop", "wander")
    source: str = "simulation"
    orders: int = 0
    is_held: bool = False
    silent: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.fabric, self.clock = FakeFabric(), HandClock()
        self.odom, self.speeds = np.array([7.0, -3.0, 2.0]), (0.0, 0.0)
        self.nodes = {
            name: Node(name, "demo", self.fabric, self.clock)
            for name in ("robot", "mapper", "localizer", "gateway")
        }
        self.heard: dict[str, list[Any]] = {}
        for topic in ("velocity_command", "goal", "path", "plan", "potential", "planning_status"):
            self.heard[topic] = []
            self.nodes["gateway"].subscribe(topic, self.heard[topic].append)
        self.nodes["gateway"].subscribe("gaze_command", self.heard.setdefault("gaze", []).append)
        self.begin_planner()

    def begin_planner(self) -> None:
        self.node = Node("planner", "demo", self.fabric, self.clock)
        self.planner = PlannerService(self.settings, self.node, Deployment(run_dir=self.folder))
        self.fabric.pump = self._step

    def _step(self) -> None:
        self.node.step()

    def put(self, by: str, topic: str, message: Message) -> None:
        self.nodes[by].publisher(topic).publish(message)
        self.node.step()

    def begin(self) -> None:
        """Say all that a planner has to hear."""
        self.describe()
        self.say_status()
        self.put_map()
        self.run(0.3)

    def describe(self) -> None:
        mount = SensorMount(frame_id="laser", kind="laser", pose=pose2(np.zeros(3)))
        corners = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
        footprint = 0.15 * np.stack([np.cos(corners), np.sin(corners)], axis=1)
        description = RobotDescription(
            stamp_ns=self.clock.now_ns(),
            frame_id="base_link",
            name="Toy",
            driver="toy",
            footprint=footprint.astype(np.float32),
            mounts=(mount,),
            max_linear=0.5,
            max_angular=1.5,
            commands=self.commands,
        )
        self.put("robot", "description", description)

    def say_status(self) -> None:
        status = {
            "stamp_ns": self.clock.now_ns(),
            "frame_id": "base_link",
            "source": self.source,
            "mode": "stopped",
            "reason": "stopped by command",
            "orders": self.orders,
            "is_held": self.is_held,
        }
        self.put("robot", "status", RobotStatus.model_validate(status))

    def put_map(self, map_id: str = "twins", *, in_progress: bool = False) -> None:
        geometry = self.world.geometry
        grid = OccupancyGrid(
            stamp_ns=self.clock.now_ns(),
            frame_id="map",
            map_id=map_id,
            name="twins",
            resolution=geometry.resolution,
            origin=Pose2(x=0.0, y=0.0, theta=0.0),
            cells=self.world.cells,
            in_progress=in_progress,
        )
        self.map_id = map_id
        self.put("mapper", "map", grid)

    def say_mapping(self, mode: str) -> None:
        status = {"stamp_ns": self.clock.now_ns(), "frame_id": "map", "mode": mode}
        self.put("mapper", "mapping_status", MappingStatus.model_validate(status))

    def run(self, seconds: float) -> None:
        """Let the robot drive, and everybody say where it is."""
        for _ in range(round(10.0 * seconds)):
            self.clock.advance(0.1)
            before = self.pose
            self.pose = arc(self.pose, *self.speeds, 0.1)
            self.odom = se2.compose(self.odom, se2.between(before, self.pose))
            self.places = [arc(place, *self.speeds, 0.1) for place in self.places]
            self._say_all()
            self.node.step()
            self._obey()

    def _obey(self) -> None:
        sent = len(self.heard["velocity_command"])
        self.nodes["gateway"].step()
        new: list[VelocityCommand] = self.heard["velocity_command"][sent:]
        for command in new:
            if command.orders == self.orders:
                self.speeds = command.twist.vx, command.twist.omega
                self.is_held = False

    def _say_all(self) -> None:
        stamp = {"stamp_ns": self.clock.now_ns()}
        if "odometry" not in self.silent:
            odometry = Odometry(
                **stamp,
                frame_id="odom",
                pose=pose2(self.odom),
                twist=Twist2(vx=0.0, vy=0.0, omega=0.0),
                covariance=np.eye(3),
            )
            self.put("robot", "odometry", odometry)
        if "scan" not in self.silent:
            self.put("robot", "scan", self._scan())
        if "pose" not in self.silent:
            estimate = {
                "frame_id": "map",
                "pose": pose2(self.pose),
                "covariance": SAID_OF_STILL,
                "state": self.state,
                "confidence": 0.5,
            }
            self.put("localizer", "pose", PoseEstimate.model_validate(stamp | estimate))
            self.put("localizer", "belief", self._belief())

    def _scan(self) -> LaserScan:
        ranges = cast_scan(self.world, self.pose, ANGLES, REACH)
        return LaserScan(
            stamp_ns=self.clock.now_ns(),
            frame_id="laser",
            angle_min=float(ANGLES[0]),
            angle_increment=float(ANGLES[1] - ANGLES[0]),
            range_min=0.05,
            range_max=REACH,
            ranges=ranges.astype(np.float32),
        )

    def _belief(self) -> Belief:
        poses = np.array([self.pose, *self.places])
        weights = np.full((len(poses), 1), 1.0 / len(poses))
        return Belief(
            stamp_ns=self.clock.now_ns(),
            frame_id="map",
            map_id=self.map_id,
            method="toy",
            samples=np.hstack([poses, weights]).astype(np.float32),
            entropy=float(np.log2(len(poses))),
            modes=tuple(
                Mode(mass=1.0 / len(poses), pose=pose2(pose), covariance=SAID_OF_STILL)
                for pose in poses
            ),
        )

    def ask(self, query: str, request: Part) -> Any:  # noqa: ANN401 - the reply of any query
        return self.nodes["gateway"].ask(query, request)

    @property
    def mode(self) -> str:
        """What the planner says that it is about."""
        return self.status.mode

    @property
    def status(self) -> PlanningStatus:
        """What the planner has said last."""
        self.nodes["gateway"].step()
        status = self.heard["planning_status"][-1]
        assert isinstance(status, PlanningStatus)
        return status

    @property
    def velocities(self) -> list[VelocityCommand]:
        """All that the planner has sent."""
        self.nodes["gateway"].step()
        return self.heard["velocity_command"]
