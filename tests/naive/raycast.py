"""Ray casting as geometry: intersect the ray with the box of every wall cell."""

import math

import numpy as np
from numpy.typing import NDArray


def cast_ray_in_grid(
    is_wall: NDArray[np.bool_], x_cells: float, y_cells: float, theta: float, max_cells: float
) -> float:
    """Twin of `cell_traversal.cast_ray_in_grid`, cell by cell in any order."""
    rows, cols = is_wall.shape
    if not (0.0 <= x_cells < cols and 0.0 <= y_cells < rows):
        return math.inf
    nearest = math.inf
    for row, col in np.argwhere(is_wall):
        entry = _entry((int(col), int(row)), (x_cells, y_cells), (math.cos(theta), math.sin(theta)))
        nearest = min(nearest, entry)
    return nearest if nearest <= max_cells else math.inf


def _entry(
    corner: tuple[int, int], start: tuple[float, float], direction: tuple[float, float]
) -> float:
    """Where a ray enters the unit box at `corner`: the slab test."""
    entry, leave = 0.0, math.inf
    for low, origin, speed in zip(corner, start, direction, strict=True):
        if speed == 0.0:
            if not low <= origin < low + 1:
                return math.inf
        else:
            near, far = sorted(((low - origin) / speed, (low + 1 - origin) / speed))
            entry, leave = max(entry, near), min(leave, far)
    return entry if entry < leave else math.inf
