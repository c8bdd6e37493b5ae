"""The robot on the bus: what its driver senses goes out, commands come in and are checked."""

import contextlib
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pilotage.bus.deployment import Deployment
from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.bus.runner import complain
from pilotage.robot.config import RobotSettings
from pilotage.robot.driver import (
    LOG_REFUSAL,
    DriverError,
    Kidnappable,
    Measurement,
    Playback,
)
from pilotage.robot.driver_choice import make_driver
from pilotage.robot.motion_command import Motion, Straight, Turn
from pilotage.robot.pilot import Pilot
from pilotage.robot.storage import load_place, save_place
from pilotage.robot.wander import View, Wanderer, WanderParams
from pilotage.robot.watchdog import CommandWatch, Limits, SensorWatch
from pilotage_schemas import commands as c
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.planning import VelocityCommand
from pilotage_schemas.sensors import (
    Bumper,
    GroundTruth,
    LaserScan,
    Odometry,
    RobotDescription,
    RobotStatus,
)
from pilotage_schemas.topics import TOPICS

PERIOD = 0.02
"""s between two looks at the driver: a stop is late by at most this much."""
STATUS_PERIOD = 0.5
STANDING_WITHIN = 0.5
"""s that a robot may take to stand before `stop` says that it does not."""
STILL = 0.01
"""m/s and rad/s below which a robot stands."""


