"""Small worlds, a hand-driven robot and a bench for the robot service."""

from collections.abc import Iterable
from typing import Any, Self

import numpy as np

from drawing import draw
from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import Deployment
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.core.grid import OccupancyMap
from pilotage.core.landmark_map import NO_LANDMARKS, LandmarkMap
from pilotage.robot.config import RobotSettings
from pilotage.robot.driver import DriverError, Measurement
from pilotage.robot.service import RobotService
from pilotage.robot.simulator.drive import SlipParams
from pilotage.robot.simulator.range_sensors import LaserParams, SonarParams
from pilotage.robot.simulator.simulation import RobotParams, Simulation
from pilotage.robot.simulator.walls import Walls
from pilotage.robot.simulator.wheel_odometry import WheelOdometryParams
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.message import Message, Part
from pilotage_schemas.planning import GazeCommand
from pilotage_schemas.sensors import Bumper, LaserScan, Odometry, RobotDescription, SensorMount

EXACT = RobotParams(
    slip=SlipParams(rate=0.0),
    odometry=WheelOdometryParams(0.0, 0.0, 0.0, 0.0, 0.0),
    laser=LaserParams(sigma=0.0, share_without_return=0.0, share_too_short=0.0, mount_x=0.0),
    sonar=SonarParams(sigma=0.0, share_without_echo=0.0),
)
"""A robot without any error."""

DRIVING = ("forward", "backward", "turn", "velocity", "stop", "wander")

ROOM = draw(
    """
    ############
    #..........#
    #..........#
    #..........#
    #..........#
    #..........#
    ############
    """,
    resolution=0.5,
)
"""5 m x 2.5 m inside, its lower left inner corner at (0.5, 0.5)."""


def simulation_in(
    world: OccupancyMap = ROOM,
    pose: tuple[float, float, float] = (1.5, 1.75, 0.0),
    params: RobotParams = EXACT,
    people: int = 0,
    seed: int = 1,
    *,
    landmarks: LandmarkMap = NO_LANDMARKS,
) -> Simulation:
    """A simulated robot in place."""
    rng = np.random.default_rng(seed)
    simulation = Simulation(Walls.of(world), params, people, rng, landmarks)
    simulation.put(np.array(pose))
    return simulation


class ToyRobot:
    """A driver of a robot that obeys at once, has what sensors a test wants, and breaks on demand.

    It moves on at each look; `broken` makes it lose its connection.
    """

    def __init__(self, *, has_laser: bool = True, max_linear: float = 1.0) -> None:
        self.has_laser, self.max_linear = has_laser, max_linear
        self.commands: tuple[str, ...] = DRIVING
        self.twist = Twist2(vx=0.0, vy=0.0, omega=0.0)
        self.pose = np.zeros(3)
        self.silent: set[str] = set()
        self.extra: list[Measurement] = []
        self.broken: str | None = None
        self.refuses: str | None = None
        self.coasts = False
        self.is_open = False
        self.stops = 0
        self._last_ns: int | None = None

    def __enter__(self) -> Self:
        if self.broken:
            raise DriverError(self.broken)
        self.is_open = True
        return self

    def __exit__(self, *_: object) -> None:
        self.is_open = False

    def describe(self) -> RobotDescription:
        origin = Pose2(x=0.0, y=0.0, theta=0.0)
        laser = SensorMount(frame_id="laser", kind="laser", pose=origin)
        return RobotDescription(
            stamp_ns=0,
            frame_id="base_link",
            name="Toy",
            driver="toy",
            footprint=np.array([[0.2, 0.0], [-0.1, 0.1], [-0.1, -0.1]], np.float32),
            mounts=(laser,) if self.has_laser else (),
            max_linear=self.max_linear,
            max_angular=2.0,
            commands=self.commands,
        )

    def sense(self, now_ns: int) -> Iterable[Measurement]:
        if self.broken:
            raise DriverError(self.broken)
        dt = 0.0 if self._last_ns is None else (now_ns - self._last_ns) / 1e9
        if dt == 0.0 and self._last_ns is not None:
            return
        self._last_ns = now_ns
        self.pose[0] += self.twist.vx * dt * np.cos(self.pose[2])
        self.pose[1] += self.twist.vx * dt * np.sin(self.pose[2])
        self.pose[2] = (self.pose[2] + self.twist.omega * dt + np.pi) % (2.0 * np.pi) - np.pi
        if "odometry" not in self.silent:
            yield Measurement("odometry", self._odometry(now_ns))
        if self.has_laser and "scan" not in self.silent:
            yield Measurement("scan", open_scan(now_ns))
        yield from self.extra
        self.extra = []

    def drive(self, twist: Twist2) -> None:
        if self.refuses:
            raise DriverError(self.refuses)
        self.twist = twist

    def stop(self) -> None:
        self.stops += 1
        if not self.coasts:
            self.twist = Twist2(vx=0.0, vy=0.0, omega=0.0)

    def _odometry(self, now_ns: int) -> Odometry:
        x, y, theta = (float(v) for v in self.pose)
        return Odometry(
            stamp_ns=now_ns,
            frame_id="odom",
            pose=Pose2(x=x, y=y, theta=theta),
            twist=self.twist,
            covariance=np.zeros((3, 3)),
        )


