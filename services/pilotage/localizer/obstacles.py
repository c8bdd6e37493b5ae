"""What may stop a beam on a map, and how far it is from anywhere."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import OCCUPIED, UNKNOWN, GridGeometry, OccupancyMap

MARGIN = 3
"""Cells beyond the edge of a map on which distances are known."""

FARTHEST = 1e4
"""Distance [cells] told where a map has no wall at all."""


@dataclass(frozen=True)
class Obstacles:
    """Distance (rows, cols) [cells], centre to centre, to the nearest wall of a map.

    Free space has positive distances, what lies unknown behind walls has negative ones.
    """

    geometry: GridGeometry
    distance: NDArray[np.float32]

    def in_cells(self, map_from_pose: ArrayLike) -> NDArray[np.float64]:
        """Return poses (..., 3) of the map frame in cells from the grid's corner."""
        poses = se2.compose(se2.inverse(self.geometry.origin), map_from_pose)
        poses[..., :2] /= self.geometry.resolution
        return poses

    def in_map(self, poses_cells: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return poses (..., 3) in cells from the grid's corner in the map frame."""
        poses = poses_cells.copy()
        poses[..., :2] *= self.geometry.resolution
        return se2.compose(np.array(self.geometry.origin), poses)


def enclosed(world: OccupancyMap) -> OccupancyMap:
    """Return a map whose free space ends at walls everywhere.

    Many maps do not show all of their walls: thin ones vanish when an image is made smaller, and
    glass is drawn as nothing. But a robot could not look beyond the free space that the
    map's maker saw, so where that meets the unknown something stood, if only the end of his
    laser's reach.
    """
    free = world.is_free
    padded = np.pad(free, 1)
    beside = np.zeros_like(free)
    for up in range(3):
        for right in range(3):
            beside |= padded[up : up + free.shape[0], right : right + free.shape[1]]
    cells = np.where(beside & ~free, OCCUPIED, world.cells).astype(np.int8)
    return OccupancyMap(world.geometry, cells)


def obstacles(world: OccupancyMap) -> Obstacles:
    """Return the distances of a map to the walls that enclose its free space.

    On its own cells and MARGIN more on every side, so that walls at its edge have two sides.
    """
    wider = _widened(world)
    distance = distance_to_walls(enclosed(wider).is_wall, 1.0)
    behind = np.where(wider.is_free, 1.0, -1.0)
    return Obstacles(wider.geometry, (behind * np.minimum(distance, FARTHEST)).astype(np.float32))


def _widened(world: OccupancyMap) -> OccupancyMap:
    """Return a map with MARGIN more unknown cells on every side."""
    old = world.geometry
    corner = se2.compose(old.origin, [-MARGIN * old.resolution, -MARGIN * old.resolution, 0.0])
    x, y, theta = (float(value) for value in corner)
    cells = np.pad(world.cells, MARGIN, constant_values=UNKNOWN)
    rows, cols = cells.shape
    geometry = GridGeometry(rows, cols, old.resolution, (x, y, theta))
    return OccupancyMap(geometry, cells)
