"""The same map on coarser (or other) cells, never losing a wall."""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import FREE, OCCUPIED, UNKNOWN, GridGeometry, OccupancyMap


def resample(world: OccupancyMap, resolution: float) -> OccupancyMap:
    """Return the map with cells of `resolution` m from the same origin.

    A new cell is a wall if any old cell that it overlaps is one, else free if any of them is,
    else unknown. Probabilities become 0 or 100.

    Raises:
        ValueError: `resolution` is not positive.
    """
    if not resolution > 0.0:
        raise ValueError(f"resolution must be positive, not {resolution}")
    old = world.geometry
    ratio = resolution / old.resolution
    row_bounds, col_bounds = _bounds(old.rows, ratio), _bounds(old.cols, ratio)
    shape = len(row_bounds) // 2, len(col_bounds) // 2
    cells = np.full(shape, UNKNOWN, np.int8)
    cells[_any_in_blocks(world.is_free, row_bounds, col_bounds)] = FREE
    cells[_any_in_blocks(world.is_wall, row_bounds, col_bounds)] = OCCUPIED
    return OccupancyMap(GridGeometry(*shape, resolution, old.origin), cells)


def _bounds(count: int, ratio: float) -> NDArray[np.int64]:
    """Return first, end, first, end ... of the old cells that each new cell overlaps."""
    # The tolerance keeps 0.15 / 0.05 = 2.9999999999999996 from overlapping a fourth cell.
    new_count = max(1, math.ceil(count / ratio - 1e-6))
    edges = np.arange(new_count + 1) * ratio
    first = np.floor(edges[:-1] + 1e-6).astype(np.int64)
    end = np.minimum(np.ceil(edges[1:] - 1e-6).astype(np.int64), count)
    return np.stack([first, end], axis=1).ravel()


def _any_in_blocks(
    mask: NDArray[np.bool_], row_bounds: NDArray[np.int64], col_bounds: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Say for each block of rows and cols whether the mask holds anywhere in it."""
    # reduceat needs every bound to be an index, the last end included: hence the padding.
    padded = np.pad(mask, ((0, 1), (0, 1)))
    by_rows = np.logical_or.reduceat(padded, row_bounds, axis=0)[::2]
    blocks: NDArray[np.bool_] = np.logical_or.reduceat(by_rows, col_bounds, axis=1)[:, ::2]
    return blocks
