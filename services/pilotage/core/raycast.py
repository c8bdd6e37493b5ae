"""Exact ray casting: how far a beam travels through the cells before it meets a wall.

Distances end on the boundary of the first wall cell; unknown cells are transparent; a ray that
leaves the grid (or starts outside it) meets nothing.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.cell_traversal import cast_ray_in_grid, cast_rays_in_grid
from pilotage.core.grid import OccupancyMap
from pilotage.core.range_table import expected_ranges

__all__ = ["cast_ray_in_grid", "cast_rays", "cast_scan", "expected_ranges"]


def cast_rays(world: OccupancyMap, poses: ArrayLike, range_max: float) -> NDArray[np.float64]:
    """Return the range (n,) in m along +x of each pose (n, 3) of the map frame.

    A ray that starts in a wall measures 0, one that meets no wall within `range_max` m infinity.
    """
    geometry = world.geometry
    rays = se2.compose(se2.inverse(geometry.origin), np.reshape(np.asarray(poses, float), (-1, 3)))
    rays[:, :2] /= geometry.resolution
    distances = cast_rays_in_grid(world.is_wall, rays, range_max / geometry.resolution)
    return distances * geometry.resolution


def cast_scan(
    world: OccupancyMap, pose: ArrayLike, bearings: ArrayLike, range_max: float
) -> NDArray[np.float64]:
    """Return the ranges (m,) in m that a laser at `pose` (3,) measures at `bearings` (m,) rad."""
    angles = np.asarray(bearings, float)
    beams = np.zeros((len(angles), 3))
    beams[:, 2] = angles
    return cast_rays(world, se2.compose(pose, beams), range_max)