class RobotService:
    """Glue between a driver, the pilot and the bus; `begin` comes after the driver is open."""

    def __init__(
        self,
        settings: RobotSettings,
        node: Node,
        deployment: Deployment,
        wait: Callable[[float], None] = time.sleep,
    ) -> None:
        self._node = node
        self._wait = wait
        self._settings = settings
        self._folder = deployment.run_dir
        self._place: Pose2 | None = None
        with node.busy(30.0):
            self.driver = make_driver(settings)
            self._return_to_its_place()
            self._description = self.driver.describe()
        self._mount = _laser_mount(self._description)
        self._odometry: Odometry | None = None
        self._stood: tuple[str, str] | None = None
        self._out = {t.name: node.publisher(t.name) for t in TOPICS.values() if t.owner == "robot"}
        self.pilot = _make_pilot(settings, self._description)

    def begin(self) -> None:
        """Announce the robot, answer commands, and look at the driver 50 times a second."""
        now = self._node.clock.monotonic()
        for topic in self.pilot.sensors.limits:
            self.pilot.sensors.hear(topic, now)
        self._out["description"].publish(
            self._description.model_copy(update={"stamp_ns": self._node.clock.now_ns()})
        )
        if self._wanders_from_the_start():
            self.pilot.wander()
        self._answer_commands()
        self._node.every(PERIOD, self.step)
        self._node.every(STATUS_PERIOD, self._publish_status)
        self._node.every(STATUS_PERIOD, self._keep_its_place)
        self.step()

    def step(self) -> None:
        """Pass on what was sensed, then drive on."""
        self._sense()
        if not isinstance(self.driver, Playback):
            self._drive_on()
        if self._stood != self._mode_and_reason():
            self._publish_status()

    def _answer_commands(self) -> None:
        node = self._node
        node.answer("forward", lambda r: self._move("forward", Straight(r.distance, r.speed)))
        node.answer("backward", lambda r: self._move("backward", Straight(-r.distance, r.speed)))
        node.answer("turn", lambda r: self._move("turn", Turn(r.angle, r.rate)))
        node.answer("velocity", self._velocity)
        node.answer("stop", self._stop)
        node.answer("wander", self._wander)
        node.answer("kidnap", self._kidnap)
        node.subscribe("velocity_command", self._hear_velocity)

    def _move(self, name: str, motion: Motion) -> c.Done:
        self._require(name)
        self.pilot.move(motion)
        self._drive_or_refuse()
        return c.Done(detail=motion.name)

    def _velocity(self, request: c.Velocity) -> c.Done:
        self._require("velocity")
        self._obey(request.twist, by_itself=False)
        self._drive_or_refuse()
        return c.Done()

    def _hear_velocity(self, command: VelocityCommand) -> None:
        try:
            self._require("velocity")
            self._obey(command.twist, by_itself=True)
        except RefusedError as error:
            self._node.warn("velocity_command", str(error))

    def _obey(self, twist: Twist2, *, by_itself: bool) -> None:
        if twist.vy != 0.0:
            raise RefusedError("this robot cannot move sideways: vy must be 0")
        now = self._node.clock.monotonic()
        self.pilot.obey((twist.vx, twist.omega), now, by_itself=by_itself)

    def _stop(self, _request: c.Nothing) -> c.Stopped:
        """Stop, and reply when the odometry says that the robot stands."""
        begun, begun_ns = self._node.clock.monotonic(), self._node.clock.now_ns()
        self._require("stop")
        self.pilot.stop("stopped by command")
        self._drive_or_refuse()
        while not self._stands_since(begun_ns):
            if self._node.clock.monotonic() - begun > STANDING_WITHIN:
                raise RefusedError(f"the robot was told to, but still moves {STANDING_WITHIN} s on")
            self._wait(PERIOD / 4.0)
            self._sense()
        return c.Stopped(after=self._node.clock.monotonic() - begun)

    def _wander(self, request: c.Wander) -> c.Done:
        self._require("wander")
        if request.enabled and self.pilot.wanderer is None:
            raise RefusedError("wandering needs a laser, and this robot has none")
        if request.enabled:
            self.pilot.wander()
        elif self.pilot.mode == "wandering":
            self.pilot.stop("told to wander no longer")
        self._drive_or_refuse()
        return c.Done(detail=self.pilot.reason)

    def _kidnap(self, request: c.Kidnap) -> c.Kidnapped:
        if not isinstance(self.driver, Kidnappable):
            raise RefusedError("only a simulated robot can be carried away by a command")
        try:
            pose = self.driver.kidnap(request.pose)
        except DriverError as error:
            raise RefusedError(str(error)) from error
        if self.pilot.mode == "commanded":
            self.pilot.stop("carried away")
        return c.Kidnapped(pose=pose)

    def _return_to_its_place(self) -> None:
        """Put a simulated robot where this run's last process left it."""
        place = None if self._folder is None else load_place(self._folder)
        if place is not None and isinstance(self.driver, Kidnappable):
            with contextlib.suppress(DriverError):
                self.driver.kidnap(place)

    def _keep_its_place(self) -> None:
        if self._folder is None or self._place is None:
            return
        try:
            save_place(self._folder, self._place)
        except OSError as error:
            self._node.warn("storage", f"the robot's place cannot be kept: {error.strerror}")

    def _require(self, name: str) -> None:
        """Refuse a command that this robot does not have."""
        if isinstance(self.driver, Playback):
            raise RefusedError(LOG_REFUSAL)
        if name not in self._description.commands:
            raise RefusedError(f"{self._description.name} has no command {name}")

    def _sense(self) -> None:
        try:
            for measurement in self.driver.sense(self._node.clock.now_ns()):
                self._pass_on(measurement)
        except DriverError as error:
            self._node.warn("driver", str(error))
            self.pilot.stop(f"driver: {error}")

    def _pass_on(self, measurement: Measurement) -> None:
        publisher = self._out.get(measurement.topic)
        topic = TOPICS.get(measurement.topic)
        if publisher is None or topic is None or not isinstance(measurement.message, topic.message):
            kind = type(measurement.message).__name__
            self._node.warn("driver", f"a {kind} does not go out by topic {measurement.topic!r}")
            return
        publisher.publish(measurement.message)
        self._heed(measurement.message)

    def _heed(self, message: object) -> None:
        """Let the pilot know what it steers by."""
        now = self._node.clock.monotonic()
        match message:
            case Odometry(pose=pose):
                self._odometry = message
                self.pilot.hear_odometry(np.array([pose.x, pose.y, pose.theta]), now)
            case LaserScan() if self._mount is not None:
                self.pilot.hear_scan(_view(message, self._mount), now)
            case GroundTruth(pose=pose):
                self._place = pose
            case Bumper():
                self.pilot.hear_bumper(message.bearing, is_pressed=message.pressed)

    def _drive_on(self) -> None:
        try:
            self._drive()
        except DriverError as error:
            self._node.warn("driver", str(error))
            self.pilot.stop(f"driver: {error}")

    def _drive_or_refuse(self) -> None:
        try:
            self._drive()
        except DriverError as error:
            self.pilot.stop(f"driver: {error}")
            raise RefusedError(str(error)) from error

    def _drive(self) -> None:
        speeds = self.pilot.step(self._node.clock.monotonic(), PERIOD)
        if speeds is None:
            self.driver.stop()
        else:
            self.driver.drive(Twist2(vx=speeds[0], vy=0.0, omega=speeds[1]))

    def _stands_since(self, begun_ns: int) -> bool:
        if self._odometry is None or self._odometry.stamp_ns < begun_ns:
            return False
        twist = self._odometry.twist
        return max(abs(twist.vx), abs(twist.vy), abs(twist.omega)) < STILL

    def _wanders_from_the_start(self) -> bool:
        wanted = self._settings.wander
        is_wanted = isinstance(self.driver, Kidnappable) if wanted is None else wanted
        return is_wanted and self.pilot.wanderer is not None

    def _mode_and_reason(self) -> tuple[str, str]:
        if isinstance(self.driver, Playback):
            mode = "finished" if self.driver.is_finished else "replaying"
            return mode, self.driver.account
        return self.pilot.mode, self.pilot.reason

    def _publish_status(self) -> None:
        self._stood = mode, reason = self._mode_and_reason()
        playback = self.driver if isinstance(self.driver, Playback) else None
        is_simulated = isinstance(self.driver, Kidnappable)
        self._out["status"].publish(
            RobotStatus.model_validate(
                {
                    "stamp_ns": self._node.clock.now_ns(),
                    "frame_id": "base_link",
                    "source": "replay" if playback else "simulation" if is_simulated else "live",
                    "mode": mode,
                    "reason": reason[:2000],
                    "speed_factor": playback.speed_factor if playback else 1.0,
                    "progress": playback.progress if playback else None,
                }
            )
        )


