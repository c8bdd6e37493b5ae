"""Which part of a belief is worked on state by state, and what the rest can weigh at the most.

While a robot is tracked nearly all of the belief lies in a few small places. Boxes hold them, and
every pass works inside the boxes only; outside them the belief's array is zero. What lay there is
bounded (see `rest`). A tile whose bound comes to matter is woken: before it is weighed by the scan
its mass is given to its states, evenly, and a box is opened round it.

So with boxes the belief is that without them, but for what the rest can weigh: after each
measurement at most `FocusParams.most` of the total, and the masses of the woken tiles, which
were bounds. Both are shares of what is believed, so that the pose hardly feels them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer import kernels
from pilotage.localizer.boxes import Boxes, area, grown, merged, restricted, whole
from pilotage.localizer.kernels import SIDE, Runs, Scan
from pilotage.localizer.pose_grid import PoseGrid
from pilotage.localizer.rest import Rest

MOST_BUSY = 0.25
"""Share of the runs of the whole grid that may hold something when boxes are looked for."""


@dataclass(frozen=True)
class FocusParams:
    """When to leave states alone; masses are shares of the whole belief.

    `least_states`: a smaller grid is always worked on as a whole. `dropped`: tiles that hold
    less go to the rest. `woken`: a tile that may weigh more after a scan is woken. `most`: what
    the rest may weigh in all after a scan. `most_floor`: with a greater recovery weight every
    scan would wake everything.
    """

    least_states: int = 2_000_000
    dropped: float = 1e-9
    woken: float = 1e-7
    most: float = 1e-3
    most_floor: float = 1e-4


class Focus:
    """Boxes (n, 4) of the belief, what is admissible in them, and the rest."""

    def __init__(self, grid: PoseGrid, params: FocusParams) -> None:
        self._grid, self._params = grid, params
        self.rest = Rest(grid.headings, grid.admissible)
        self._is_worthwhile = int(np.prod(grid.shape)) >= params.least_states
        self._set(whole(grid.shape))

    @property
    def is_whole(self) -> bool:
        """Whether every state is worked on."""
        return area(self.boxes) == self._grid.geometry.rows * self._grid.geometry.cols

    def forget(self) -> None:
        """Work on everything, the rest being nothing."""
        self.rest.clear()
        self._set(whole(self._grid.shape))

    def open(self, belief: NDArray[np.float32]) -> None:
        """Work on everything: the rest is given back, spread over its tiles."""
        self.rest.open(belief)
        self._set(whole(self._grid.shape))

    def allows(self, recovery_weight: float) -> bool:
        """Say whether so much belief may be spread over everything without working on it."""
        return recovery_weight <= self._params.most_floor

    def grow(self, by: int) -> None:
        """Make room for a motion by `by` cells."""
        if by and not self.is_whole:
            self._set(grown(self.boxes, by, self._grid.shape))

    def wake(self, belief: NDArray[np.float32], scan: Scan, mass: float) -> bool:
        """Give back whatever the rest, just weighed by a scan, may hold that matters.

        Args:
            belief: changed in place.
            scan: the scan, state by state.
            mass: of the part of the belief that is worked on.

        Return whether anything was given back.
        """
        rest, params = self.rest, self._params
        limit = params.woken * mass
        most = params.most * mass
        if rest.mass > most:
            limit = min(limit, rest.limit_of(0.5 * most))
        suspects = rest.above(limit)
        if not len(suspects):
            return False
        rest.tighten(suspects, scan)
        heavy = self._heavy(suspects, mass)
        if len(heavy):
            boxes = rest.wake(belief, heavy, scan)
            self._set(merged(np.concatenate([self.boxes, boxes])))
        return bool(len(heavy))

    def narrow(self, belief: NDArray[np.float32], runs: Runs, total: float) -> bool:
        """Leave to the rest what has become light; return whether the boxes have changed.

        `runs` are the sums of `area` in the belief, `total` what belief and rest weigh.
        """
        if not self._is_worthwhile or not self._is_concentrated(runs, total):
            return False
        sums = self.rest.sums(belief, self.boxes)
        limit = self._params.dropped * total
        if self.is_whole and not self._is_little(sums, limit, total):
            return False
        is_kept = self.rest.retire(belief, self.boxes, sums, limit)
        blocks = merged(kernels.boxes_of(is_kept))
        self._set(np.clip(SIDE * blocks, 0, np.repeat(self._grid.geometry.shape, 2)))
        return True

    def _set(self, boxes: Boxes) -> None:
        self.boxes = boxes
        self.area = restricted(self._grid.admissible, boxes)

    def _heavy(self, suspects: NDArray[np.int64], mass: float) -> NDArray[np.int64]:
        """Return which suspects have to be woken, so that the rest stays within its bounds."""
        weights = self.rest.tiles.mass[tuple(suspects.T)]
        order = np.argsort(-weights)
        left = self.rest.mass - np.cumsum(weights[order], dtype=np.float64)
        count = int(np.searchsorted(-weights[order], -self._params.woken * mass))
        if self.rest.mass > self._params.most * mass:
            count = max(count, 1 + int(np.argmax(left <= 0.5 * self._params.most * mass)))
        return suspects[order[:count]]

    def _is_concentrated(self, runs: Runs, total: float) -> bool:
        """Say whether few runs hold anything: the blocks of a whole belief take time to sum."""
        if not self.is_whole:
            return True
        return float((runs.mass > self._params.dropped * total).mean()) < MOST_BUSY

    def _is_little(self, sums: NDArray[np.float32], limit: float, total: float) -> bool:
        """Say whether few tiles hold nearly all of the belief."""
        is_light = sums <= limit
        left_out = float(sums[is_light].sum(dtype=np.float64))
        return left_out <= self._params.most * total and float(is_light.mean()) > 1.0 - MOST_BUSY
