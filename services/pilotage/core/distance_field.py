"""Exact Euclidean distance from every cell to the nearest wall cell, centre to centre.

Felzenszwalb & Huttenlocher 2012, "Distance transforms of sampled functions": distances along
the columns first, then per row the lower envelope of the parabolas they span; linear time.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.core.jit import kernel


def distance_to_walls(is_wall: NDArray[np.bool_], resolution: float) -> NDArray[np.float32]:
    """Return the distance (rows, cols) in m to the nearest wall; infinity if there is none."""
    columns = _distance_along_columns(is_wall)
    return _combine_along_rows(columns, resolution)


def distance_to_map_walls(world: OccupancyMap) -> NDArray[np.float32]:
    """Return the distance (rows, cols) in m from each cell of a map to its nearest wall."""
    return distance_to_walls(world.is_wall, world.geometry.resolution)


def nearest_walls(is_wall: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Return for each cell the nearest wall cell, (rows, cols, 2) as row and col.

    Of several as near any one; all -1 if there is no wall.
    """
    columns = _distance_along_columns(is_wall)
    return _nearest_along_rows(columns, _nearest_in_columns(is_wall))


@kernel
def _nearest_in_columns(is_wall: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Return the row of the nearest wall of the same column; -1 if there is none."""
    rows, cols = is_wall.shape
    nearest = np.full((rows, cols), -1, np.int32)
    for row in range(rows):
        for col in range(cols):
            if is_wall[row, col]:
                nearest[row, col] = row
            elif row > 0:
                nearest[row, col] = nearest[row - 1, col]
    for row in range(rows - 2, -1, -1):
        for col in range(cols):
            above, below = nearest[row + 1, col], nearest[row, col]
            if above >= 0 and (below < 0 or abs(above - row) < row - below):
                nearest[row, col] = above
    return nearest


@kernel
def _nearest_along_rows(
    columns: NDArray[np.float64], wall_rows: NDArray[np.int32]
) -> NDArray[np.int32]:
    """Return the nearest wall cells from what is nearest in each column, and how far that is."""
    rows, cols = columns.shape
    nearest = np.full((rows, cols, 2), -1, np.int32)
    centres = np.empty(cols, np.int64)
    starts = np.empty(cols + 1)
    for row in range(rows):
        count = _lower_envelope(columns[row], centres, starts)
        parabola = 0
        for col in range(cols if count else 0):
            while parabola + 1 < count and starts[parabola + 1] < col:
                parabola += 1
            nearest[row, col, 0] = wall_rows[row, centres[parabola]]
            nearest[row, col, 1] = centres[parabola]
    return nearest


@kernel
def _distance_along_columns(is_wall: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return in cells how far the nearest wall of the same column is; infinity if none."""
    rows, cols = is_wall.shape
    distance = np.full((rows, cols), np.inf)
    for row in range(rows):
        for col in range(cols):
            if is_wall[row, col]:
                distance[row, col] = 0.0
            elif row > 0:
                distance[row, col] = distance[row - 1, col] + 1.0
    for row in range(rows - 2, -1, -1):
        for col in range(cols):
            distance[row, col] = min(distance[row, col], distance[row + 1, col] + 1.0)
    return distance


@kernel
def _combine_along_rows(columns: NDArray[np.float64], resolution: float) -> NDArray[np.float32]:
    """Return the distance in m from the distances (rows, cols) in cells along the columns."""
    rows, cols = columns.shape
    distance = np.full((rows, cols), np.inf, np.float32)
    centres = np.empty(cols, np.int64)
    starts = np.empty(cols + 1)
    for row in range(rows):
        count = _lower_envelope(columns[row], centres, starts)
        parabola = 0
        for col in range(cols if count else 0):
            while parabola + 1 < count and starts[parabola + 1] < col:
                parabola += 1
            centre = centres[parabola]
            squared = (col - centre) ** 2 + columns[row, centre] ** 2
            distance[row, col] = np.sqrt(squared) * resolution
    return distance


@kernel
def _lower_envelope(
    heights: NDArray[np.float64], centres: NDArray[np.int64], starts: NDArray[np.float64]
) -> int:
    """Find which parabolas (x - centre)^2 + height^2 lie lowest, from left to right.

    Args:
        heights: (n,) root of each parabola's height, infinity where there is none.
        centres: (n,) filled with the centres of the lowest parabolas.
        starts: (n + 1,) filled with where each becomes the lowest.

    Returns:
        How many there are.
    """
    count = 0
    for col in range(len(heights)):
        if heights[col] == np.inf:
            continue
        start = -np.inf
        while count > 0:
            last = centres[count - 1]
            rise = heights[col] ** 2 + col**2 - heights[last] ** 2 - last**2
            start = rise / (2.0 * (col - last))
            if start > starts[count - 1]:
                break
            count -= 1
            start = -np.inf
        centres[count] = col
        starts[count] = start
        count += 1
    return count


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    distance_to_walls(np.ones((1, 1), bool), 1.0)
    nearest_walls(np.ones((1, 1), bool))
