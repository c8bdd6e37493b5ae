"""The kernel of ray casting: which cells a ray crosses, and where it enters the first wall.

Cell traversal after Amanatides & Woo 1987, "A fast voxel traversal algorithm". Distances are in
cells and end on the boundary of the wall cell; a cell owns its lower and left boundary.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel


@kernel
def direction(theta: float) -> tuple[float, float]:
    """Return cosine and sine; along an axis the other one is exactly zero."""
    dx, dy = math.cos(theta), math.sin(theta)
    # The sine of pi is 1e-16 in floating point, and dividing by such numbers ends in 0 * inf.
    return (dx if abs(dx) > 1e-12 else 0.0), (dy if abs(dy) > 1e-12 else 0.0)


@kernel
def cast_ray_in_grid(
    is_wall: NDArray[np.bool_], x_cells: float, y_cells: float, theta: float, max_cells: float
) -> float:
    """Return the distance in cells to the first wall; infinity if none within `max_cells`.

    Args:
        is_wall: (rows, cols).
        x_cells: start along the cols, in cells from the grid's corner.
        y_cells: start along the rows, likewise.
        theta: direction in the grid frame, rad.
        max_cells: longest distance looked at, cells.
    """
    rows, cols = is_wall.shape
    if not (0.0 <= x_cells < cols and 0.0 <= y_cells < rows):
        return math.inf
    col, row = int(x_cells), int(y_cells)
    if is_wall[row, col]:
        return 0.0
    dx, dy = direction(theta)
    step_col, ahead_x = (1, 1) if dx > 0.0 else (-1, 0)
    step_row, ahead_y = (1, 1) if dy > 0.0 else (-1, 0)
    # Crossings are computed from the start each time: adding up steps would drift on long rays.
    per_x = 1.0 / dx if dx != 0.0 else math.inf
    per_y = 1.0 / dy if dy != 0.0 else math.inf
    next_x = (col + ahead_x - x_cells) * per_x if dx != 0.0 else math.inf
    next_y = (row + ahead_y - y_cells) * per_y if dy != 0.0 else math.inf
    while True:
        if next_x < next_y:
            travelled = next_x
            col += step_col
            next_x = (col + ahead_x - x_cells) * per_x
            inside = 0 <= col < cols
        else:
            travelled = next_y
            row += step_row
            next_y = (row + ahead_y - y_cells) * per_y
            inside = 0 <= row < rows
        if not inside or travelled > max_cells:
            return math.inf
        if is_wall[row, col]:
            return travelled


@kernel
def cast_rays_in_grid(
    is_wall: NDArray[np.bool_], rays: NDArray[np.float64], max_cells: float
) -> NDArray[np.float64]:
    """Return the distances (n,) in cells of rays (n, 3): x, y in cells, theta in rad."""
    distances = np.empty(len(rays))
    for i in range(len(rays)):
        distances[i] = cast_ray_in_grid(is_wall, rays[i, 0], rays[i, 1], rays[i, 2], max_cells)
    return distances


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    cast_rays_in_grid(np.zeros((1, 1), bool), np.zeros((1, 3)), 1.0)
