"""What a look would tell in plain numpy: the same table, ranges compared, and beliefs by Bayes."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.range_table import expected_ranges
from pilotage.planner.expected_scans import HEADINGS, LEVELS, SightParams
from pilotage.planner.hypotheses import ALIKE, NEAR
from pilotage.planner.situation import Hypotheses


class PlainLooks:
    """Gains on one map."""

    def __init__(self, world: OccupancyMap, params: SightParams, observations: int) -> None:
        self._params = params
        self._observations = observations
        ratio = max(1, round(params.resolution / world.geometry.resolution))
        rows, cols = (-(-length // ratio) for length in world.geometry.shape)
        cell = ratio * world.geometry.resolution
        self._geometry = GridGeometry(rows, cols, cell, world.geometry.origin)
        ranges = expected_ranges(world, self._geometry, HEADINGS, params.range_max)
        self._step = np.float32(params.range_max / LEVELS)
        self._levels = np.rint(ranges / self._step).astype(np.uint8)

    def gain(self, belief: Hypotheses, point: NDArray[np.float64]) -> float:
        """Return the gain [bit] of a full turn at a displacement (2,)."""
        scans = self._scans(belief.moved([point[0], point[1], 0.0]).poses)
        positions = (np.arange(self._observations) + 0.5) / self._observations
        truths = np.searchsorted(np.cumsum(belief.weights), positions)
        truths = np.minimum(truths, len(belief.weights) - 1)
        left = [_entropy(self._weighed(belief.weights, scans, truth)) for truth in truths]
        return float(_entropy(belief.weights) - np.mean(left))

    def _scans(self, poses: NDArray[np.float64]) -> NDArray[np.float32]:
        """Return the ranges (beams, n) of all beams at poses (n, 3), 0 off the map."""
        cells = self._geometry.cells_of(poses[:, :2])
        inside = self._geometry.contains(cells)
        row, col = np.where(inside[:, None], cells, 0).T
        beams = np.arange(self._params.beams) * (HEADINGS / self._params.beams)
        bins = np.rint(poses[:, 2] * (HEADINGS / (2.0 * np.pi)) + beams[:, None]).astype(int)
        steps = self._levels[bins % HEADINGS, row, col] * inside
        ranges: NDArray[np.float32] = steps.astype(np.float32) * self._step
        return ranges

    def _weighed(
        self, weights: NDArray[np.float64], scans: NDArray[np.float32], truth: int
    ) -> NDArray[np.float64]:
        """Return the belief (n,) after what would be seen from one of its places."""
        params = self._params
        seen = scans[:, truth, None]
        off = (scans - seen) / (params.sigma + params.sigma_per_metre * seen)
        costs = np.minimum(params.bound, 0.5 * off**2).sum(axis=0)
        after = weights * np.exp(-params.tempering * costs)
        shares: NDArray[np.float64] = after / after.sum()
        return shares


def plain_merged(belief: Hypotheses, most: int) -> Hypotheses:
    """Return the places of a belief, each being its heaviest sample with the weight of all."""
    firsts = np.empty((most, 3))
    mass, count = np.zeros(most), 0
    for i in np.argsort(-belief.weights, kind="stable"):
        off = firsts[:count] - belief.poses[i]
        near = np.hypot(off[:, 0], off[:, 1]) <= NEAR
        places = np.flatnonzero(near & (np.abs(wrap(off[:, 2])) <= ALIKE))
        if len(places):
            mass[places[0]] += belief.weights[i]
        elif count < most:
            firsts[count], mass[count] = belief.poses[i], belief.weights[i]
            count += 1
    return Hypotheses(firsts[:count], mass[:count] / mass[:count].sum())


def _entropy(weights: NDArray[np.float64]) -> float:
    shares = weights[weights > 0.0]
    return float(-(shares * np.log2(shares)).sum())
