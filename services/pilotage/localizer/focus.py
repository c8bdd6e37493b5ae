"""Which part of a belief is worked on state by state, and what the rest can weigh at the most.

While a robot is tracked nearly all of the belief lies in a few small places, and not in all
headings there. Every pass works on the blocks only that hold them; elsewhere the belief's array
is zero, and what may lie there is bounded (see `rest`). A tile whose bound comes to matter is
woken: before it is weighed its mass is given to its states, evenly.

So the belief is that of a grid worked on as a whole, but for what the rest can weigh, and for the
woken tiles, which begin with no more than `FocusParams.woken`: as much as a few measurements'
floor. Whatever grows after that grows as it would anyway.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer import kernels
from pilotage.localizer.active_blocks import (
    Blocks,
    add_tiles,
    widened,
    with_neighbours,
)
from pilotage.localizer.kernels import Area, Runs
from pilotage.localizer.kernels.areas import NONE
from pilotage.localizer.pose_grid import PoseGrid
from pilotage.localizer.rest import Rest
from pilotage.localizer.state_likelihood import StateLikelihood

MOST_BUSY = 0.2
"""Share of the blocks that may be active; with more, everything is worked on."""

MOST_SUSPECTS = 0.1
"""Share of the tiles that are looked at one by one; to weigh every state anew takes no longer."""


@dataclass(frozen=True)
class FocusParams:
    """When to leave states alone; masses are shares of the whole belief.

    `least_states`: a smaller grid is always worked on as a whole. `dropped`: tiles that hold
    less go to the rest. `woken`: a tile that may weigh more once it is weighed is woken. `most`:
    what the rest may weigh in all after that. `most_floor`: with a greater recovery weight every
    measurement would wake everything.
    """

    least_states: int = 2_000_000
    dropped: float = 1e-11
    woken: float = 1e-10
    most: float = 1e-4
    most_floor: float = 1e-4


class Focus:
    """The rest of a belief, and the area (see kernels) that is worked on."""

    def __init__(self, grid: PoseGrid, params: FocusParams) -> None:
        self._shape, self._params = grid.shape, params
        self.rest = Rest(grid.headings, grid.admissible)
        self._whole = kernels.in_all_layers(grid.admissible, grid.headings)
        self._all_cells = kernels.whole_area(grid.shape)
        self._is_worthwhile = int(np.prod(grid.shape)) >= params.least_states
        self._blocks: Blocks | None = None
        self.area = self._whole

    @property
    def is_whole(self) -> bool:
        """Whether every state is worked on."""
        return self._blocks is None

    @property
    def room(self) -> Area:
        """Where the belief may move: the area, and the walls in it."""
        return self._all_cells if self._blocks is None else self.area

    def forget(self) -> None:
        """Work on everything, the rest being nothing."""
        self.rest.clear()
        self._work_on(None)

    def open(self, belief: NDArray[np.float32]) -> None:
        """Work on everything: the rest is given back, spread over its tiles."""
        self.rest.open(belief)
        self._work_on(None)

    def open_if_heavy(self, belief: NDArray[np.float32], total: float) -> None:
        """Work on everything if the rest may weigh more of the total than it should."""
        if self.rest.mass > self._params.most * total:
            self.open(belief)

    def allows(self, recovery_weight: float) -> bool:
        """Say whether so much belief may be spread over everything without working on it."""
        return recovery_weight <= self._params.most_floor

    def grow(self, belief: NDArray[np.float32], cells: int, headings: int) -> None:
        """Make room for a motion by `cells` cells and `headings` headings."""
        if self._blocks is None or not (cells or headings):
            return
        # Neighbouring layers lie up to a cell apart.
        blocks = widened(self._blocks, cells + headings)
        for _ in range(headings):
            blocks = with_neighbours(blocks)
        self._activate(belief, blocks)

    def wake(self, belief: NDArray[np.float32], said: StateLikelihood, mass: float) -> bool:
        """Give back what the rest, just weighed, may hold that matters.

        Args:
            belief: changed in place.
            said: what belief and rest were weighed by, state by state.
            mass: of the part of the belief that is worked on.

        Return whether anything was given back.
        """
        rest, most = self.rest, self._params.most * mass
        limit = self._params.woken * mass
        if rest.mass > most:
            limit = min(limit, rest.limit_of(0.5 * most))
        suspects = rest.above(limit)
        if self._blocks is None or not len(suspects):
            return False
        if len(suspects) > MOST_SUSPECTS * rest.tiles.mass.size:
            self._weigh_all(belief, said)
            return True
        rest.tighten(suspects, said)
        heavy = self._heavy(suspects, mass)
        if len(heavy):
            rest.wake(belief, heavy, said)
            blocks = self._blocks.copy()
            add_tiles(blocks, heavy, rest.tiles.phases)
            self._activate(belief, blocks)
        return bool(len(heavy))

    def narrow(self, belief: NDArray[np.float32], runs: Runs, total: float) -> None:
        """Leave to the rest what has become light.

        `runs` are the sums of `area` in the belief, `total` what belief and rest weigh.
        """
        limit = self._params.dropped * total
        is_busy = self.is_whole and float((runs.mass > limit).mean()) > MOST_BUSY
        if not self._is_worthwhile or is_busy:
            return
        sums = kernels.sum_tiles(belief, self.area, self.rest.tiles, runs.mass)
        if not self.is_whole or self._is_little(sums, limit, total):
            self._work_on(self.rest.retire(belief, self.area, sums, limit))

    def _weigh_all(self, belief: NDArray[np.float32], said: StateLikelihood) -> None:
        """Work on everything, as if that had been so before belief and rest were weighed."""
        said.take_back(belief, self.area)
        self.rest.undo()
        self.open(belief)
        said.weigh(belief, self.area)

    def _work_on(self, blocks: Blocks | None) -> None:
        self._blocks, self.area = blocks, self._whole
        if blocks is not None:
            runs, starts = kernels.runs_of_blocks(blocks, *self._shape[1:])
            self.area = Area(self._whole.mask, runs, starts, NONE)

    def _activate(self, belief: NDArray[np.float32], blocks: Blocks) -> None:
        """Work on these blocks, or on everything if they are too many to be worth it."""
        if float(blocks.mean()) > 2.0 * MOST_BUSY:
            self.open(belief)
        else:
            self._work_on(blocks)

    def _heavy(self, suspects: NDArray[np.int64], mass: float) -> NDArray[np.int64]:
        """Return which suspects have to be woken, so that the rest stays within its bounds."""
        weights = self.rest.tiles.mass[tuple(suspects.T)]
        order = np.argsort(-weights)
        left = self.rest.mass - np.cumsum(weights[order], dtype=np.float64)
        count = int(np.searchsorted(-weights[order], -self._params.woken * mass))
        if self.rest.mass > self._params.most * mass:
            count = max(count, 1 + int(np.argmax(left <= 0.5 * self._params.most * mass)))
        return suspects[order[:count]]

    def _is_little(self, sums: NDArray[np.float32], limit: float, total: float) -> bool:
        """Say whether few tiles hold nearly all of the belief."""
        is_light = sums <= limit
        left_out = float(sums[is_light].sum(dtype=np.float64))
        busy = 1.0 - float(is_light.mean())
        return left_out <= self._params.most * total and busy < 0.5 * MOST_BUSY