def live(node: Node, service: RobotService) -> None:
    """Open the driver, run, and close it whatever happens; SystemExit if it cannot be opened."""
    try:
        with service.driver:
            service.begin()
            node.ready()
            node.run()
    except DriverError as error:
        raise SystemExit(complain("robot", error, 1)) from error


def _make_pilot(settings: RobotSettings, description: RobotDescription) -> Pilot:
    has_laser = _laser_mount(description) is not None
    relied_on = ("odometry", "scan") if has_laser else ("odometry",)
    radius = float(np.hypot(*description.footprint.T).max(initial=0.0))
    params = WanderParams(radius=radius)
    rng = np.random.default_rng(settings.seed)
    return Pilot(
        limits=Limits(
            linear=min(settings.max_linear, description.max_linear),
            angular=min(settings.max_angular, description.max_angular),
            acceleration=settings.acceleration,
        ),
        sensors=SensorWatch({name: TOPICS[name].stale_after or 1.0 for name in relied_on}),
        relied_on=relied_on,
        wanderer=Wanderer(params, rng) if has_laser else None,
        commands=CommandWatch(settings.command_timeout),
    )


def _laser_mount(description: RobotDescription) -> NDArray[np.float64] | None:
    """Return the pose (3,) of the laser in base_link, None without one."""
    for mount in description.mounts:
        if mount.kind == "laser":
            return np.array([mount.pose.x, mount.pose.y, mount.pose.theta])
    return None


def _view(scan: LaserScan, mount: NDArray[np.float64]) -> View:
    bearings = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    return View.of(scan.ranges, bearings, mount)
