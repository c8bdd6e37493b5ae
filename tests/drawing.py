"""Maps drawn as text."""

import numpy as np

from pilotage.core.grid import FREE, OCCUPIED, UNKNOWN, GridGeometry, OccupancyMap

CELLS = {"#": OCCUPIED, ".": FREE, "?": UNKNOWN}


def draw(
    picture: str, resolution: float = 1.0, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> OccupancyMap:
    """Return the map drawn with # wall, . free, ? unknown; the last line is row 0."""
    lines = picture.split()
    cells = np.array([[CELLS[mark] for mark in line] for line in reversed(lines)], np.int8)
    rows, cols = cells.shape
    return OccupancyMap(GridGeometry(rows, cols, resolution, origin), cells)
