"""Passes that weigh tiles of states (see `kernels.resting`) by sightings of landmarks.

Plain twins in tests/naive/landmarks.py.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels import SIDE, Tiles, first_state
from pilotage.localizer.landmark_kernels import CUT, KnownSightings, log_likelihood

Layers = tuple[NDArray[np.float64], float]
"""Pose (headings, 3) of the centre of cell (0, 0) in each layer, and a cell's width."""

Said = tuple[Layers, KnownSightings, float]
"""Where the layers lie, what was seen, and to which power it counts."""

MIDDLE = (SIDE - 1) / 2.0
"""A tile's middle, in cells from the centre of its first one."""


@kernel
def bound_tiles(tiles: Tiles, said: Said) -> NDArray[np.float32]:
    """Return, of the shape of the masses, what no state of a tile can exceed in likelihood.

    All of a tile's states lie within a circle: a landmark's distance differs there by no more
    than its radius, and its direction by no more than the angle under which the circle is seen.
    """
    (corners, width), seen, exponent = said
    bounds = np.ones(tiles.mass.shape, np.float32)
    reach = np.sqrt(2.0) * MIDDLE * width
    headings, rows, cols = tiles.mass.shape
    for k in range(headings):
        up, right = tiles.phases[k]
        for row in range(rows):
            y = corners[k, 1] + (SIDE * (row - 1) + up + MIDDLE) * width
            for col in range(cols):
                if tiles.mass[k, row, col] > 0.0:
                    x = corners[k, 0] + (SIDE * (col - 1) + right + MIDDLE) * width
                    log_p = _most_log_likelihood((x, y, corners[k, 2]), reach, seen)
                    bounds[k, row, col] = np.exp(exponent * log_p)
    return bounds


@kernel
def best_fits(
    tiles: Tiles,
    chosen: NDArray[np.int64],
    mask: NDArray[np.float32],
    said: Said,
) -> NDArray[np.float32]:
    """Return the likelihood (n,) of the best state in each of the chosen tiles (n, 3)."""
    best = np.zeros(len(chosen), np.float32)
    for i in range(len(chosen)):
        k, row, col = first_state(tiles.phases, chosen[i])
        for r in range(max(0, row), min(row + SIDE, len(mask))):
            for c in range(max(0, col), min(col + SIDE, mask.shape[1])):
                if mask[r, c] > 0.0:
                    best[i] = max(best[i], _likelihood((k, r, c), said))
    return best


@kernel
def wake_tiles(
    belief: NDArray[np.float32],
    tiles: Tiles,
    chosen: NDArray[np.int64],
    mask: NDArray[np.float32],
    said: Said,
) -> None:
    """Give the chosen tiles' (n, 3) masses to their states, evenly, and weigh each of these."""
    for i in range(len(chosen)):
        k, row, col = first_state(tiles.phases, chosen[i])
        tile_row, tile_col = chosen[i, 1], chosen[i, 2]
        count = tiles.counts[tiles.phases[k, 0], tiles.phases[k, 1], tile_row, tile_col]
        share = tiles.mass[k, tile_row, tile_col] / max(count, np.float32(1.0))
        tiles.mass[k, tile_row, tile_col] = np.float32(0.0)
        for r in range(max(0, row), min(row + SIDE, len(mask))):
            for c in range(max(0, col), min(col + SIDE, mask.shape[1])):
                if mask[r, c] > 0.0:
                    belief[k, r, c] += share * _likelihood((k, r, c), said)


@kernel
def _likelihood(state: tuple[int, int, int], said: Said) -> np.float32:
    """Return the likelihood of sightings, to a power, from one state (layer, row, col)."""
    (corners, width), seen, exponent = said
    k, row, col = state
    x, y = corners[k, 0] + col * width, corners[k, 1] + row * width
    return np.float32(np.exp(exponent * log_likelihood(x, y, corners[k, 2], seen)))


@kernel
def _most_log_likelihood(
    middle: tuple[float, float, float], reach: float, sightings: KnownSightings
) -> float:
    """Return the most log p of all sightings from poses within `reach` of one, as it heads."""
    x, y, theta = middle
    total = 0.0
    for i in range(len(sightings.values)):
        squared = 2.0 * CUT**2
        for at in range(sightings.offsets[i], sightings.offsets[i + 1]):
            dx, dy = sightings.positions[at, 0] - x, sightings.positions[at, 1] - y
            squared = min(squared, _least_misfit(dx, dy, theta, reach, sightings.values[i]))
        fit = np.exp(-0.5 * squared) if squared < CUT**2 else 0.0
        total += np.log((1.0 - sightings.outlier) * fit + sightings.outlier)
    return total


@kernel
def _least_misfit(
    dx: float, dy: float, theta: float, reach: float, value: NDArray[np.float64]
) -> float:
    """Return the least misfit, in standard deviations squared, of a landmark near (dx, dy)."""
    seen, bearing, range_sigma, bearing_sigma = value
    distance = np.hypot(dx, dy)
    away = max(0.0, abs(distance - seen) - reach) / range_sigma
    if away > CUT or distance <= reach:
        return float(away**2)
    turn = np.arctan2(dy, dx) - theta - bearing
    turn = abs(turn - 2.0 * np.pi * np.rint(turn / (2.0 * np.pi)))
    beside = max(0.0, turn - np.arcsin(reach / distance)) / bearing_sigma
    return float(away**2 + beside**2)


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    seen = KnownSightings(np.ones((1, 4)), np.array([0, 1]), np.zeros((1, 2)), 0.05)
    layers = (np.zeros((1, 3)), 0.1)
    mask, chosen = np.ones((1, 1), np.float32), np.array([[0, 1, 1]])
    counts = np.ones((SIDE, SIDE, 2, 2), np.float32)
    tiles = Tiles(np.ones((1, 2, 2), np.float32), np.zeros((1, 2), np.int64), counts)
    said = (layers, seen, 1.0)
    bound_tiles(tiles, said)
    best_fits(tiles, chosen, mask, said)
    wake_tiles(np.ones((1, 1, 1), np.float32), tiles, chosen, mask, said)
