"""The passes over particles, one by one, in float64 and plain Python.

Twins of `localizer.particle_kernels` and `localizer.landmark_kernels`; tables have two dimensions
here, and poses are moved by the core's own mathematics.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import GridGeometry
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.landmark_sightings import Sightings

Array = NDArray[np.float64]


def summed_costs(
    poses: Array,
    ends_base: Array,
    costs: NDArray[np.uint8],
    geometry: GridGeometry,
    is_free: NDArray[np.bool_],
) -> list[int]:
    """Twin of `weigh_ends`: `costs` (rows, cols) has a margin all around `geometry`."""
    margin = (costs.shape[0] - geometry.rows) // 2
    sums = []
    for pose in poses:
        (own,) = geometry.cells_of(pose[None, :2])
        if not geometry.contains(own[None])[0] or not is_free[tuple(own)]:
            sums.append(255 * len(ends_base))
            continue
        cells = geometry.cells_of(se2.transform_points(pose, ends_base)) + margin
        sums.append(sum(int(costs[row, col]) for row, col in cells))
    return sums


def summed_levels(
    poses: Array,
    bearings: Array,
    costs: NDArray[np.float32],
    levels: NDArray[np.uint8],
    geometry: GridGeometry,
) -> list[float]:
    """Twin of `sum_levels`: `levels` (rows, cols, headings)."""
    sums = []
    for pose in poses:
        (cell,) = geometry.cells_of(pose[None, :2])
        total = 0.0
        if geometry.contains(cell[None])[0]:
            for beam, bearing in enumerate(bearings):
                turns = (pose[2] + bearing) / math.tau
                layer = round(turns * levels.shape[2]) % levels.shape[2]
                total += float(costs[beam, levels[cell[0], cell[1], layer]])
        sums.append(total)
    return sums


def systematic_indices(weights: Array, count: int, offset: float) -> NDArray[np.int64]:
    """Twin of `draw_systematic`: a comb of even teeth over the summed weights."""
    teeth = (np.arange(count) + offset) / count
    summed = np.cumsum(weights / weights.sum())
    last = int(np.nonzero(weights)[0][-1])
    return np.minimum(np.searchsorted(summed, teeth, side="right"), last)


def needed(bins: list[int], limits: tuple[int, int, float, float]) -> int:
    """Twin of `count_needed` for bins in the order of drawing: Fox 2003, the algorithm of table 1.

    At the end of the bins, what those that were met call for.
    """
    least, most, epsilon, quantile = limits
    bound = float(least)
    for count in range(1, len(bins) + 1):
        k = len(set(bins[:count]))
        if k > 1:
            bound = max(bound, kld_bound(k, epsilon, quantile))
        if count >= bound:
            return min(most, max(least, count))
    return min(most, max(least, math.ceil(bound)))


def kld_bound(k: int, epsilon: float, quantile: float) -> float:
    """Particles that k bins call for (Fox 2003, eq. 7)."""
    part = 2.0 / (9.0 * (k - 1))
    return float((k - 1) / (2.0 * epsilon) * (1.0 - part + math.sqrt(part) * quantile) ** 3)


def sightings_log_likelihood(
    pose: Array, seen: Sightings, landmarks: LandmarkMap, outlier: float
) -> float:
    """Twin of `add_sightings` for one pose: the best candidate of each sighting counts."""
    total = 0.0
    for i, (kind, identity) in enumerate(zip(seen.kinds, seen.identities, strict=True)):
        fits = []
        for place in landmarks.candidates(kind, identity):
            x, y = se2.transform_points(se2.inverse(pose), place[None])[0]
            away = (math.hypot(x, y) - seen.ranges[i]) / seen.range_sigmas[i]
            turn = math.remainder(math.atan2(y, x) - seen.bearings[i], math.tau)
            fits.append(math.exp(-0.5 * (away**2 + (turn / seen.bearing_sigmas[i]) ** 2)))
        if fits:
            total += math.log((1.0 - outlier) * max(fits) + outlier)
    return total
