"""Driving a distance and turning by an angle, closed over the odometry; pure."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from pilotage.core import se2
from pilotage.core.angles import difference
from pilotage.robot.watchdog import AT_REST, Speeds

BRAKING = 0.5
"""m/s^2 and rad/s^2 by which the end is approached."""
SLOWEST = 0.02
"""m/s and rad/s below which motors would stall."""
NEAR_ENOUGH = 0.005
"""m and rad."""
HEADING_GAIN = 2.0
"""rad/s per rad by which a straight way keeps its heading."""
PATIENCE = 2.0
"""s without progress after which a motion is given up."""


@dataclass(frozen=True)
class Progress:
    """The speeds to drive with now; `ended` says how the motion ended, None while it goes on."""

    speeds: Speeds
    ended: str | None = None


class Motion(Protocol):
    """A motion with an end."""

    name: str

    def advance(self, pose: ArrayLike, now: float) -> Progress:
        """Return what to do at the odometry's `pose` (3,) and at time `now` in s."""
        ...


class Straight:
    """Drive `distance` m along the present heading, backwards if negative, at `speed` m/s."""

    def __init__(self, distance: float, speed: float) -> None:
        word = "forward" if distance >= 0.0 else "backward"
        self.name = f"{word} {abs(distance):.2f} m"
        self._distance, self._speed = distance, speed
        self._start: se2.Poses | None = None
        self._patience = _Patience()

    def advance(self, pose: ArrayLike, now: float) -> Progress:
        """Go on, holding the heading of the start."""
        if self._start is None:
            self._start = np.asarray(pose, float)
        moved = se2.between(self._start, pose)
        left = abs(self._distance) - float(moved[0]) * np.sign(self._distance)
        if left <= NEAR_ENOUGH:
            return Progress(AT_REST, f"{self.name}: done")
        if self._patience.is_lost(left, now):
            return Progress(AT_REST, f"{self.name}: blocked {left:.2f} m before the end")
        linear = np.sign(self._distance) * _speed_before_end(self._speed, left)
        return Progress((float(linear), -HEADING_GAIN * float(moved[2])))


class Turn:
    """Turn on the spot by `angle` rad, counter-clockwise positive, at `rate` rad/s."""

    def __init__(self, angle: float, rate: float) -> None:
        self.name = f"turn {np.rad2deg(angle):.0f} degrees"
        self._left, self._rate = angle, rate
        self._last: float | None = None
        self._patience = _Patience()

    def advance(self, pose: ArrayLike, now: float) -> Progress:
        """Go on; more than one full turn is counted rightly."""
        theta = float(np.asarray(pose, float)[2])
        if self._last is not None:
            self._left -= difference(theta, self._last)
        self._last = theta
        if abs(self._left) <= NEAR_ENOUGH:
            return Progress(AT_REST, f"{self.name}: done")
        if self._patience.is_lost(abs(self._left), now):
            return Progress(AT_REST, f"{self.name}: blocked")
        rate = np.sign(self._left) * _speed_before_end(self._rate, abs(self._left))
        return Progress((0.0, float(rate)))


@dataclass
class _Patience:
    """Runs out when what is left has not shrunk for a while."""

    least: float = np.inf
    since: float = 0.0

    def is_lost(self, left: float, now: float) -> bool:
        if left < self.least - NEAR_ENOUGH / 2.0:
            self.least, self.since = left, now
        return now - self.since > PATIENCE


def _speed_before_end(speed: float, left: float) -> float:
    """Return the speed from which one can still stop within what is left."""
    return float(min(speed, max(SLOWEST, np.sqrt(2.0 * BRAKING * left))))
