"""Passes over particles: poses (n, 3) of the map frame. Plain twins in tests/naive/particles.py.

Random numbers come in drawn, so that a kernel is a function of its arguments.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

Poses = NDArray[np.float64]

FRACTIONS = 65536
"""Parts of a turn in which directions are counted where they only choose a layer of a table."""


class Cells(NamedTuple):
    """A table of bytes over padded cells, in the map's own directions.

    `table`: (rows * cols,) row by row; `cols`: its row length; `margin`: cells of padding on
    every side; `x`, `y`, `theta`: the grid's origin in the map frame; `resolution` [m].
    """

    table: NDArray[np.uint8]
    cols: int
    margin: int
    x: float
    y: float
    theta: float
    resolution: float


@kernel
def weigh_ends(
    poses: Poses,
    ends: NDArray[np.float32],
    costs: Cells,
    is_free: NDArray[np.bool_],
    total: NDArray[np.int64],
) -> None:
    """Sum up what the cells at the ends of the beams cost each particle.

    Args:
        poses: (n, 3).
        ends: (2, beams) in base_link, in cells, none longer than the margin.
        costs: the table; `total` counts its steps.
        is_free: (rows, cols) without the margin; elsewhere every beam costs the most, 255.
        total: (n,) filled.
    """
    at = np.empty(ends.shape[1], np.int32)
    cos_grid, sin_grid = np.cos(costs.theta), np.sin(costs.theta)
    rows, cols = is_free.shape
    for i in range(len(poses)):
        dx, dy = poses[i, 0] - costs.x, poses[i, 1] - costs.y
        x = (cos_grid * dx + sin_grid * dy) / costs.resolution
        y = (cos_grid * dy - sin_grid * dx) / costs.resolution
        inside = 0.0 <= x < cols and 0.0 <= y < rows
        if not inside or not is_free[int(y), int(x)]:
            total[i] = 255 * ends.shape[1]
            continue
        turn = poses[i, 2] - costs.theta
        _cells_of_ends(
            at,
            ends,
            (np.float32(x + costs.margin), np.float32(y + costs.margin)),
            (np.float32(np.cos(turn)), np.float32(np.sin(turn))),
            np.int32(costs.cols),
        )
        total[i] = _sum_at(costs.table, at)


@kernel
def _cells_of_ends(
    at: NDArray[np.int32],
    ends: NDArray[np.float32],
    start: tuple[np.float32, np.float32],
    direction: tuple[np.float32, np.float32],
    cols: np.int32,
) -> None:
    """Fill in the place in the table of each end; a loop of its own, which LLVM vectorises."""
    x, y = start
    cos, sin = direction
    for b in range(len(at)):
        # Nothing is negative within the margin, so that cutting off is rounding down.
        row = np.int32(y + sin * ends[0, b] + cos * ends[1, b])
        col = np.int32(x + cos * ends[0, b] - sin * ends[1, b])
        at[b] = row * cols + col


@kernel
def _sum_at(table: NDArray[np.uint8], at: NDArray[np.int32]) -> np.int64:
    """Return the sum of the table's values at some places."""
    total = np.int64(0)
    for place in at:
        # Unsigned: no look from the end of the table, hence no test for it.
        total += np.int64(table[np.uint32(place)])
    return total


@kernel
def sum_levels(
    poses: Poses,
    bearings: NDArray[np.float64],
    costs: NDArray[np.float32],
    expected: tuple[NDArray[np.uint8], Cells],
    total: NDArray[np.float64],
) -> None:
    """Sum up what the expected ranges of its beams cost each particle.

    Args:
        poses: (n, 3).
        bearings: (beams,) in base_link.
        costs: (beams, 256) by level of the expected range.
        expected: levels (rows, cols, headings) along the map's directions, and the cells they
            lie on (their `table` and `margin` are not used). Headings come last: all beams of a
            particle then meet one or two cache lines (4 times as fast over a building).
        total: (n,) filled; particles beyond the cells cost nothing.
    """
    levels, cells = expected
    rows, cols, _ = levels.shape
    cos_grid, sin_grid = np.cos(cells.theta), np.sin(cells.theta)
    turned = _fractions(bearings)
    for i in range(len(poses)):
        dx, dy = poses[i, 0] - cells.x, poses[i, 1] - cells.y
        col = int(np.floor((cos_grid * dx + sin_grid * dy) / cells.resolution))
        row = int(np.floor((cos_grid * dy - sin_grid * dx) / cells.resolution))
        total[i] = 0.0
        if 0 <= row < rows and 0 <= col < cols:
            heading = np.int64(np.rint(poses[i, 2] * (FRACTIONS / (2.0 * np.pi))))
            total[i] = _sum_of_levels(levels[row, col], costs, turned, heading)


