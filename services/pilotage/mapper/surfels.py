"""A piece of map to match scans against: walls as surfels, and the nearest one of every place."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.surfel_kernels import SurfelMap, pool_points, spread_nearest, wall_directions


@dataclass(frozen=True)
class SurfelParams:
    """How points become surfels."""

    cell: float = 0.05
    """m; points this near are one surfel, their mean, so that noise averages out."""
    reach: float = 0.30
    """m around a surfel within which a point can belong to it."""
    wall: float = 0.25
    """m around a surfel over which the direction of its wall is measured."""


def surfel_map(points: NDArray[np.float64], params: SurfelParams) -> SurfelMap:
    """Return the map of surfels of points (n, 2), n at least one, in their own frame."""
    reach = int(np.ceil(params.reach / params.cell))
    corner = points.min(axis=0) - (reach + 1) * params.cell
    extent = points.max(axis=0) - corner
    cols, rows = (int(size) for size in np.ceil(extent / params.cell) + reach + 2)
    index = np.full((rows, cols), -1, np.int32)
    means = pool_points(points, corner, index, params.cell)
    wall = round(params.wall / params.cell)
    normals, flatness = wall_directions(means, corner, index, params.cell, wall)
    nearest, distance = spread_nearest(means, corner, (rows, cols), params.cell, reach)
    return SurfelMap(means, normals, flatness, corner, params.cell, nearest, distance)
