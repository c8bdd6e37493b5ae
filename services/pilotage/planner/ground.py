"""Where a body fits: how far each cell of a map is from the next that stops it; pure."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import GridGeometry, OccupancyMap

LEAST_GAP = 0.05
"""Gap in m to walls below which no way is planned."""
COMFORT = 0.35
"""Gap in m from which on more of it is worth nothing."""
CLOSENESS_COST = 4.0
"""What a metre costs more at the least gap than in the open."""


@dataclass(frozen=True)
class Terrain:
    """Ground as a body meets it: `passable` (rows, cols), `cost` >= 1 of a metre (rows, cols)."""

    passable: NDArray[np.bool_]
    cost: NDArray[np.float32]


@dataclass(frozen=True)
class Ground:
    """A map, and the distance (rows, cols) in m from each cell to the nearest that stops bodies.

    Bodies are stopped by occupied and unknown cells, by the edge of the map, and by obstacles
    that the map lacks. `clearance` is measured from centre to centre.
    """

    world: OccupancyMap
    clearance: NDArray[np.float32]

    @classmethod
    def of(cls, world: OccupancyMap) -> "Ground":
        """Return the ground of a map alone."""
        return cls(world, _clearance(~world.is_free, world.geometry.resolution))

    def with_obstacles(self, points_map: ArrayLike) -> "Ground":
        """Return the ground with the cells that hold points (n, 2) of the map frame blocked."""
        cells = self.geometry.cells_of(np.reshape(np.asarray(points_map, float), (-1, 2)))
        inside = cells[self.geometry.contains(cells)]
        if len(inside) == 0:
            return self
        blocked = self.is_blocked.copy()
        blocked[tuple(inside.T)] = True
        return replace(self, clearance=_clearance(blocked, self.geometry.resolution))

    @property
    def geometry(self) -> GridGeometry:
        """Size and place of the map."""
        return self.world.geometry

    @cached_property
    def is_blocked(self) -> NDArray[np.bool_]:
        """Cells (rows, cols) that stop bodies."""
        blocked: NDArray[np.bool_] = (self.clearance == 0.0) | ~self.world.is_free
        return blocked

    @cached_property
    def _is_unseen_edge(self) -> NDArray[np.bool_]:
        """Unknown cells (rows, cols) next to free ones."""
        free = np.pad(self.world.is_free, 1)
        beside_free = free[:-2, 1:-1] | free[2:, 1:-1] | free[1:-1, :-2] | free[1:-1, 2:]
        edge: NDArray[np.bool_] = (self.world.cells < 0) & beside_free
        return edge

    def unseen_near(self, point: ArrayLike, reach: float) -> NDArray[np.float64]:
        """Return where unknown ground begins, which no laser sees: centres (n, 2), map frame.

        Only within a square of `reach` m round a point (2,) of the map frame.
        """
        row, col = self.geometry.cells_of(np.atleast_2d(point))[0]
        span = int(np.ceil(reach / self.geometry.resolution))
        first = np.maximum([row - span, col - span], 0)
        last = np.maximum([row + span + 1, col + span + 1], 0)
        window = self._is_unseen_edge[first[0] : last[0], first[1] : last[1]]
        return self.geometry.centres_of(np.argwhere(window) + first)

    def gaps_at(self, points_map: ArrayLike) -> NDArray[np.float64]:
        """Return how far (n,) in m points (n, 2) of the map frame are from what stops bodies.

        Up to half a cell is deducted: what stops begins at the face of its cell. Off the map: 0.
        """
        cells = self.geometry.cells_of(np.reshape(np.asarray(points_map, float), (-1, 2)))
        gaps, inside = np.zeros(len(cells)), self.geometry.contains(cells)
        gaps[inside] = self.clearance[tuple(cells[inside].T)] - 0.5 * self.geometry.resolution
        return np.maximum(gaps, 0.0)

    def needed(self, radius: float) -> float:
        """Return the clearance in m of cells that the centre of such a body may cross."""
        return radius + LEAST_GAP + 0.5 * self.geometry.resolution

    def terrain(self, radius: float) -> Terrain:
        """Return where a body of this radius in m fits and what it costs: more near walls."""
        least = np.float32(self.needed(radius))
        span = np.float32(COMFORT - LEAST_GAP)
        closeness = np.clip((least + span - self.clearance) / span, 0.0, 1.0)
        return Terrain(self.clearance >= least, 1.0 + np.float32(CLOSENESS_COST) * closeness**2)


def _clearance(blocked: NDArray[np.bool_], resolution: float) -> NDArray[np.float32]:
    """Return the distance (rows, cols) in m to the nearest blocked cell; the edge is blocked."""
    with_rim = np.pad(blocked, 1, constant_values=True)
    return np.ascontiguousarray(distance_to_walls(with_rim, resolution)[1:-1, 1:-1])
