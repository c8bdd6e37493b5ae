"""What odometry can tell: whether the robot stands, stopped, or went back.

Encoders of one channel count a way whatever its direction, so that a robot that backs off seems to
go ahead (Freiburg 079 was recorded so). Odometry that has told of a way back once is not of these;
with the others, who has not stopped has not turned back.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2


@dataclass(frozen=True)
class SenseParams:
    """Where motion begins."""

    way: float = 0.04
    """m; with less, and less `turn`, a scan shows nothing new."""
    turn: float = 0.05
    """rad, the same."""
    back: float = 0.01
    """m between two scans that are a way back."""
    stop: float = 0.1
    """m/s; slower is nearly standing."""
    after_stop: tuple[float, float] = (0.2, 0.5)
    """Chances to go back, and ahead again, after a stop of a robot whose odometry has no sign."""
    without_stop: tuple[float, float] = (0.005, 0.02)
    """The same without a stop that was noticed."""


@dataclass(frozen=True, eq=False)
class OdometryStep:
    """An increment (3,) and the chances that it leads `back` though it seems to lead ahead.

    `ahead` is the chance that it does not if the one before did.
    """

    increment: NDArray[np.float64]
    back: float
    ahead: float


class OdometrySense:
    """Odometry from scan to scan, told in steps that are worth a scan."""

    def __init__(self, params: SenseParams) -> None:
        self._params = params
        self._last: tuple[float, NDArray[np.float64]] | None = None
        self._since: NDArray[np.float64] | None = None
        self.is_signed = False
        """A way back has been told: odometry knows directions."""
        self._has_stopped = False

    def step(self, stamp: float, odom: NDArray[np.float64]) -> OdometryStep | None:
        """Return the step since the last one if odometry (3,) has gone on by one.

        The first one is zero.
        """
        if self._last is None or self._since is None:
            self._last, self._since = (stamp, odom), odom
            return OdometryStep(np.zeros(3), 0.0, 1.0)
        little = se2.between(self._last[1], odom)
        way, time = float(np.hypot(little[0], little[1])), stamp - self._last[0]
        self.is_signed |= bool(little[0] < -self._params.back)
        self._has_stopped |= way < self._params.stop * time
        self._last = stamp, odom
        step = se2.between(self._since, odom)
        if np.hypot(step[0], step[1]) < self._params.way and abs(step[2]) < self._params.turn:
            return None
        back, ahead = self._chances()
        self._since, self._has_stopped = odom, False
        return OdometryStep(step, back, ahead)

    def go_on(self, stamp: float, odom: NDArray[np.float64], *, is_signed: bool) -> None:
        """Begin with a step to odometry (3,) done."""
        self._last, self._since, self.is_signed = (stamp, odom), odom, is_signed

    def _chances(self) -> tuple[float, float]:
        if self.is_signed:
            return 0.0, 1.0
        params = self._params
        return params.after_stop if self._has_stopped else params.without_stop
