"""The part of a belief that is not worked on state by state, held as an upper bound.

A belief moves and is weighed linearly: it is the sum of what becomes of its parts. So a part can
be left out and only bounded. It is kept as the mass of tiles of SIDE x SIDE states of a layer.
Motion moves tiles with their layer; spreading gives a tile at most what its neighbours can give;
a scan multiplies it by the likelihood of beams that each take the best of the SIDE x SIDE cells
that they can end in, sightings of landmarks by what none of its states can exceed, or, where that
is too much, by the likelihood of its best state; a compass by that of its heading. Everything else
that is measured multiplies by at most one, and is left out.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer import kernels
from pilotage.localizer.kernels import SIDE, Admissible, Area, Prior, Scan, Tiles
from pilotage.localizer.state_likelihood import StateLikelihood


class Rest:
    """Upper bounds of the mass of tiles; empty while the whole belief is worked on."""

    def __init__(self, headings: int, admissible: Admissible) -> None:
        counts = _counts(admissible.mask)
        mass = np.zeros((headings, *counts.shape[2:]), np.float32)
        self.tiles = Tiles(mass, np.zeros((headings, 2), np.int64), counts)
        self.is_empty = True
        self._mask = admissible.mask
        self._fit = np.ones_like(mass)
        self._everywhere = kernels.whole_area(mass.shape)

    @property
    def mass(self) -> float:
        """What all tiles weigh together at the most."""
        return 0.0 if self.is_empty else float(self.tiles.mass.sum(dtype=np.float64))

    def clear(self) -> None:
        """Hold nothing."""
        self.tiles.mass[:] = 0.0
        self.is_empty = True

    def retire(
        self, belief: NDArray[np.float32], area: Area, sums: NDArray[np.float32], limit: float
    ) -> NDArray[np.bool_]:
        """Take over the tiles that hold at most `limit`; return the blocks that are left.

        Blocks (headings, rows, cols) are SIDE x SIDE cells of the grid.
        """
        self.is_empty = False
        return kernels.retire(belief, area, self.tiles, sums, limit)

    def open(self, belief: NDArray[np.float32]) -> None:
        """Give everything back, spread evenly over each tile's states."""
        if not self.is_empty:
            kernels.open_tiles(belief, self.tiles, self._mask)
            self.is_empty = True

    def shift(self, cells: NDArray[np.int64]) -> None:
        """Move with layers that move by whole cells (headings, 2)."""
        phases = self.tiles.phases + cells
        self.tiles.phases[:] = phases % SIDE
        kernels.shift_layers(self.tiles.mass, self._everywhere, phases // SIDE)

    def spread(self, share: float) -> None:
        """Bound what `spread_layers` leaves in each tile."""
        kernels.spread_tiles(self.tiles.mass, share)

    def spread_headings(self, share: float, shifts: NDArray[np.int64]) -> None:
        """Bound what `spread_headings` leaves in each tile."""
        kernels.spread_tile_headings(self.tiles, share, shifts)

    def begin(self, prior: Prior) -> None:
        """Begin a correction that does not begin with a scan."""
        tiles = self.tiles
        up, right = tiles.phases.T
        floor = np.float32(prior.floor) * tiles.counts[up, right]
        tiles.mass[:] = tiles.mass * np.float32(prior.scale) + floor
        tiles.mass[:] *= prior.heading[:, None, None]

    def weigh(self, prior: Prior, coarse: Scan) -> None:
        """Begin a correction and weigh each tile by the most that a scan can say for it."""
        kernels.weigh_tiles(self.tiles, prior, coarse, self._fit)

    def weigh_more(self, bounds: NDArray[np.float32]) -> None:
        """Weigh each tile by bounds of the likelihood of its states, in the shape of the tiles."""
        np.maximum(bounds, kernels.LEAST_FIT, out=self._fit)
        self.tiles.mass[:] *= self._fit

    def undo(self) -> None:
        """Take back what the tiles were last weighed by."""
        self.tiles.mass[:] /= self._fit
        self._fit[:] = 1.0

    def above(self, limit: float) -> NDArray[np.int64]:
        """Return the tiles (n, 3) that may weigh more than `limit`."""
        mass = self.tiles.mass
        return np.stack(np.unravel_index(np.flatnonzero(mass > limit), mass.shape), axis=1)

    def limit_of(self, budget: float) -> float:
        """Return a limit such that the tiles below it weigh `budget` together at the most."""
        return kernels.limit_of(self.tiles.mass, budget)

    def tighten(self, chosen: NDArray[np.int64], said: StateLikelihood) -> None:
        """Bound the chosen tiles (n, 3), just weighed, by the likelihood of their best states."""
        at = tuple(chosen.T)
        best = said.best_fits(self.tiles, chosen, self._mask)
        self.tiles.mass[at] *= best / self._fit[at]
        self._fit[at] = np.maximum(best, kernels.LEAST_FIT)

    def wake(
        self, belief: NDArray[np.float32], chosen: NDArray[np.int64], said: StateLikelihood
    ) -> None:
        """Give back the chosen tiles (n, 3), just tightened, weighed by what was said."""
        at = tuple(chosen.T)
        self.tiles.mass[at] /= self._fit[at]
        said.wake(belief, self.tiles, chosen, self._mask)


def _counts(mask: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the admissible states (SIDE, SIDE, tile rows, tile cols) of each tile by phase."""
    tile_rows, tile_cols = (-(-length // SIDE) + 1 for length in mask.shape)
    padded = np.zeros((SIDE * (tile_rows + 1), SIDE * (tile_cols + 1)))
    padded[SIDE : SIDE + mask.shape[0], SIDE : SIDE + mask.shape[1]] = mask
    summed = np.pad(padded.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    window = summed[SIDE:, SIDE:] - summed[:-SIDE, SIDE:]
    window = window + summed[:-SIDE, :-SIDE] - summed[SIDE:, :-SIDE]
    window = window[: SIDE * tile_rows, : SIDE * tile_cols]
    by_phase = window.reshape(tile_rows, SIDE, tile_cols, SIDE).transpose(1, 3, 0, 2)
    return np.ascontiguousarray(by_phase, np.float32)
