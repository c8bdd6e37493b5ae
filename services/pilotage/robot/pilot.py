"""Who drives now: nobody, a commanded motion, a velocity command, or the wanderer; pure.

Times are seconds of a clock that never goes backwards; poses are (3,), base_link in odom.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from pilotage.core.laser_view import View
from pilotage.robot.motion_command import Motion
from pilotage.robot.wander import Wanderer
from pilotage.robot.watchdog import AT_REST, CommandWatch, Limits, SensorWatch, Speeds

Mode = Literal["wandering", "commanded", "stopped"]

BUMPER_CONE = np.deg2rad(100.0)
"""A contact within this angle of the direction of travel ends a motion."""


@dataclass
class Pilot:
    """Decides the speeds; `mode` and `reason` say what it does and why.

    `relied_on`: sensors without which the robot does not move by itself. `orders` counts what
    people told it; it `is_held` from such an order on until it drives by itself again.
    """

    limits: Limits
    sensors: SensorWatch
    relied_on: tuple[str, ...]
    wanderer: Wanderer | None
    commands: CommandWatch = field(default_factory=CommandWatch)
    mode: Mode = "stopped"
    reason: str = "waiting for a command"
    orders: int = 0
    is_held: bool = False
    _speeds: Speeds = AT_REST
    _wanted: Speeds = AT_REST
    _motion: Motion | None = None
    _relies_on_sensors: bool = True
    _pose: ArrayLike | None = None
    _view: tuple[View, float] | None = None
    _looked: float = -np.inf
    _contact: float | None = None
    _is_paused: bool = False
    _wandered_before: bool = False

    def hear_odometry(self, pose: ArrayLike, now: float) -> None:
        """Take the newest odometry."""
        self._pose = pose
        self.sensors.hear("odometry", now)

    def hear_scan(self, view: View, now: float) -> None:
        """Take the newest scan."""
        self._view = view, now
        self.sensors.hear("scan", now)

    def hear_bumper(self, bearing: float | None, *, is_pressed: bool) -> None:
        """Take the bumper's state; an unknown bearing counts as straight ahead."""
        self._contact = (bearing or 0.0) if is_pressed else None

    def take_order(self, *, is_held: bool) -> None:
        """Note that a person decides what happens now: what a program did before is over."""
        self.orders += 1
        self.is_held = is_held
        self._wandered_before = False

    def move(self, motion: Motion) -> None:
        """Carry out a motion from now on."""
        self._motion = motion
        self._relies_on_sensors = True
        self._become("commanded", motion.name)

    def obey(self, speeds: Speeds, now: float, *, by_itself: bool) -> None:
        """Drive with these speeds until the next such command, at most 0.5 s.

        `by_itself`: a program sends them, which relies on the sensors; a person sees for himself.
        """
        self.commands.feed(now)
        if by_itself:
            self.is_held = False
            self._wandered_before |= self.mode == "wandering" or self._is_paused
        self._motion, self._wanted = None, speeds
        self._relies_on_sensors = by_itself
        self._become("commanded", "velocity command")

    def release(self, *, resume: bool) -> None:
        """Drive no longer by velocities of a program; `resume` what was done before them."""
        if resume and self._wandered_before:
            self.wander()
        elif self.mode == "commanded" and self._motion is None and self._relies_on_sensors:
            self.stop("at the end of its way")
        self._wandered_before = False

    def wander(self) -> None:
        """Wander from now on; needs a wanderer."""
        self._motion = None
        self._relies_on_sensors = True
        self._become("wandering", "going about by itself")

    def stop(self, reason: str) -> None:
        """Stand still from now on."""
        self._motion = None
        self._become("stopped", reason)

    def step(self, now: float, dt: float) -> Speeds | None:
        """Return the speeds to drive with for the next `dt` s; None: stand still at once."""
        self._check_sensors(now)
        self._check_sender(now)
        intended = self._intended(now)
        if intended is None:
            self._speeds = AT_REST
            return None
        self._speeds = self.limits.applied(intended, self._speeds, dt)
        return self._speeds

    def _check_sensors(self, now: float) -> None:
        """Stand while a sensor is silent; a wanderer goes on when it is heard again."""
        if self.mode == "stopped" and not self._is_paused:
            return
        silent = self.sensors.silent(self.relied_on, now) if self._relies_on_sensors else None
        if silent is None and self._is_paused:
            self.wander()
        elif silent is not None and self.mode != "stopped":
            was_wandering = self.mode == "wandering"
            self.stop(f"no {silent} for {self.sensors.limits[silent]:g} s")
            self._is_paused = was_wandering

    def _check_sender(self, now: float) -> None:
        """Stand when the sender of velocities has fallen silent."""
        is_velocity = self.mode == "commanded" and self._motion is None
        if is_velocity and self.commands.is_silent(now):
            self.stop(f"no velocity command for {self.commands.timeout:g} s")

    def _intended(self, now: float) -> Speeds | None:
        """Return what whoever drives now wants; None: nobody drives."""
        match self.mode:
            case "stopped":
                return None
            case "wandering":
                return self._wandered()
            case _:
                return self._wanted if self._motion is None else self._moved(self._motion, now)

    def _moved(self, motion: Motion, now: float) -> Speeds | None:
        """Go on with a motion, to its end or until it runs into something."""
        if self._pose is None:
            return AT_REST
        progress = motion.advance(self._pose, now)
        if self._runs_into_something(progress.speeds):
            self.stop(f"{motion.name}: ran into something")
            return None
        if progress.ended is not None:
            self.stop(progress.ended)
            return None
        return progress.speeds

    def _wandered(self) -> Speeds:
        """Ask the wanderer after each scan; keep its speeds in between."""
        if self.wanderer is None or self._view is None or self._pose is None:
            return AT_REST
        view, seen = self._view
        if seen > self._looked:
            dt = min(seen - self._looked, 1.0)
            self._looked = seen
            if self._contact is not None:
                view = view.with_contact(self._contact)
            self._wanted = self.wanderer.step(view, self._pose, dt)
        return self._wanted

    def _runs_into_something(self, speeds: Speeds) -> bool:
        if self._contact is None or speeds[0] == 0.0:
            return False
        return bool(np.cos(self._contact) * np.sign(speeds[0]) > np.cos(BUMPER_CONE / 2.0))

    def _become(self, mode: Mode, reason: str) -> None:
        if mode != "commanded":
            self._wanted = AT_REST
        self._is_paused = False
        self.mode, self.reason = mode, reason
