"""What every method does alike: it measures when that is due, moves, weighs and judges its belief.

How a belief is held, moved and weighed is the method's own.
"""

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.localizer.dead_reckoning import says_nothing
from pilotage.localizer.estimate import Estimate, Memory
from pilotage.localizer.judge import Judge
from pilotage.localizer.last_measurement import LastMeasurement, Novelty, Pace
from pilotage.localizer.measurement import Measurement
from pilotage.localizer.method import Belief
from pilotage.localizer.modes import Mode, find_modes_in_bins


class JudgedMethod(ABC):
    """A method whose belief is judged scan by scan.

    Attributes:
        samples: states of the belief that places are looked for in.
        remembered: states kept in a memory; what they leave out comes back as belief anywhere.
    """

    samples: ClassVar[int]
    remembered: ClassVar[int]

    def __init__(self, judge: Judge, pace: Pace) -> None:
        self._judge = judge
        self._last = LastMeasurement(pace)

    @property
    @abstractmethod
    def belief(self) -> Belief:
        """What is believed now."""

    @abstractmethod
    def _predict(self, increment: NDArray[np.float64]) -> None:
        """Move the belief by odometry's increment (3,)."""

    @abstractmethod
    def _correct(self, measurement: Measurement, novelty: Novelty, *, surprise: bool) -> None:
        """Weigh the belief by a measurement."""

    @property
    def estimate(self) -> Estimate:
        """What was last said."""
        return self._judge.estimate

    def wants(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], measurement: Measurement
    ) -> bool:
        """Say whether a measurement tells more than the last one did: by motion or surprise."""
        is_due = self._last.is_due(stamp_ns, odom_from_base)
        return is_due or self._judge.is_surprised(odom_from_base, measurement)

    def update(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], measurement: Measurement
    ) -> Estimate:
        """Predict up to `odom_from_base` (3,), correct by the measurement, judge the belief."""
        increment = self._last.increment_to(odom_from_base)
        surprise = self._judge.is_surprised(odom_from_base, measurement)
        novelty = Novelty() if surprise else self._last.novelty(increment)
        self._predict(increment)
        if says_nothing(measurement):
            self._last.note_nothing(stamp_ns, odom_from_base)
        else:
            self._last.note(stamp_ns, odom_from_base)
        if not says_nothing(measurement) or measurement.compass is not None:
            self._correct(measurement, novelty, surprise=surprise)
        states = self.belief.heaviest(self.samples)
        return self._judge.judge(odom_from_base, states, measurement, surprise=surprise)

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last estimated pose (3,) moved on by odometry since."""
        return se2.compose(self.estimate.pose, self._last.increment_to(odom_from_base))

    def remember(self) -> Memory | None:
        """Return what `resume` needs, or None before the first measurement."""
        is_localized = self.estimate.state == "localized"
        return self._last.memory(self.belief, self.remembered, was_localized=is_localized)

    def restart_odometry(self) -> None:
        """Odometry counts from a new origin; the belief stays where it is."""
        self._last.restart_odometry()
        self._judge.restart_odometry()

    def _begin(self, modes: list[Mode], *, was_localized: bool = False) -> None:
        """Begin anew with a belief of these modes."""
        self._judge.begin(modes, was_localized=was_localized)
        self._last.forget()

    def _go_on(self, modes: list[Mode], memory: Memory) -> None:
        """Go on with a belief of these modes from the last measurement of a memory."""
        self._begin(modes, was_localized=memory.was_localized)
        self._last.resume(memory)

    def _modes_in_bins(self, size: float, turn: float) -> list[Mode]:
        """Return the modes of a belief that is held in bins so wide [m, rad]."""
        return find_modes_in_bins(*self.belief.heaviest(self.samples), (size, turn))
