"""What may be asked of the robot: each command is carried out, or refused with the reason."""

from collections.abc import Callable
from typing import Protocol

from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.robot.driver import (
    LOG_REFUSAL,
    DriverError,
    Gazeable,
    Kidnappable,
    Playback,
    RobotDriver,
)
from pilotage.robot.motion_command import Motion, Straight, Turn
from pilotage.robot.pilot import Pilot
from pilotage_schemas import commands as c
from pilotage_schemas.geometry import Twist2
from pilotage_schemas.planning import GazeCommand, VelocityCommand
from pilotage_schemas.sensors import RobotDescription

LOOK_PERIOD = 0.005
"""s between two looks whether the robot stands."""
STANDING_WITHIN = 0.5
"""s that a robot may take to stand before `stop` says that it does not."""


class Robot(Protocol):
    """What the commands need of the service."""

    node: Node
    driver: RobotDriver
    description: RobotDescription
    pilot: Pilot

    def sense(self) -> None:
        """Pass on what the driver has measured."""
        ...

    def drive(self) -> None:
        """Hand the pilot's speeds to the driver; DriverError."""
        ...

    def publish_status(self) -> None:
        """Say what the robot does and why."""
        ...

    def stands_since(self, begun_ns: int) -> bool:
        """Say whether odometry measured after this time shows that the robot stands."""
        ...


class RobotCommands:
    """Answers the robot's queries and hears the planner; `wait(s)` lets time pass."""

    def __init__(self, robot: Robot, wait: Callable[[float], None]) -> None:
        self._robot = robot
        self._wait = wait

    def answer(self) -> None:
        """Answer from now on."""
        node = self._robot.node
        node.answer("forward", lambda r: self._move("forward", Straight(r.distance, r.speed)))
        node.answer("backward", lambda r: self._move("backward", Straight(-r.distance, r.speed)))
        node.answer("turn", lambda r: self._move("turn", Turn(r.angle, r.rate)))
        node.answer("velocity", self._velocity)
        node.answer("stop", self._stop)
        node.answer("wander", self._wander)
        node.answer("kidnap", self._kidnap)
        node.subscribe("velocity_command", self._hear_velocity)
        node.subscribe("gaze_command", self._hear_gaze)

    def _move(self, name: str, motion: Motion) -> c.Done:
        self._require(name)
        self._robot.pilot.move(motion)
        self._take_order(is_held=True)
        self._drive_or_refuse()
        return c.Done(detail=motion.name)

    def _velocity(self, request: c.Velocity) -> c.Done:
        self._require("velocity")
        self._require_straight(request.twist)
        self._obey(request.twist, by_itself=False)
        self._take_order(is_held=True)
        self._drive_or_refuse()
        return c.Done()

    def _hear_velocity(self, command: VelocityCommand) -> None:
        """Obey a program, unless a person has said something since that it does not know of."""
        pilot = self._robot.pilot
        if command.orders not in (None, pilot.orders):
            return
        try:
            self._require("velocity")
            self._require_straight(command.twist)
        except RefusedError as error:
            self._robot.node.warn("velocity_command", str(error))
            return
        if command.then == "more":
            self._obey(command.twist, by_itself=True)
        else:
            pilot.release(resume=command.then == "resume")

    def _require_straight(self, twist: Twist2) -> None:
        if twist.vy != 0.0:
            raise RefusedError("this robot cannot move sideways: vy must be 0")

    def _hear_gaze(self, command: GazeCommand) -> None:
        driver = self._robot.driver
        try:
            self._require("look")
            if isinstance(driver, Gazeable):
                driver.look(command.pan)
        except (RefusedError, DriverError) as error:
            self._robot.node.warn("gaze_command", str(error))

    def _obey(self, twist: Twist2, *, by_itself: bool) -> None:
        now = self._robot.node.clock.monotonic()
        self._robot.pilot.obey((twist.vx, twist.omega), now, by_itself=by_itself)

    def _stop(self, _request: c.Nothing) -> c.Stopped:
        """Stop, and reply when the odometry says that the robot stands."""
        begun, begun_ns = self._robot.node.clock.monotonic(), self._robot.node.clock.now_ns()
        self._require("stop")
        self._robot.pilot.stop("stopped by command")
        self._take_order(is_held=True)
        self._drive_or_refuse()
        while not self._robot.stands_since(begun_ns):
            if self._robot.node.clock.monotonic() - begun > STANDING_WITHIN:
                raise RefusedError(f"the robot was told to, but still moves {STANDING_WITHIN} s on")
            self._wait(LOOK_PERIOD)
            self._robot.sense()
        return c.Stopped(after=self._robot.node.clock.monotonic() - begun)

    def _wander(self, request: c.Wander) -> c.Done:
        self._require("wander")
        if request.enabled and self._robot.pilot.wanderer is None:
            raise RefusedError("wandering needs a laser, and this robot has none")
        if request.enabled:
            self._robot.pilot.wander()
        elif self._robot.pilot.mode == "wandering":
            self._robot.pilot.stop("told to wander no longer")
        self._take_order(is_held=not request.enabled)
        self._drive_or_refuse()
        return c.Done(detail=self._robot.pilot.reason)

    def _kidnap(self, request: c.Kidnap) -> c.Kidnapped:
        if not isinstance(self._robot.driver, Kidnappable):
            raise RefusedError("only a simulated robot can be carried away by a command")
        try:
            pose = self._robot.driver.kidnap(request.pose)
        except DriverError as error:
            raise RefusedError(str(error)) from error
        if self._robot.pilot.mode == "commanded":
            self._robot.pilot.stop("carried away")
        return c.Kidnapped(pose=pose)

    def _take_order(self, *, is_held: bool) -> None:
        """Let programs know at once that a person decides now, and what is done from now on."""
        self._robot.pilot.take_order(is_held=is_held)
        self._robot.publish_status()

    def _require(self, name: str) -> None:
        """Refuse a command that this robot does not have."""
        if isinstance(self._robot.driver, Playback):
            raise RefusedError(LOG_REFUSAL)
        if name not in self._robot.description.commands:
            raise RefusedError(f"{self._robot.description.name} has no command {name}")

    def _drive_or_refuse(self) -> None:
        try:
            self._robot.drive()
        except DriverError as error:
            self._robot.pilot.stop(f"driver: {error}")
            raise RefusedError(str(error)) from error
