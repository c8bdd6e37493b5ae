"""The least cost in each SIDE x SIDE window of a likelihood field: what a tile's best beam costs.

The ends of one beam, seen from all states of a tile, fill a window of the field. Windows are
stored by phase, so that those of neighbouring tiles lie side by side.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer.kernels import LANES, MOST_COST, SIDE, Scan


@dataclass(frozen=True)
class LeastCosts:
    """`planes` (classes, SIDE, SIDE, rows, cols) by phase; `flat` has a row and LANES more.

    The window of plane (up, right) at (row, col) begins at cell SIDE * (row - 1) + up of the
    field, and likewise in columns.
    """

    planes: NDArray[np.uint8]
    flat: NDArray[np.uint8]

    def scan(self, fine: Scan, shape: tuple[int, ...], phases: NDArray[np.int64]) -> Scan:
        """Return a scan of a field of `shape` for tiles whose phases are `phases` (headings, 2)."""
        classes, rows, cols = np.unravel_index(fine.starts.astype(np.int64), shape)
        up, right = rows + phases[:, :1], cols + phases[:, 1:]
        tile_rows, tile_cols = self.planes.shape[3:]
        plane = (classes * SIDE + up % SIDE) * SIDE + right % SIDE
        starts = (plane * tile_rows + up // SIDE) * tile_cols + right // SIDE
        return Scan(starts.astype(np.uint64), self.flat, tile_cols, fine.likelihood)


def least_costs(costs: NDArray[np.uint8]) -> LeastCosts:
    """Return the least costs of a field (classes, rows, cols); beyond it all are MOST_COST."""
    classes, height, width = costs.shape
    rows, cols = (length // SIDE + 3 for length in (height, width))
    least = np.full((classes, SIDE * (rows + 1), SIDE * (cols + 1)), MOST_COST, np.uint8)
    least[:, SIDE : SIDE + height, SIDE : SIDE + width] = costs
    for axis in (1, 2):
        for step in (1, 2, 4):
            low, high = [slice(None)] * 3, [slice(None)] * 3
            low[axis], high[axis] = slice(None, -step), slice(step, None)
            least[tuple(low)] = np.minimum(least[tuple(low)], least[tuple(high)])
    by_phase = least[:, : SIDE * rows, : SIDE * cols].reshape(classes, rows, SIDE, cols, SIDE)
    spare = cols + LANES
    flat = np.full(classes * SIDE * rows * SIDE * cols + spare, MOST_COST, np.uint8)
    planes = flat[:-spare].reshape(classes, SIDE, SIDE, rows, cols)
    planes[:] = by_phase.transpose(0, 2, 4, 1, 3)
    return LeastCosts(planes, flat)
