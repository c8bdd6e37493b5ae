"""Resampling by asking every pair of an old and a new cell whether they overlap."""

import numpy as np

from pilotage.core.grid import FREE, OCCUPIED, OccupancyMap


def overlap(index: int, size: float, other: int, other_size: float) -> bool:
    """Say whether cells [index, index + 1) * size share more than a sliver."""
    low = max(index * size, other * other_size)
    high = min((index + 1) * size, (other + 1) * other_size)
    return high - low > 1e-5 * other_size


def resampled_cell(world: OccupancyMap, cell: tuple[int, int], resolution: float) -> int:
    """Twin of one cell of `grid_resampling.resample`."""
    fine = world.geometry.resolution
    rows, cols = (
        [i for i in range(count) if overlap(index, resolution, i, fine)]
        for index, count in zip(cell, world.geometry.shape, strict=True)
    )
    block = np.ix_(rows, cols)
    if world.is_wall[block].any():
        return OCCUPIED
    return FREE if world.is_free[block].any() else -1
