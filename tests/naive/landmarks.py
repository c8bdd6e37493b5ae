"""What sightings of landmarks say of every state of a belief, in plain Python.

Twin of `localizer.landmark_tile_kernels`, whose tiles hold these states.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer.landmark_kernels import KnownSightings

Array = NDArray[np.float64]


def state_likelihoods(
    shape: tuple[int, int, int], layers: tuple[Array, float], seen: KnownSightings, exponent: float
) -> Array:
    """The likelihood (headings, rows, cols) of all sightings, to a power."""
    corners, width = layers
    likelihoods = np.empty(shape)
    for k, row, col in np.ndindex(shape):
        x, y, theta = corners[k] + width * np.array([col, row, 0.0])
        likelihoods[k, row, col] = math.exp(exponent * _log_likelihood(x, y, theta, seen))
    return likelihoods


def _log_likelihood(x: float, y: float, theta: float, seen: KnownSightings) -> float:
    total = 0.0
    for i, (distance, bearing, range_sigma, bearing_sigma) in enumerate(seen.values):
        best = 0.0
        for px, py in seen.positions[seen.offsets[i] : seen.offsets[i + 1]]:
            away = (math.hypot(px - x, py - y) - distance) / range_sigma
            turn = math.remainder(math.atan2(py - y, px - x) - theta - bearing, math.tau)
            best = max(best, math.exp(-0.5 * (away**2 + (turn / bearing_sigma) ** 2)))
        total += math.log((1.0 - seen.outlier) * best + seen.outlier)
    return total
