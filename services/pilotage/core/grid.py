"""Where the cells of a grid lie in the world, and the occupancy map built on them.

Arrays are indexed [row, col]; world x grows with col and y with row, so row 0 is the bottom of
a drawing. `origin` is the pose, in the map frame, of the OUTER corner of cell (0, 0); the centre
of cell (row, col) lies at ((col + 0.5) * resolution, (row + 0.5) * resolution) from it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2

UNKNOWN = -1
FREE = 0
OCCUPIED = 100
OCCUPIED_FROM = 65
"""Cells of this value and more count as walls (the usual threshold of map_server)."""


@dataclass(frozen=True)
class GridGeometry:
    """Size and place of a grid: `rows` x `cols` cells of `resolution` metres."""

    rows: int
    cols: int
    resolution: float
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def shape(self) -> tuple[int, int]:
        """The shape of an array over this grid, (rows, cols)."""
        return self.rows, self.cols

    @property
    def size_m(self) -> tuple[float, float]:
        """Width (along the cols) and height (along the rows) in metres."""
        return self.cols * self.resolution, self.rows * self.resolution

    def grid_from_map(self, points_map: ArrayLike) -> NDArray[np.float64]:
        """Return points (n, 2) of the map frame in m from the grid's corner, along its axes."""
        return se2.transform_points(se2.inverse(self.origin), points_map)

    def cells_of(self, points_map: ArrayLike) -> NDArray[np.int64]:
        """Return the cells (n, 2) as row, col that hold points (n, 2); they may lie outside."""
        in_grid = self.grid_from_map(points_map) / self.resolution
        return np.floor(in_grid[:, ::-1]).astype(np.int64)

    def centres_of(self, cells: ArrayLike) -> NDArray[np.float64]:
        """Return the centres (n, 2), map frame, of cells (n, 2) given as row, col."""
        in_grid = (np.asarray(cells, float)[:, ::-1] + 0.5) * self.resolution
        return se2.transform_points(self.origin, in_grid)

    def contains(self, cells: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Say for cells (n, 2) whether they lie inside the grid."""
        inside: NDArray[np.bool_] = np.all((cells >= 0) & (cells < self.shape), axis=1)
        return inside


@dataclass(frozen=True)
class OccupancyMap:
    """A map: int8 `cells` (rows, cols), -1 unknown, 0 free to 100 occupied, on a geometry."""

    geometry: GridGeometry
    cells: NDArray[np.int8]

    def __post_init__(self) -> None:
        """Refuse cells that do not fit the geometry (ValueError)."""
        if self.cells.shape != self.geometry.shape:
            raise ValueError(f"map cells are {self.cells.shape}, geometry {self.geometry.shape}")

    @property
    def is_wall(self) -> NDArray[np.bool_]:
        """Cells that stop a beam: occupied ones."""
        return self.cells >= OCCUPIED_FROM

    @property
    def is_free(self) -> NDArray[np.bool_]:
        """Cells where a robot may stand: known and not occupied."""
        return (self.cells >= 0) & (self.cells < OCCUPIED_FROM)
