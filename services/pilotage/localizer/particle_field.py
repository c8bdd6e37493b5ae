"""How well the ends of a scan's beams fit the map, looked up per particle.

The likelihood field of Thrun et al. 2005, 6.4, as in `likelihood_field`, but on the map's own
cells, for a particle knows its pose better than a cell of the Markov grid does.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import OccupancyMap
from pilotage.localizer import particle_kernels as kernels

STEPS = 255


@dataclass(frozen=True)
class BeamModel:
    """How beams err.

    `sigma`: spread of a beam's end about the wall [m]: sensor, map, and what moved a little.
    `outlier`: likelihood of an end anywhere, relative to the best [-].
    `reach`: longer beams [m] are not used, as errors of the heading blur their ends.
    """

    sigma: float = 0.12
    outlier: float = 0.05
    reach: float = 16.0


@dataclass(frozen=True)
class ParticleField:
    """-log p of a beam's end per cell, in bytes of `step`, padded by the reach of a beam."""

    costs: kernels.Cells
    is_free: NDArray[np.bool_]
    step: float
    reach: float

    def log_likelihoods(
        self, poses: NDArray[np.float64], ends_base: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return log p (n,) of beams that end at `ends_base` (m, 2), as seen from poses (n, 3).

        Zero at the best; poses off the free cells have the least, as if every beam were wrong.
        """
        return self._summed_costs(poses, ends_base).astype(np.float64) * -self.step

    def mean_likelihoods(
        self, poses: NDArray[np.float64], ends_base: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the geometric mean (n,) of the beams' likelihoods, in [outlier, 1]."""
        beams = max(1, len(self.used(ends_base)))
        fits: NDArray[np.float64] = np.exp(self.log_likelihoods(poses, ends_base) / beams)
        return fits

    def used(self, ends_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the ends (k, 2) of the beams that are not too long."""
        near: NDArray[np.float64] = ends_base[np.hypot(*ends_base.T) <= self.reach]
        return near

    def _summed_costs(
        self, poses: NDArray[np.float64], ends_base: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        in_cells = self.used(ends_base).T / self.costs.resolution
        total = np.empty(len(poses), np.int64)
        ends = np.ascontiguousarray(in_cells, np.float32)
        kernels.weigh_ends(poses, ends, self.costs, self.is_free, total)
        return total


def particle_field(world: OccupancyMap, model: BeamModel) -> ParticleField:
    """Return the field of a map; ValueError if it has no free cell."""
    if not world.is_free.any():
        raise ValueError("the map has no free cell: a robot can be nowhere on it")
    geometry = world.geometry
    # Two cells more: one for the cell the particle stands in, one for rounding.
    margin = int(np.ceil(model.reach / geometry.resolution)) + 2
    is_wall = np.pad(world.is_wall, margin)
    distance = distance_to_walls(is_wall, geometry.resolution)
    likelihood = (1.0 - model.outlier) * np.exp(-0.5 * (distance / model.sigma) ** 2)
    step = -np.log(model.outlier) / STEPS
    costs = np.rint(-np.log(likelihood + model.outlier) / step).astype(np.uint8)
    cells = kernels.Cells(
        costs.ravel(), costs.shape[1], margin, *geometry.origin, geometry.resolution
    )
    return ParticleField(cells, np.ascontiguousarray(world.is_free), float(step), model.reach)
