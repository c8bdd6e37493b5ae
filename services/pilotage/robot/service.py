"""The robot on the bus: what its driver senses goes out, commands come in and are checked."""

import contextlib
import time
from collections.abc import Callable

import numpy as np

from pilotage.bus.deployment import Deployment
from pilotage.bus.node import Node
from pilotage.bus.runner import complain
from pilotage.robot.commands import RobotCommands
from pilotage.robot.config import RobotSettings
from pilotage.robot.driver import (
    DriverError,
    Kidnappable,
    Measurement,
    Playback,
)
from pilotage.robot.driver_choice import make_driver
from pilotage.robot.pilot_setup import laser_mount, make_pilot, view_of
from pilotage.robot.storage import load_place, save_place
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.sensors import (
    Bumper,
    GroundTruth,
    LaserScan,
    Odometry,
    RobotStatus,
)
from pilotage_schemas.topics import TOPICS

PERIOD = 0.02
"""s between two looks at the driver: a stop is late by at most this much."""
STATUS_PERIOD = 0.5
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
        self.node = node
        self._wait = wait
        self._settings = settings
        self._folder = deployment.run_dir
        self._place: Pose2 | None = None
        with node.busy(30.0):
            self.driver = make_driver(settings)
            self._return_to_its_place()
            self.description = self.driver.describe()
        self._mount = laser_mount(self.description)
        self._odometry: Odometry | None = None
        self._stood: tuple[str, str, int] | None = None
        self._out = {t.name: node.publisher(t.name) for t in TOPICS.values() if t.owner == "robot"}
        self.pilot = make_pilot(settings, self.description)

    def begin(self) -> None:
        """Announce the robot, answer commands, and look at the driver 50 times a second."""
        now = self.node.clock.monotonic()
        for topic in self.pilot.sensors.limits:
            self.pilot.sensors.hear(topic, now)
        self._out["description"].publish(
            self.description.model_copy(update={"stamp_ns": self.node.clock.now_ns()})
        )
        if self._wanders_from_the_start():
            self.pilot.wander()
        RobotCommands(self, self._wait).answer()
        self.node.every(PERIOD, self.step)
        self.node.every(STATUS_PERIOD, self.publish_status)
        self.node.every(STATUS_PERIOD, self._keep_its_place)
        self.step()

    def step(self) -> None:
        """Pass on what was sensed, then drive on."""
        self.sense()
        if not isinstance(self.driver, Playback):
            self._drive_on()
        if self._stood != (*self._mode_and_reason(), self.pilot.orders):
            self.publish_status()

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
            self.node.warn("storage", f"the robot's place cannot be kept: {error.strerror}")

    def sense(self) -> None:
        """Pass on what the driver has measured."""
        try:
            for measurement in self.driver.sense(self.node.clock.now_ns()):
                self._pass_on(measurement)
        except DriverError as error:
            self.node.warn("driver", str(error))
            self.pilot.stop(f"driver: {error}")

    def _pass_on(self, measurement: Measurement) -> None:
        publisher = self._out.get(measurement.topic)
        topic = TOPICS.get(measurement.topic)
        if publisher is None or topic is None or not isinstance(measurement.message, topic.message):
            kind = type(measurement.message).__name__
            self.node.warn("driver", f"a {kind} does not go out by topic {measurement.topic!r}")
            return
        publisher.publish(measurement.message)
        self._heed(measurement.message)

    def _heed(self, message: object) -> None:
        """Let the pilot know what it steers by."""
        now = self.node.clock.monotonic()
        match message:
            case Odometry(pose=pose):
                self._odometry = message
                self.pilot.hear_odometry(np.array([pose.x, pose.y, pose.theta]), now)
            case LaserScan() if self._mount is not None:
                self.pilot.hear_scan(view_of(message, self._mount), now)
            case GroundTruth(pose=pose):
                self._place = pose
            case Bumper():
                self.pilot.hear_bumper(message.bearing, is_pressed=message.pressed)

    def _drive_on(self) -> None:
        try:
            self.drive()
        except DriverError as error:
            self.node.warn("driver", str(error))
            self.pilot.stop(f"driver: {error}")

    def drive(self) -> None:
        """Hand the pilot's speeds to the driver; DriverError."""
        speeds = self.pilot.step(self.node.clock.monotonic(), PERIOD)
        if speeds is None:
            self.driver.stop()
        else:
            self.driver.drive(Twist2(vx=speeds[0], vy=0.0, omega=speeds[1]))

    def stands_since(self, begun_ns: int) -> bool:
        """Say whether odometry measured after this time shows that the robot stands."""
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

    def publish_status(self) -> None:
        """Say what the robot does and why."""
        mode, reason = self._mode_and_reason()
        self._stood = mode, reason, self.pilot.orders
        playback = self.driver if isinstance(self.driver, Playback) else None
        is_simulated = isinstance(self.driver, Kidnappable)
        self._out["status"].publish(
            RobotStatus.model_validate(
                {
                    "stamp_ns": self.node.clock.now_ns(),
                    "frame_id": "base_link",
                    "source": "replay" if playback else "simulation" if is_simulated else "live",
                    "mode": mode,
                    "reason": reason[:2000],
                    "speed_factor": playback.speed_factor if playback else 1.0,
                    "progress": playback.progress if playback else None,
                    "orders": self.pilot.orders,
                    "is_held": self.pilot.is_held,
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
