"""How well a laser beam's end fits the map, precomputed per cell (Thrun et al. 2005, 6.4).

A beam that ends at distance d from the nearest wall has the likelihood

    p(d) = (1 - outlier) * exp(-d^2 / (2 sigma^2)) + outlier

relative to its best. The field holds -log p in steps of a 63rd of -log(outlier), one byte a
cell, so that a scan is weighed over all states of a heading by adding shifted rows of bytes,
four of which sum up within a byte. Rounding to such steps adds 0.014 to a beam's -log p (r.m.s.),
before tempering.

A belief over cells knows a beam's end only as exactly as its cells and headings are fine, and
the heading's share grows with the range. Beams are therefore sorted into classes of range, each
with a field whose sigma takes the width of a heading bin at that range into account.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.localizer.kernels import LANES, MOST_COST, Scan
from pilotage.localizer.least_costs import LeastCosts, least_costs

STEPS = MOST_COST

SPARE = 10
"""Cells by which the margin is wider than the longest beam: rounding, and a tile of cells that
only partly lies on the map (see rest)."""


@dataclass(frozen=True)
class LikelihoodFieldParams:
    """Parameters of the likelihood field.

    `sigma`: spread of a beam's end about the wall [m]: sensor, map and what moved a little.
    `outlier`: likelihood of an end anywhere, relative to the best [-].
    `class_limits`: upper ends of the classes of range [m]; longer beams are not used, because
    a heading bin moves their ends by more than a room's features.
    """

    sigma: float = 0.12
    outlier: float = 0.05
    class_limits: tuple[float, ...] = (2.0, 4.0, 8.0, 16.0)


@dataclass(frozen=True)
class LikelihoodField:
    """Costs (classes, rows + 2 margin, cols + 2 margin) uint8; `step` turns them into -log p.

    The margin, wider than the longest beam, has the highest cost: ends beyond the map. `flat` is
    the same memory in one row, LANES bytes longer. `least`: see least_costs.
    """

    flat: NDArray[np.uint8]
    costs: NDArray[np.uint8]
    least: LeastCosts
    step: float
    margin: int
    class_limits: NDArray[np.float64]

    def classes_of(self, ranges: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the class (n,) of each range (n,); len(class_limits) where it is too long."""
        return np.searchsorted(self.class_limits, ranges).astype(np.int64)

    def scan(self, ranges: NDArray[np.float64], ends: NDArray[np.int64], tempering: float) -> Scan:
        """Return what the kernels look up for beams of `ranges` (n,).

        Their ends lie `ends` (headings, n, 2) rows and cols off a state; their likelihood counts
        to the power `tempering`.
        """
        height, width = self.costs.shape[1:]
        rows, cols = np.moveaxis(ends + self.margin, -1, 0)
        starts = (self.classes_of(ranges) * height + rows) * width + cols
        costs = np.arange(len(ranges) * STEPS + 1) * (self.step * tempering)
        likelihood = np.exp(-costs).astype(np.float32)
        return Scan(starts.astype(np.uint64), self.flat, width, likelihood)

    def coarse_scan(self, scan: Scan, phases: NDArray[np.int64]) -> Scan:
        """Return the same scan for tiles of states whose phases are (headings, 2), see `rest`."""
        return self.least.scan(scan, self.costs.shape, phases)


def likelihood_field(
    world: OccupancyMap, geometry: GridGeometry, heading_step: float, params: LikelihoodFieldParams
) -> LikelihoodField:
    """Return the field of a map on the cells of `geometry` and a margin around them.

    Args:
        world: the map.
        geometry: cells of the belief.
        heading_step: width of a heading bin [rad].
        params: sensor parameters.
    """
    limits = np.array(params.class_limits)
    margin = int(np.ceil(limits[-1] / geometry.resolution)) + SPARE
    distance = _distance_at_centres(world, _widened(geometry, margin))
    step = -np.log(params.outlier) / STEPS
    flat = np.full(len(limits) * distance.size + LANES, STEPS, np.uint8)
    costs = flat[:-LANES].reshape(len(limits), *distance.shape)
    for index, sigma in enumerate(_sigmas(limits, geometry.resolution, heading_step, params)):
        likelihood = (1.0 - params.outlier) * np.exp(-0.5 * (distance / sigma) ** 2)
        costs[index] = np.rint(-np.log(likelihood + params.outlier) / step)
    return LikelihoodField(flat, costs, least_costs(costs), step, margin, limits)


def _widened(geometry: GridGeometry, margin: int) -> GridGeometry:
    """Return the geometry with `margin` more cells on every side."""
    out = -margin * geometry.resolution
    x, y, theta = (float(value) for value in se2.compose(geometry.origin, [out, out, 0.0]))
    rows, cols = (length + 2 * margin for length in geometry.shape)
    return GridGeometry(rows, cols, geometry.resolution, (x, y, theta))


def _sigmas(
    limits: NDArray[np.float64],
    resolution: float,
    heading_step: float,
    params: LikelihoodFieldParams,
) -> NDArray[np.float64]:
    """Return sigma of each class: the sensor's, a cell's and a heading bin's (uniform: w^2/12)."""
    middles = (np.concatenate([[0.0], limits[:-1]]) + limits) / 2.0
    spread = params.sigma**2 + (resolution**2 + (middles * heading_step) ** 2) / 12.0
    sigmas: NDArray[np.float64] = np.sqrt(spread)
    return sigmas


def _distance_at_centres(world: OccupancyMap, geometry: GridGeometry) -> NDArray[np.float64]:
    """Return the distance to the nearest wall at the centres of cells; infinity off the map."""
    fine = distance_to_walls(world.is_wall, world.geometry.resolution)
    cells = world.geometry.cells_of(geometry.centres_of(np.argwhere(np.ones(geometry.shape, bool))))
    inside = world.geometry.contains(cells)
    distance = np.full(len(cells), np.inf)
    distance[inside] = fine[tuple(cells[inside].T)]
    return distance.reshape(geometry.shape)
