"""Passes that weigh particles and the Markov grid by sightings of landmarks.

Plain twins in tests/naive/particles.py.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels import Area, whole_area

CUT = 5.0
"""Standard deviations beyond which a landmark does not fit; e^-12.5 is far below any outlier."""


class KnownSightings(NamedTuple):
    """Sightings and where the landmarks they may belong to stand.

    `values` (n, 4): range, bearing and their standard deviations; `offsets` (n + 1,): the
    candidates of sighting i are `positions[offsets[i]:offsets[i + 1]]` (k, 2); `outlier`:
    likelihood at the least.
    """

    values: NDArray[np.float64]
    offsets: NDArray[np.int64]
    positions: NDArray[np.float64]
    outlier: float


@kernel
def add_sightings(
    poses: NDArray[np.float64], sightings: KnownSightings, total: NDArray[np.float64]
) -> None:
    """Add the log likelihood of all sightings to `total` (n,) of poses (n, 3)."""
    for i in range(len(poses)):
        total[i] += log_likelihood(poses[i, 0], poses[i, 1], poses[i, 2], sightings)


@kernel
def weigh_landmarks(
    belief: NDArray[np.float32],
    area: Area,
    layers: tuple[NDArray[np.float64], float],
    sightings: KnownSightings,
    exponent: float,
) -> None:
    """Multiply the belief by the likelihood of all sightings to the power `exponent`.

    Args:
        belief: (headings, rows, cols), changed in place.
        area: where to look.
        layers: pose (headings, 3) of the centre of cell (0, 0) in each layer, and the width of a
            cell, both in the grid's frame, as the positions of the landmarks.
        sightings: what was seen.
        exponent: how much the sightings count.
    """
    corners, width = layers
    for k in range(len(belief)):
        for row, first, last in area.runs[area.starts[k] : area.starts[k + 1]]:
            y = corners[k, 1] + row * width
            for col in range(first, last):
                if belief[k, row, col] > 0.0:
                    x = corners[k, 0] + col * width
                    log_p = log_likelihood(x, y, corners[k, 2], sightings)
                    belief[k, row, col] *= np.float32(np.exp(exponent * log_p))


@kernel
def log_likelihood(x: float, y: float, theta: float, sightings: KnownSightings) -> float:
    """Return log p of all sightings from one pose."""
    total = 0.0
    for i in range(len(sightings.values)):
        squared = 2.0 * CUT**2
        for at in range(sightings.offsets[i], sightings.offsets[i + 1]):
            dx, dy = sightings.positions[at, 0] - x, sightings.positions[at, 1] - y
            squared = min(squared, _squared_misfit(dx, dy, theta, sightings.values[i]))
        fit = np.exp(-0.5 * squared) if squared < CUT**2 else 0.0
        total += np.log((1.0 - sightings.outlier) * fit + sightings.outlier)
    return total


@kernel
def _squared_misfit(dx: float, dy: float, theta: float, value: NDArray[np.float64]) -> float:
    """Return how many standard deviations, squared, a landmark at (dx, dy) is off a sighting."""
    seen, bearing, range_sigma, bearing_sigma = value
    # Most landmarks stand off the ring of the range: no root and no angle for them.
    squared = dx * dx + dy * dy
    inner, outer = seen - CUT * range_sigma, seen + CUT * range_sigma
    if squared > outer * outer or (inner > 0.0 and squared < inner * inner):
        return 2.0 * CUT**2
    turn = np.arctan2(dy, dx) - theta - bearing
    turn -= 2.0 * np.pi * np.rint(turn / (2.0 * np.pi))
    away = (np.sqrt(squared) - seen) / range_sigma
    return float(away**2 + (turn / bearing_sigma) ** 2)


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    sightings = KnownSightings(np.ones((1, 4)), np.array([0, 1]), np.zeros((1, 2)), 0.05)
    poses = np.zeros((1, 3))
    add_sightings(poses, sightings, np.zeros(1))
    belief = np.ones((1, 1, 1), np.float32)
    weigh_landmarks(belief, whole_area(belief.shape), (poses, 0.1), sightings, 1.0)
