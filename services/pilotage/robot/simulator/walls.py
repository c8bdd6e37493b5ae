"""What stops beams and bodies in a simulated world; pure."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.cell_traversal import cast_rays_in_grid
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import OCCUPIED, GridGeometry, OccupancyMap
from pilotage.robot.simulator.doors import NO_DOORS, Doors
from pilotage.robot.simulator.floor_canvas import Box


@dataclass(frozen=True)
class Walls:
    """Cells of a world.

    `stops_beams`: occupied; `stops_bodies`: occupied or unknown, for nobody has been there.
    Both bool (rows, cols), leaves of `doors` that are shut included.
    """

    geometry: GridGeometry
    stops_beams: NDArray[np.bool_]
    stops_bodies: NDArray[np.bool_]
    doors: Doors = NO_DOORS

    @classmethod
    def of(
        cls, world: OccupancyMap, unmapped: tuple[Box, ...] = (), doors: Doors = NO_DOORS
    ) -> "Walls":
        """Return the walls of a map, with boxes and leaves of doors that the map lacks."""
        cells = world.cells.copy()
        for box in unmapped:
            _add_box(cells, world.geometry, box)
        doors.fill(cells, world.geometry, OCCUPIED)
        real = OccupancyMap(world.geometry, cells)
        return cls(world.geometry, real.is_wall, ~real.is_free, doors)

    @cached_property
    def clearance(self) -> NDArray[np.float32]:
        """Distance (rows, cols) in m, centre to centre, to the nearest cell that stops bodies."""
        return distance_to_walls(self.stops_bodies, self.geometry.resolution)

    def ranges(
        self, origin: ArrayLike, bearings: ArrayLike, range_max: float
    ) -> NDArray[np.float64]:
        """Return how far beams at `bearings` (n,) rad see from the pose `origin` (3,), map frame.

        Infinite where nothing is met within `range_max` m.
        """
        angles = np.asarray(bearings, float)
        beams = np.zeros((len(angles), 3))
        x, y, theta = se2.compose(se2.inverse(self.geometry.origin), origin)
        cell = self.geometry.resolution
        beams[:, 0], beams[:, 1], beams[:, 2] = x / cell, y / cell, theta + angles
        return cast_rays_in_grid(self.stops_beams, beams, range_max / cell) * cell

    def nearest(self, x: float, y: float, reach: float) -> tuple[float, float]:
        """Return distance in m and direction in rad (map frame) from a point to what stops bodies.

        Exact to the faces of the cells within `reach` m; infinity and 0 if there are none. A
        point outside of the grid is at distance 0.
        """
        u, v, _ = se2.compose(se2.inverse(self.geometry.origin), (x, y, 0.0)) / np.array(
            [self.geometry.resolution, self.geometry.resolution, 1.0]
        )
        rows, cols = self.geometry.shape
        if not (0.0 <= u < cols and 0.0 <= v < rows):
            return 0.0, 0.0
        span = int(reach / self.geometry.resolution) + 1
        row0, col0 = max(int(v) - span, 0), max(int(u) - span, 0)
        window = self.stops_bodies[row0 : int(v) + span + 1, col0 : int(u) + span + 1]
        near_rows, near_cols = np.nonzero(window)
        if len(near_rows) == 0:
            return np.inf, 0.0
        dx = np.clip(u, near_cols + col0, near_cols + col0 + 1.0) - u
        dy = np.clip(v, near_rows + row0, near_rows + row0 + 1.0) - v
        i = int(np.argmin(dx**2 + dy**2))
        direction = float(np.arctan2(dy[i], dx[i])) + self.geometry.origin[2]
        return float(np.hypot(dx[i], dy[i])) * self.geometry.resolution, direction

    def is_wall_at(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Say which points (n, 2) of the map frame lie in cells that stop beams."""
        cells = self.geometry.cells_of(points)
        is_inside = self.geometry.contains(cells)
        rows, cols = np.where(is_inside[:, None], cells, 0).T
        is_wall: NDArray[np.bool_] = is_inside & self.stops_beams[rows, cols]
        return is_wall

    def overlaps(self, x: float, y: float, radius: float) -> bool:
        """Say whether a disc at a point of the map frame would stand in a wall."""
        row, col = self.geometry.cells_of([[x, y]])[0]
        if not (0 <= row < self.geometry.rows and 0 <= col < self.geometry.cols):
            return True
        # Centre to centre is at most one cell's diagonal off; most of a floor needs no more.
        if self.clearance[row, col] > radius + 1.5 * self.geometry.resolution:
            return False
        return self.nearest(x, y, radius)[0] < radius

    def places(self, clearance: float) -> NDArray[np.float64]:
        """Return cell centres (n, 2), map frame, that a body of this radius can reach.

        Of several regions cut off from each other, the largest.
        """
        # The face of a cell is up to half its diagonal nearer than its centre.
        half_diagonal = self.geometry.resolution * np.sqrt(0.5)
        reached = _largest_region(self.clearance >= clearance + half_diagonal)
        return self.geometry.centres_of(np.argwhere(reached))


def _add_box(cells: NDArray[np.int8], geometry: GridGeometry, box: Box) -> None:
    (row0, col0), (row1, col1) = geometry.cells_of([box[:2], box[2:]])
    rows, cols = sorted((row0, row1)), sorted((col0, col1))
    cells[max(rows[0], 0) : rows[1] + 1, max(cols[0], 0) : cols[1] + 1] = OCCUPIED


def _largest_region(passable: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the largest connected part of a mask (rows, cols)."""
    left, largest = passable.copy(), np.zeros_like(passable)
    while np.count_nonzero(left) > np.count_nonzero(largest):
        region = _flooded(left, tuple(np.argwhere(left)[0]))
        left &= ~region
        if np.count_nonzero(region) > np.count_nonzero(largest):
            largest = region
    return largest


def _flooded(passable: NDArray[np.bool_], seed: tuple[int, ...]) -> NDArray[np.bool_]:
    """Return what is connected with a cell: sweeps forth and back until nothing is added."""
    region = np.zeros_like(passable)
    region[seed] = True
    count = 0
    while (grown := int(np.count_nonzero(region))) > count:
        count = grown
        for axis in (0, 1):
            for flip in (1, -1):
                _sweep(region, passable, axis, flip)
    return region


def _sweep(region: NDArray[np.bool_], passable: NDArray[np.bool_], axis: int, flip: int) -> None:
    """Spread a region along one axis in one direction, line by line, in place."""
    reached = np.moveaxis(region, axis, 0)[::flip]
    open_lines = np.moveaxis(passable, axis, 0)[::flip]
    for line in range(1, len(reached)):
        reached[line] |= reached[line - 1] & open_lines[line]
