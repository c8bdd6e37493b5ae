"""Where the last measurement was taken, and how new that makes the next one.

A measurement from where the last one was taken says the same again: it may not sharpen the belief
any more. So none is weighed before the robot has moved or waited (`is_due`), and one that is
weighed counts by how far it has moved (`novelty`). The same for every method.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.localizer.estimate import Memory
from pilotage.localizer.method import Belief
from pilotage.localizer.modes import apart

STANDING = 0.1
"""Novelty of a measurement from the same place: people move, the noise is new."""


class Pace(Protocol):
    """What a method's parameters say of how often to measure, see MarkovParams."""

    @property
    def update_way(self) -> float:
        """Way [m] after which a measurement is due."""
        ...

    @property
    def update_turn(self) -> float:
        """Turn [rad] after which a measurement is due."""
        ...

    @property
    def update_after(self) -> float:
        """Time [s] after which a measurement is due even if the robot stands."""
        ...


@dataclass(frozen=True)
class Novelty:
    """How much of a new measurement one is, 0 to 1, for a scan and for what sees a direction.

    Few rangers see something else after a small turn, a laser the same from elsewhere.
    """

    of_scan: float = 1.0
    of_ranges: float = 1.0


class LastMeasurement:
    """Remembers odometry (3,) and stamp [Unix ns] of the last measurement, if there was one."""

    def __init__(self, pace: Pace) -> None:
        self._pace = pace
        self.forget()

    def forget(self) -> None:
        """Begin anew: nothing has been measured."""
        self._odom_from_base: NDArray[np.float64] | None = None
        self._stamp_ns = 0
        self._is_first = True
        self._unseen = 0.0, 0.0

    def note_nothing(self, stamp_ns: int, odom_from_base: NDArray[np.float64]) -> None:
        """Nothing was to be seen here: what comes next is as new as if nobody had looked."""
        way, turn = apart(self.increment_to(odom_from_base), np.zeros(3))
        self._unseen = self._unseen[0] + way, self._unseen[1] + turn
        self._odom_from_base, self._stamp_ns = odom_from_base.copy(), stamp_ns

    def note(self, stamp_ns: int, odom_from_base: NDArray[np.float64]) -> None:
        """Take what has just been measured here for the last measurement."""
        self._unseen = 0.0, 0.0
        self._odom_from_base, self._stamp_ns = odom_from_base.copy(), stamp_ns
        self._is_first = False

    def restart_odometry(self) -> None:
        """Odometry counts from a new origin: how far the robot has come is not known."""
        self._odom_from_base = None

    def resume(self, memory: Memory) -> None:
        """Go on from the last measurement of an earlier run."""
        self.note(memory.stamp_ns, memory.odom_from_base)

    def memory(self, belief: Belief, most: int, *, was_localized: bool) -> Memory | None:
        """Return what `resume` needs, with `most` states; None without a measurement."""
        if self._odom_from_base is None:
            return None
        states = belief.heaviest(most)
        return Memory(*states, self._odom_from_base, self._stamp_ns, was_localized)

    def increment_to(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the motion (3,) since, in the robot's frame of then; none if it is not known."""
        if self._odom_from_base is None:
            return np.zeros(3)
        return se2.between(self._odom_from_base, odom_from_base)

    def is_due(self, stamp_ns: int, odom_from_base: NDArray[np.float64]) -> bool:
        """Say whether the robot has moved or waited for long enough to measure again."""
        if self._odom_from_base is None:
            return True
        way, turn = apart(self.increment_to(odom_from_base), np.zeros(3))
        moved = way / self._pace.update_way + turn / self._pace.update_turn
        waited = (stamp_ns - self._stamp_ns) / 1e9
        return moved >= 1.0 or not 0.0 <= waited < self._pace.update_after

    def novelty(self, increment: NDArray[np.float64]) -> Novelty:
        """Return how much of a new measurement is one after this motion (3,).

        A turn by half a circle brings everything that a laser sees into view anew.
        """
        if self._is_first:
            return Novelty()
        way, turn = np.add(apart(increment, np.zeros(3)), self._unseen)
        moved = way / self._pace.update_way
        of_scan = min(1.0, max(moved + turn / np.pi, STANDING))
        return Novelty(of_scan, min(1.0, max(moved + turn / self._pace.update_turn, STANDING)))
