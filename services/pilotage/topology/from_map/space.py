"""The space between the walls of a map: free ground without furniture and without rays of noise."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from pilotage.core.distance_field import distance_to_walls, nearest_walls
from pilotage.core.grid import GridGeometry, OccupancyMap

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class SpaceParams:
    """What of a map's free cells is taken for the space of a building."""

    least_island: float = 1.5
    """Occupied or unknown pieces smaller than this across, m, are furniture or dust."""
    largest_furniture: float = 4.0
    """m: what stands alone and is smaller across is furniture too,"""
    thickest_pier: float = 0.5
    """if it is thicker than a piece of wall between two doors, m."""
    least_gap: float = 0.5
    """Free strips narrower than this, m, are rays that went through glass or past a jamb."""
    least_area: float = 4.0
    """Free pieces smaller than this, m^2, are seen through a window."""


@dataclass(frozen=True)
class Space:
    """Free ground of a building: `is_free` (rows, cols) over `geometry`, walled in all round."""

    geometry: GridGeometry
    is_free: Mask

    @property
    def resolution(self) -> float:
        """Width of a cell, m."""
        return self.geometry.resolution

    @cached_property
    def clearance(self) -> NDArray[np.float32]:
        """Distance (rows, cols) from each cell to the nearest wall, m."""
        return distance_to_walls(~self.is_free, self.resolution)

    @cached_property
    def nearest(self) -> NDArray[np.int32]:
        """The nearest wall cell (rows, cols, 2) of each cell."""
        return nearest_walls(~self.is_free)

    def free_at(self, points: NDArray[np.float64]) -> Mask:
        """Say for points (n, 2) of the map frame whether they are free; outside is not."""
        cells = self.geometry.cells_of(points)
        inside = self.geometry.contains(cells)
        free = np.zeros(len(cells), bool)
        free[inside] = self.is_free[tuple(cells[inside].T)]
        return free


def space_of(world: OccupancyMap, params: SpaceParams) -> Space:
    """Return the space of a building from its map."""
    geometry, free = _walled_in(world)
    free = _without_islands(free, geometry.resolution, params)
    free = _without_slits(free, params.least_gap / 2.0, geometry.resolution)
    free = _without_patches(free, params.least_area / geometry.resolution**2)
    return Space(geometry, free)


def drivable_space(world: OccupancyMap) -> Space:
    """Return the free ground of a map as it is, furniture and all, walled in all round."""
    return Space(*_walled_in(world))


def _walled_in(world: OccupancyMap) -> tuple[GridGeometry, Mask]:
    """Return the free cells with a ring of walls round them, and where they then lie."""
    old = world.geometry
    x, y = old.centres_of([[-1.5, -1.5]])[0]
    origin = (float(x), float(y), old.origin[2])
    geometry = GridGeometry(old.rows + 2, old.cols + 2, old.resolution, origin)
    return geometry, np.pad(world.is_free, 1)


def _without_islands(free: Mask, resolution: float, params: SpaceParams) -> Mask:
    """Return the free cells with dust and furniture that stand alone among them."""
    count, labels, sizes = _pieces(~free, 8)
    across = np.hypot(sizes[:, cv2.CC_STAT_WIDTH], sizes[:, cv2.CC_STAT_HEIGHT]) * resolution
    depth = np.zeros(count)
    np.maximum.at(depth, labels.ravel(), distance_to_walls(free, resolution).ravel())
    is_solid = 2.0 * depth > params.thickest_pier
    island = (across < params.least_island) | (is_solid & (across < params.largest_furniture))
    # What is free is none, nor is what lies round the map, however small the map is.
    island[[0, labels[0, 0]]] = False
    return free | island[labels]


def _without_slits(free: Mask, radius: float, resolution: float) -> Mask:
    """Return the cells that a disc of this radius, m, covers without leaving the free ones."""
    centres = distance_to_walls(~free, resolution) > radius
    reached = distance_to_walls(centres, resolution) <= radius + resolution / 2.0
    return free & reached


def _without_patches(free: Mask, least: float) -> Mask:
    """Return the free cells that hang together in pieces of at least so many."""
    _, labels, sizes = _pieces(free, 4)
    large = sizes[:, cv2.CC_STAT_AREA] >= least
    large[0] = False
    return free & large[labels]


def _pieces(mask: Mask, connectivity: int) -> tuple[int, NDArray[np.int32], NDArray[np.int32]]:
    """Return how many pieces there are, with 0 for the rest; labels, and OpenCV's statistics."""
    count, labels, sizes, _ = cv2.connectedComponentsWithStats(
        mask.astype(np.uint8), connectivity=connectivity
    )
    return count, labels.astype(np.int32), sizes.astype(np.int32)
