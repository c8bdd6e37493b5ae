"""Distance to the nearest wall by looking at every wall from every cell."""

import numpy as np
from numpy.typing import NDArray


def distance_to_walls(is_wall: NDArray[np.bool_], resolution: float) -> NDArray[np.float32]:
    """Twin of `distance_field.distance_to_walls`."""
    distance = np.full(is_wall.shape, np.inf, np.float32)
    walls = np.argwhere(is_wall)
    if len(walls):
        for cell in np.ndindex(is_wall.shape):
            squared = ((walls - np.array(cell)) ** 2).sum(axis=1).min()
            distance[cell] = np.sqrt(squared) * resolution
    return distance
