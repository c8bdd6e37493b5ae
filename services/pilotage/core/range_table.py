"""The range that is expected from every cell in every direction, as a table to look up.

All rays of one direction that start at cell centres cross the same cells relative to their
start. So each direction is traced once as a list of offsets, and the list is swept over the
whole map row by row, farthest offset first, the nearest wall being written last: the inner loop
is one select over neighbouring cells, which LLVM vectorises.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.cell_traversal import cast_rays_in_grid, direction
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.jit import kernel

Table = NDArray[np.float32]
"""Ranges in m, (headings, rows, cols)."""


def expected_ranges(
    world: OccupancyMap, geometry: GridGeometry, headings: int, range_max: float
) -> Table:
    """Return the range in m from each cell centre of `geometry` in each of `headings` directions.

    Direction k is k * 2 pi / headings in the MAP frame; `range_max` stands where nothing is hit.
    Fast when `geometry` lies along the map's axes and a cell of it is a whole number of the
    map's cells wide; any other geometry is cast ray by ray.
    """
    ratio = geometry.resolution / world.geometry.resolution
    turn = math.remainder(geometry.origin[2] - world.geometry.origin[2], 2.0 * math.pi)
    if abs(turn) > 1e-9 or round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-9 * ratio:
        return _cast_each(world, geometry, headings, range_max)
    return _sweep_all(world, geometry, headings, range_max)


def _cast_each(
    world: OccupancyMap, geometry: GridGeometry, headings: int, range_max: float
) -> Table:
    """The table, one ray at a time."""
    fine = world.geometry
    centres = geometry.centres_of(np.argwhere(np.ones(geometry.shape, bool)))
    rays = np.empty((len(centres), 3))
    rays[:, :2] = fine.grid_from_map(centres) / fine.resolution
    table = np.empty((headings, *geometry.shape), np.float32)
    for k in range(headings):
        rays[:, 2] = k * 2.0 * np.pi / headings - fine.origin[2]
        distances = cast_rays_in_grid(world.is_wall, rays, range_max / fine.resolution)
        ranges = np.minimum(distances * fine.resolution, range_max)
        table[k] = ranges.reshape(geometry.shape)
    return table


def _sweep_all(
    world: OccupancyMap, geometry: GridGeometry, headings: int, range_max: float
) -> Table:
    """The table, one direction at a time for all cells together."""
    fine = world.geometry
    ratio = round(geometry.resolution / fine.resolution)
    corner = se2.between(fine.origin, geometry.origin)[:2] / fine.resolution
    # Rounded to a millionth of a cell, so that 0.1 + 0.2 does not push a centre over a boundary.
    first_x, first_y = np.round(corner + 0.5 * ratio, 6)
    start = (math.floor(first_y), math.floor(first_x))
    table = np.full((headings, *geometry.shape), range_max, np.float32)
    max_cells = min(range_max / fine.resolution, math.hypot(fine.rows, fine.cols))
    walls = _interleave(world.is_wall, ratio)
    for k in range(headings):
        theta = k * 2.0 * math.pi / headings - fine.origin[2]
        offsets, distances = _trace(first_x - start[1], first_y - start[0], theta, max_cells)
        ranges = (distances * fine.resolution).astype(np.float32)
        _sweep(walls, offsets + np.array(start), ranges, table[k])
    # A ray that starts outside the map sees nothing of it, as in `cast_rays`.
    table[:, _outside(start[0], ratio, geometry.rows, fine.rows)] = range_max
    table[:, :, _outside(start[1], ratio, geometry.cols, fine.cols)] = range_max
    return table


def _outside(first: int, ratio: int, count: int, fine_count: int) -> NDArray[np.bool_]:
    """Say which of `count` cells have their centre before or behind the map's fine cells."""
    centres = first + ratio * np.arange(count)
    outside: NDArray[np.bool_] = (centres < 0) | (centres >= fine_count)
    return outside


def _interleave(is_wall: NDArray[np.bool_], ratio: int) -> NDArray[np.bool_]:
    """Return the walls as (ratio, rows, ceil(cols / ratio)): every ratio-th col side by side."""
    rows, cols = is_wall.shape
    padded = np.zeros((rows, -(-cols // ratio) * ratio), bool)
    padded[:, :cols] = is_wall
    return np.ascontiguousarray(padded.reshape(rows, -1, ratio).transpose(2, 0, 1))


@kernel
def _trace(
    x_cells: float, y_cells: float, theta: float, max_cells: float
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the cells (n, 2) row, col that a ray crosses, and where (n,) it enters them."""
    dx, dy = direction(theta)
    size = int(max_cells * (abs(dx) + abs(dy))) + 4
    cells, entries = np.zeros((size, 2), np.int64), np.zeros(size)
    step_col, ahead_x = (1, 1) if dx > 0.0 else (-1, 0)
    step_row, ahead_y = (1, 1) if dy > 0.0 else (-1, 0)
    col, row = int(x_cells), int(y_cells)
    cells[0, 0], cells[0, 1] = row, col
    count = 1
    while count < size:
        next_x = (col + ahead_x - x_cells) / dx if dx != 0.0 else math.inf
        next_y = (row + ahead_y - y_cells) / dy if dy != 0.0 else math.inf
        if min(next_x, next_y) > max_cells:
            break
        if next_x < next_y:
            col += step_col
        else:
            row += step_row
        cells[count, 0], cells[count, 1] = row, col
        entries[count] = min(next_x, next_y)
        count += 1
    return cells[:count], entries[:count]


@kernel
def _sweep(
    walls: NDArray[np.bool_],
    cells: NDArray[np.int64],
    ranges: NDArray[np.float32],
    table: Table,
) -> None:
    """Write into `table` (rows, cols) the range of the nearest wall along one direction.

    Args:
        walls: (ratio, map rows, map cols / ratio), from `_interleave`.
        cells: (n, 2) map cells row, col that the ray of table cell (0, 0) crosses, nearest first.
        ranges: (n,) where it enters them, m.
        table: (rows, cols), preset to the maximum range.
    """
    ratio, map_rows, map_cols = walls.shape
    rows, cols = table.shape
    for row in range(rows):
        for i in range(len(cells) - 1, -1, -1):
            map_row = row * ratio + cells[i, 0]
            if 0 <= map_row < map_rows:
                phase = cells[i, 1] % ratio
                shift = (cells[i, 1] - phase) // ratio
                low, high = max(0, -shift), min(cols, map_cols - shift)
                if low < high:
                    seen = walls[phase, map_row, low + shift : high + shift]
                    _put_where(seen, ranges[i], table[row, low:high])


@kernel
def _put_where(mask: NDArray[np.bool_], value: np.float32, row: NDArray[np.float32]) -> None:
    """Set `row` (n,) to `value` where `mask` (n,) holds; on slices, so that it vectorises."""
    for i in range(len(row)):
        row[i] = value if mask[i] else row[i]


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    geometry = GridGeometry(1, 1, 1.0)
    expected_ranges(OccupancyMap(geometry, np.zeros((1, 1), np.int8)), geometry, 1, 1.0)
