"""Expected ranges in plain numpy: one direction of the table at a time, all cells at once.

The ray of one cell is traced; every other cell of the same direction crosses the same cells
relative to its own. The farthest is written first and the nearest wall last.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.localizer.pose_grid import PoseGrid


def plain_range_layer(
    world: OccupancyMap, states: PoseGrid, heading: float, range_max: float
) -> NDArray[np.float32]:
    """Return the expected range (rows, cols) [m] of every cell along one direction.

    The cells have to lie along the map's axes and to be a whole number of its cells wide.
    """
    geometry, fine = states.geometry, world.geometry
    ratio = round(geometry.resolution / fine.resolution)
    corner = se2.between(fine.origin, geometry.origin)[:2] / fine.resolution
    x, y = np.round(corner + 0.5 * ratio, 6)
    layer = np.full(geometry.shape, range_max, np.float32)
    crossed = list(_crossed(float(x), float(y), heading, range_max / fine.resolution))
    is_wall = world.is_wall
    for row, col, distance in reversed(crossed):
        rows, of_rows = _pairs(row, ratio, geometry.rows, fine.rows)
        cols, of_cols = _pairs(col, ratio, geometry.cols, fine.cols)
        np.copyto(
            layer[rows, cols], distance * fine.resolution, where=is_wall[of_rows, of_cols],
            casting="same_kind",
        )  # fmt: skip
    return layer


def _crossed(x: float, y: float, heading: float, most: float) -> Iterator[tuple[int, int, float]]:
    """Yield row, col and distance, all in cells, of what a ray from (x, y) enters."""
    dx, dy = math.cos(heading), math.sin(heading)
    col, row, distance = math.floor(x), math.floor(y), 0.0
    while distance <= most:
        yield row, col, distance
        next_x = (col + (dx > 0.0) - x) / dx if abs(dx) > 1e-9 else math.inf
        next_y = (row + (dy > 0.0) - y) / dy if abs(dy) > 1e-9 else math.inf
        distance = min(next_x, next_y)
        if next_x < next_y:
            col += 1 if dx > 0.0 else -1
        else:
            row += 1 if dy > 0.0 else -1


def _pairs(first: int, ratio: int, count: int, fine_count: int) -> tuple[slice, slice]:
    """Return which of `count` cells have their crossed cell on the map, and those cells."""
    low = max(0, -(first // ratio))
    end = max(low, min(count, -(-(fine_count - first) // ratio)))
    start = first + low * ratio
    return slice(low, end), slice(start, max(start, first + (end - 1) * ratio + 1), ratio)