@kernel
def _fractions(angles: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return angles (n,) as whole FRACTIONS of a turn: they wrap by cutting bits off."""
    fractions = np.empty(len(angles), np.int64)
    for i in range(len(angles)):
        fractions[i] = np.int64(np.rint(angles[i] * (FRACTIONS / (2.0 * np.pi))))
    return fractions


@kernel
def _sum_of_levels(
    levels: NDArray[np.uint8],
    costs: NDArray[np.float32],
    turned: NDArray[np.int64],
    heading: np.int64,
) -> float:
    """Return what a cell's expected ranges (headings,) cost all beams, turned by a heading."""
    headings, total = len(levels), 0.0
    for b in range(len(turned)):
        turn = (heading + turned[b]) & (FRACTIONS - 1)
        layer = (turn * headings + FRACTIONS // 2) // FRACTIONS
        if layer == headings:
            layer = 0
        total += costs[b, levels[np.uint32(layer)]]
    return total


@kernel
def move(poses: Poses, increments: Poses) -> None:
    """Compose each particle (n, 3) with its own increment (n, 3), in place, headings wrapped."""
    for i in range(len(poses)):
        cos, sin = np.cos(poses[i, 2]), np.sin(poses[i, 2])
        poses[i, 0] += cos * increments[i, 0] - sin * increments[i, 1]
        poses[i, 1] += sin * increments[i, 0] + cos * increments[i, 1]
        turned = poses[i, 2] + increments[i, 2] + np.pi
        poses[i, 2] = turned - 2.0 * np.pi * np.floor(turned / (2.0 * np.pi)) - np.pi


@kernel
def draw_systematic(weights: NDArray[np.float64], offset: float, drawn: NDArray[np.int64]) -> None:
    """Draw particles at even steps of the summed weights (low variance, Thrun et al., 4.4).

    Args:
        weights: (n,) not negative, of any sum above zero.
        offset: uniform in [0, 1): where in the first step the comb begins.
        drawn: (m,) filled with indices, ascending.
    """
    total = 0.0
    for weight in weights:
        total += weight
    step = total / len(drawn)
    i, summed = 0, weights[0]
    for k in range(len(drawn)):
        position = (k + offset) * step
        # The last condition: rounding must not lead beyond the end, nor onto a weight of zero.
        while summed <= position and i + 1 < len(weights):
            i += 1
            summed += weights[i]
        drawn[k] = i
    for k in range(len(drawn) - 1, -1, -1):
        while weights[drawn[k]] == 0.0 and drawn[k] > 0:
            drawn[k] -= 1


@kernel
def count_needed(
    bins: NDArray[np.int64], stride: int, first: int, limits: tuple[int, int, float, float]
) -> int:
    """Return how many particles describe a belief well enough (Fox 2003, KLD sampling).

    Goes through a sample in an order that spreads evenly over it from the beginning on, and
    stops when what has been met suffices for the number of bins met.

    Args:
        bins: (n,) bin of each drawn particle.
        stride: step of the order, without a common divisor with n.
        first: where the order begins.
        limits: least and most particles, epsilon and the normal quantile z.
    """
    least, most, epsilon, quantile = limits
    slots = 1
    while slots < 2 * len(bins):
        slots *= 2
    seen = np.full(slots, -1, np.int64)
    occupied, at = 0, first
    needed = float(least)
    for count in range(1, len(bins) + 1):
        occupied += _add_to_set(seen, bins[at])
        if occupied > 1:
            # Wilson and Hilferty's approximation of the chi-square quantile.
            part = 2.0 / (9.0 * (occupied - 1))
            root = 1.0 - part + np.sqrt(part) * quantile
            needed = max(float(least), (occupied - 1) / (2.0 * epsilon) * root**3)
        if count >= needed:
            return min(most, max(least, count))
        at = (at + stride) % len(bins)
    return int(min(most, max(least, np.ceil(needed))))


@kernel
def _add_to_set(seen: NDArray[np.int64], value: int) -> int:
    """Add a value (not negative) to an open hash table; 1 if it was not in it, else 0."""
    slots = len(seen)
    # Fibonacci hashing: bins next to each other must not fall next to each other.
    slot = (((value & 0x7FFFFFFF) * 2654435761) >> 16) & (slots - 1)
    while seen[slot] != -1:
        if seen[slot] == value:
            return 0
        slot = (slot + 1) & (slots - 1)
    seen[slot] = value
    return 1


def warm_up() -> None:
    """Compile every kernel for the types it meets in service."""
    poses, table = np.zeros((1, 3)), np.zeros(9, np.uint8)
    cells = Cells(table, 3, 1, 0.0, 0.0, 0.0, 1.0)
    counts = np.zeros(1, np.int64)
    weigh_ends(poses, np.zeros((2, 1), np.float32), cells, np.ones((1, 1), bool), counts)
    levels = np.zeros((1, 1, 1), np.uint8)
    costs, sums = np.zeros((1, 256), np.float32), np.zeros(1)
    sum_levels(poses, np.zeros(1), costs, (levels, cells), sums)
    move(poses, poses.copy())
    draw_systematic(np.ones(1), 0.0, counts)
    count_needed(counts, 1, 0, (1, 1, 0.05, 1.0))