class LookingToy(ToyRobot):
    """A toy that can point a camera, unless that is `stuck`."""

    def __init__(self) -> None:
        super().__init__()
        self.commands = (*DRIVING, "look")
        self.pans: list[float] = []
        self.stuck: str | None = None

    def look(self, pan: float) -> None:
        if self.stuck:
            raise DriverError(self.stuck)
        self.pans.append(pan)


def open_scan(stamp_ns: int, distance: float = np.inf) -> LaserScan:
    """A scan over 270 degrees that sees the same distance all round."""
    return LaserScan(
        stamp_ns=stamp_ns,
        frame_id="laser",
        angle_min=-0.75 * np.pi,
        angle_increment=np.pi / 60.0,
        range_min=0.0,
        range_max=10.0,
        ranges=np.full(91, distance, np.float32),
    )


def bump(stamp_ns: int, bearing: float | None = 0.0) -> Measurement:
    message = Bumper(stamp_ns=stamp_ns, frame_id="base_link", pressed=True, bearing=bearing)
    return Measurement("bumper", message)


def toy_bench(**settings: Any) -> tuple["Bench", ToyRobot]:  # noqa: ANN401 - any setting
    """A bench whose robot is a toy, found by its name as a user's driver would be."""
    toy = {key: settings.pop(key) for key in ("has_laser", "max_linear") if key in settings}
    chosen = RobotSettings(driver="robot_world:ToyRobot", driver_settings=toy, **settings)
    bench = Bench(chosen)
    robot = bench.service.driver
    assert isinstance(robot, ToyRobot)
    return bench, robot


class Bench:
    """The robot service on a fake bus, its clock turned by hand, and somebody who asks."""

    def __init__(self, settings: RobotSettings) -> None:
        self.fabric = FakeFabric()
        self.clock = HandClock()
        self.node = Node("robot", "demo", self.fabric, self.clock)
        self.asker = Node("gateway", "demo", self.fabric, self.clock)
        self.planner = Node("planner", "demo", self.fabric, self.clock)
        self.heard: dict[str, list[Any]] = {}
        self.service = RobotService(settings, self.node, Deployment(), self.clock.advance)
        self.fabric.pump = self._answer
        self.service.driver.__enter__()
        self.service.begin()

    def _answer(self) -> None:
        self.node.step()

    def listen(self, topic: str) -> list[Any]:
        """Return a list that fills with what comes by a topic."""
        heard = self.heard.setdefault(topic, [])
        self.asker.subscribe(topic, heard.append)
        self.step()
        return heard

    def ask(self, name: str, request: Part) -> Part:
        return self.asker.ask(name, request)

    def publish_velocity(self, message: Message) -> None:
        self.planner.publisher("velocity_command").publish(message)

    def point(self, pan: float) -> None:
        command = GazeCommand(stamp_ns=self.clock.now_ns(), frame_id="base_link", pan=pan)
        self.planner.publisher("gaze_command").publish(command)
        self.step()

    def step(self) -> None:
        self.node.step()
        self.asker.step()

    def advance(self, seconds: float) -> None:
        """Let time pass in steps of the service's own period."""
        for _ in range(round(seconds / 0.02)):
            self.clock.advance(0.02)
            self.step()
