"""When scans confirm each other: a clock of time and way."""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.laser_grid_kernels import HIDDEN, LARGE, Moment
from pilotage.mapper.laser_grid_params import TICKS, LaserGridParams

FAR = 0.5
"""Scans farther apart than this share of a proof are key scans, which nothing else confirms."""

SURE_OF_KEY_SCAN, SURE_OF_STREAM = HIDDEN, LARGE
"""Surfaces that are walls at once: but what stands alone and narrow; only what is large."""


class ScanClock:
    """Counts time and way in shares of a proof: what is hit again a whole later is proven."""

    def __init__(self, params: LaserGridParams) -> None:
        self._params = params
        self._now = 0.0
        self._gaps = math.inf, math.inf
        self._last = math.nan, math.nan, math.nan

    def moment(self, x: float, y: float, stamp: float | None) -> Moment:
        """Go on to a scan taken at x, y [m] at `stamp` [s]."""
        then, last_x, last_y = self._last
        gap = math.inf
        if stamp is not None and not math.isnan(then):
            waited = (stamp - then) / self._params.lasting_time
            gone = math.hypot(x - last_x, y - last_y) / self._params.lasting_travel
            gap = max(waited, gone, 0.0)
        self._last = math.nan if stamp is None else stamp, x, y
        self._gaps = self._gaps[1], gap
        self._now += min(gap, 1.0)
        sure_from = SURE_OF_KEY_SCAN if min(self._gaps) >= FAR else SURE_OF_STREAM
        return Moment(round(TICKS * self._now), sure_from)

    def state(self) -> NDArray[np.float64]:
        """Return itself as an array (6,)."""
        return np.array([self._now, *self._gaps, *self._last])

    def resume(self, state: NDArray[np.generic]) -> None:
        """Go on from what `state` gave; ValueError if it did not."""
        self._now, *rest = (float(value) for value in np.asarray(state, np.float64))
        before, gap, stamp, x, y = rest
        self._gaps, self._last = (before, gap), (stamp, x, y)
