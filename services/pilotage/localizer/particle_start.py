"""Where particles are drawn from when nothing, or one pose, is known."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap

TRIES = 10
"""Draws per particle around a pose; so few may fall into free space."""


@dataclass(frozen=True)
class FreeSpace:
    """The free cells (n, 2), as row and col, of a geometry; `mask` (rows, cols) says the same."""

    geometry: GridGeometry
    cells: NDArray[np.int64]
    mask: NDArray[np.bool_]

    def draw(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return poses (count, 3), uniform over the free space and all headings."""
        chosen = self.cells[rng.integers(len(self.cells), size=count)]
        within = chosen[:, ::-1] + rng.random((count, 2))
        poses = np.empty((count, 3))
        poses[:, :2] = within * self.geometry.resolution
        poses[:, 2] = rng.uniform(-np.pi, np.pi, count)
        return se2.compose(self.geometry.origin, poses)

    def draw_around(
        self,
        map_from_base: ArrayLike,
        covariance: NDArray[np.float64],
        count: int,
        rng: np.random.Generator,
    ) -> NDArray[np.float64]:
        """Return free poses (count, 3) about a pose (3,) with covariance (3, 3), map frame.

        ValueError if that is no covariance or no free space is near.
        """
        mean = np.asarray(map_from_base, float)
        poses = rng.multivariate_normal(mean, covariance, TRIES * count, check_valid="raise")
        kept = poses[self.holds(poses)][:count]
        if not len(kept):
            raise ValueError("the pose is not in the map's free space")
        return se2.compose(kept[np.arange(count) % len(kept)], np.zeros(3))

    def holds(self, poses: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Say of poses (n, 3) whether they lie in free space."""
        cells = self.geometry.cells_of(poses[:, :2])
        inside = self.geometry.contains(cells)
        inside[inside] = self.mask[tuple(cells[inside].T)]
        return inside


def free_space(world: OccupancyMap) -> FreeSpace:
    """Return the free space of a map; ValueError if there is none."""
    if not world.is_free.any():
        raise ValueError("the map has no free cell: a robot can be nowhere on it")
    return FreeSpace(world.geometry, np.argwhere(world.is_free), world.is_free)
