"""Which readings of a ring say something new, and are to be believed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.mapper.sonar_ring import SonarReadings, SonarRing


@dataclass(frozen=True)
class SonarNewsParams:
    """Which readings are used; the defaults are what measured best on real rings."""

    use_from: float = 0.1
    """Nearer readings are left out (m): the thesis's 0.1 (chapter 6)."""
    use_up_to: float | None = None
    """Farther readings are left out (m): the thesis keeps 1.0 of 4.0; None: by `use_share`."""
    use_share: float = 0.5
    """Share of the maximum range that is used where `use_up_to` does not say it."""
    least_travel: float = 0.02
    """A sonar that moved less (m), ..."""
    least_turn: float = 0.03
    """... turned less (rad), ..."""
    least_change: float = 0.05
    """... and measures the same but for this (m), repeats itself: one error would count twice."""


class SonarNews:
    """Remembers what each sonar of a ring last said."""

    def __init__(self, params: SonarNewsParams, ring: SonarRing) -> None:
        farthest = params.use_share * ring.range_max
        self.use_up_to = farthest if params.use_up_to is None else params.use_up_to
        self.use_from = max(params.use_from, ring.range_min)
        self._params = params
        self._last = np.full((len(ring.mounts), 4), np.nan)

    def of(self, readings: SonarReadings) -> SonarReadings:
        """Return those of a round's readings (n, 4) that are in range and new: (k, 4)."""
        ranges = readings[:, 3]
        useful = (ranges >= self.use_from) & (ranges <= self.use_up_to)
        is_new = useful & ~self._repeats(readings)
        self._last[is_new] = readings[is_new]
        return readings[is_new]

    def _repeats(self, readings: SonarReadings) -> NDArray[np.bool_]:
        """Say (n,) which readings repeat the last one of their sonar; none does at first."""
        params = self._params
        with np.errstate(invalid="ignore"):  # infinite ranges: their difference is no number
            change = np.abs(readings - self._last)
        turned = np.abs(wrap(change[:, 2]))
        stayed = (change[:, 0] < params.least_travel) & (change[:, 1] < params.least_travel)
        same: NDArray[np.bool_] = (
            stayed & (turned < params.least_turn) & (change[:, 3] < params.least_change)
        )
        return same
