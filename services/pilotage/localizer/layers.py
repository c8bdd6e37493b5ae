"""Where the layers of a belief lie: headings that turn, and offsets of less than half a cell.

Frames: `grid` is the map frame moved to the corner of cell (0, 0) and turned to its axes.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.localizer.pose_grid import PoseGrid


class Layers:
    """One layer per heading, each moving as a robot of that heading does.

    Attributes:
        headings: (headings,) of each layer in the grid frame [rad].
        offsets: (headings, 2) of each layer's cells from the grid's, x and y [cells].
    """

    def __init__(self, grid: PoseGrid) -> None:
        self._grid = grid
        self._steps = np.arange(grid.headings) * grid.heading_step
        self.anchor()

    def anchor(self) -> None:
        """Put the layers onto the map's cells and headings."""
        self._turn_to(0.0)
        self.offsets = np.zeros((self._grid.headings, 2))

    def move(self, dx: float, dy: float, turn: float) -> NDArray[np.int64]:
        """Move by metres and radians; return whole rows and cols (headings, 2) for the states."""
        cos, sin = np.cos(self.headings), np.sin(self.headings)
        along = np.stack([cos * dx - sin * dy, sin * dx + cos * dy], axis=1)
        self.offsets += along / self._grid.geometry.resolution
        self._turn_to(wrap(self._origin_heading + turn))
        whole = np.rint(self.offsets)
        self.offsets -= whole
        return np.ascontiguousarray(whole[:, ::-1].astype(np.int64))

    def shifts(self) -> NDArray[np.int64]:
        """Return by how many whole rows and cols (headings, 2) layer k + 1 lies beyond layer k."""
        apart = np.roll(self.offsets, -1, axis=0) - self.offsets
        return np.rint(apart[:, ::-1]).astype(np.int64)

    def poses_of(self, states: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the poses (n, 3) in the map frame of states (n, 3) as heading, row, col."""
        k, row, col = states.T
        resolution = self._grid.geometry.resolution
        x = (col + 0.5 + self.offsets[k, 0]) * resolution
        y = (row + 0.5 + self.offsets[k, 1]) * resolution
        grid_from_base = np.stack([x, y, self.headings[k]], axis=1)
        return se2.compose(self._grid.geometry.origin, grid_from_base)

    def cells_of_ends(self, ends_base: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return row and col (headings, n, 2) by which each beam's end lies off a state."""
        cos, sin = np.cos(self.headings)[:, None], np.sin(self.headings)[:, None]
        x, y = ends_base.T / self._grid.geometry.resolution
        cols = np.floor(0.5 + self.offsets[:, :1] + cos * x - sin * y)
        rows = np.floor(0.5 + self.offsets[:, 1:] + sin * x + cos * y)
        return np.stack([rows, cols], axis=-1).astype(np.int64)

    def offsets_along(self, bearings: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how far [m] each layer's states lie ahead of their cells (headings, n).

        Ahead is along each bearing. A wall that a beam meets head-on is nearer by just that; one
        that it meets at an angle a to its normal by something that errs less than nothing at all
        does (tan a instead of 1 / cos a, root mean square, in offsets).
        """
        directions = self.headings[:, None] + bearings[None, :]
        along = np.cos(directions) * self.offsets[:, :1] + np.sin(directions) * self.offsets[:, 1:]
        ahead: NDArray[np.float64] = along * self._grid.geometry.resolution
        return ahead

    def directions_of(self, bearings: NDArray[np.float64], count: int) -> NDArray[np.int64]:
        """Return which of `count` directions of the map (headings, n) each bearing points along."""
        map_headings = self.headings + self._grid.geometry.origin[2]
        turns = (map_headings[:, None] + bearings[None, :]) / (2.0 * np.pi)
        return np.rint(turns * count).astype(np.int64) % count

    def _turn_to(self, origin_heading: float) -> None:
        turned: NDArray[np.float64] = np.add(origin_heading, self._steps)
        self._origin_heading, self.headings = origin_heading, wrap(turned)
