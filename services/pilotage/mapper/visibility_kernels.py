"""Kernel that asks whether beams go through walls."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.mapper.surfel_kernels import SurfelMap


@kernel
def beams_through_walls(
    origin: NDArray[np.float64], ends: NDArray[np.float64], walls: SurfelMap, margin: float
) -> int:
    """Return how many beams pass a wall more than `margin` m before they end.

    From `origin` (2,) to `ends` (n, 2), in the frame of the surfels; a beam meets a wall where a
    surfel is nearer than half a cell.
    """
    distance, cell = walls.distance, walls.cell
    corner_x, corner_y = walls.corner[0], walls.corner[1]
    rows, cols = distance.shape
    through = 0
    for i in range(len(ends)):
        dx, dy = ends[i, 0] - origin[0], ends[i, 1] - origin[1]
        length = np.sqrt(dx * dx + dy * dy)
        steps = int((length - margin) / (0.5 * cell))
        for k in range(4, steps):
            at = k * 0.5 * cell / length
            col = int(np.floor((origin[0] + at * dx - corner_x) / cell))
            row = int(np.floor((origin[1] + at * dy - corner_y) / cell))
            if 0 <= row < rows and 0 <= col < cols and distance[row, col] < 0.5 * cell:
                through += 1
                break
    return through
