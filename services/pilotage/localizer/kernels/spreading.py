"""Passes that bound what spreading the belief leaves in each tile (see resting)."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels.resting import SIDE, Row, Tiles


@kernel
def spread_tiles(mass: NDArray[np.float32], share: float) -> None:
    """Give each tile `share` of each of its neighbours above, below, left and right.

    Only states at its edge can pass anything on, but they may hold all of it.
    """
    headings, rows, cols = mass.shape
    give = np.float32(share)
    before = np.empty((rows, cols), np.float32)
    for k in range(headings):
        layer = mass[k]
        before[:] = layer
        for row in range(rows):
            if row > 0:
                _add_row(layer[row], before[row - 1], give)
            if row + 1 < rows:
                _add_row(layer[row], before[row + 1], give)
        before[:] = layer
        for row in range(rows):
            _add_row(layer[row, 1:], before[row, :-1], give)
            _add_row(layer[row, :-1], before[row, 1:], give)


@kernel
def spread_tile_headings(tiles: Tiles, share: float, shifts: NDArray[np.int64]) -> None:
    """Give each tile `share` of all tiles of the neighbouring layers that reach into it.

    `shifts` as in `spread_headings`; a tile that only partly reaches in counts as a whole.
    """
    headings = len(tiles.mass)
    before = tiles.mass.copy()
    keep, give = np.float32(1.0 - 2.0 * share), np.float32(share)
    for k in range(headings):
        ahead, behind = (k + 1) % headings, (k - 1) % headings
        tiles.mass[k] *= keep
        apart = tiles.phases[k] - tiles.phases[ahead] - shifts[k]
        _add_reaching(tiles.mass[k], before[ahead], apart, give)
        apart = tiles.phases[k] - tiles.phases[behind] + shifts[behind]
        _add_reaching(tiles.mass[k], before[behind], apart, give)


@kernel
def _add_reaching(
    target: NDArray[np.float32],
    other: NDArray[np.float32],
    apart: NDArray[np.int64],
    give: np.float32,
) -> None:
    """Add `give` times the up to four tiles of another layer that lie `apart` (2,) states off."""
    rows, cols = target.shape
    up, right = apart[0] // SIDE, apart[1] // SIDE
    end_up, end_right = -(-apart[0] // SIDE) + 1, -(-apart[1] // SIDE) + 1
    for row in range(rows):
        for source in range(max(0, row + up), min(rows, row + end_up)):
            for aside in range(right, end_right):
                first, last = max(0, -aside), min(cols, cols - aside)
                if first < last:
                    _add_row(
                        target[row, first:last], other[source, first + aside : last + aside], give
                    )


@kernel
def _add_row(target: Row, source: Row, give: np.float32) -> None:
    for i in range(len(target)):
        target[i] += give * source[i]
