"""The pass that weighs the belief by beams that must not go through walls (see visibility)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels.areas import Area, Runs
from pilotage.localizer.kernels.summing import sum_and_peak

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""

PIECE = 128
"""Columns that are looked at or passed over together."""


class Sight(NamedTuple):
    """Beams that must not go through walls.

    `directions`: (headings, n) layer of `levels` that each points along; `levels`: (table
    headings, rows, cols) optimistic expected ranges; `allowed`: (n,) level that the expected
    range must have at least; `likelihood`: (n + 1,) by number of beams that go through a wall;
    `least`: states below do not matter.
    """

    directions: NDArray[np.int64]
    levels: NDArray[np.uint8]
    allowed: NDArray[np.uint8]
    likelihood: NDArray[np.float32]
    least: np.float32


@kernel
def weigh_visibility(belief: Belief, area: Area, runs: Runs, sight: Sight) -> None:
    """Multiply the belief by the likelihood of the number of beams that go through a wall.

    PIECEs of runs that hold no state above `sight.least` are left alone: what they could lose
    at the most is `least` a state. `runs`, as of before, is brought up to date.
    """
    through = np.empty(PIECE, np.uint8)
    following = area.starts[:-1].copy()
    # Row by row, whatever the heading: all directions of a row of the table fit the cache.
    for row in range(belief.shape[1]):
        for k in range(len(belief)):
            i = following[k]
            while i < area.starts[k + 1] and area.runs[i, 0] == row:
                if runs.peak[i] > sight.least:
                    runs.mass[i], runs.peak[i] = _weigh_sight(
                        belief[k, row], area.runs[i], k, sight, through
                    )
                i += 1
            following[k] = i


@kernel
def _weigh_sight(
    line: NDArray[np.float32],
    run: NDArray[np.int64],
    k: int,
    sight: Sight,
    through: NDArray[np.uint8],
) -> tuple[float, np.float32]:
    """Weigh the PIECEs of a run of a row; return its new sum and maximum."""
    mass, peak = 0.0, np.float32(0.0)
    row, first, last = run
    for start in range(first, last, PIECE):
        piece = line[start : min(start + PIECE, last)]
        part, highest = sum_and_peak(piece)
        if highest > sight.least:
            count = through[: len(piece)]
            _count_through(count, sight, k, row, start)
            _apply_count(piece, count, sight.likelihood)
            part, highest = sum_and_peak(piece)
        mass, peak = mass + part, max(peak, highest)
    return mass, peak


@kernel
def _apply_count(
    run: NDArray[np.float32], count: NDArray[np.uint8], likelihood: NDArray[np.float32]
) -> None:
    for i in range(len(run)):
        run[i] *= likelihood[count[i]]


@kernel
def _count_through(count: NDArray[np.uint8], sight: Sight, k: int, row: int, first: int) -> None:
    """Set `count` (m,) to the number of beams through walls from the states (row, first) on."""
    count[:] = np.uint8(0)
    layers, rows, cols = sight.levels.shape
    levels = sight.levels.reshape(layers * rows * cols)
    n, at = len(sight.allowed), row * cols + first
    for b in range(0, n - 3, 4):
        ahead, allowed = sight.directions[k, b : b + 4], sight.allowed[b : b + 4]
        _count_four(count, levels, rows * cols, at, (ahead, allowed))
    for b in range(n - n % 4, n):
        start = sight.directions[k, b] * rows * cols + at
        _count_below(count, levels[start : start + len(count)], sight.allowed[b])


@kernel
def _count_four(
    count: NDArray[np.uint8],
    levels: NDArray[np.uint8],
    layer: int,
    at: int,
    beams: tuple[NDArray[np.int64], NDArray[np.uint8]],
) -> None:
    """Count four beams in layers of so many `levels`, from the state `at` on."""
    ahead, allowed = beams
    a0, a1 = np.uint64(ahead[0] * layer + at), np.uint64(ahead[1] * layer + at)
    a2, a3 = np.uint64(ahead[2] * layer + at), np.uint64(ahead[3] * layer + at)
    of_one, of_two, of_three, of_four = allowed[0], allowed[1], allowed[2], allowed[3]
    for i in range(len(count)):
        j = np.uint64(i)
        first = np.uint8(levels[a0 + j] < of_one) + np.uint8(levels[a1 + j] < of_two)
        second = np.uint8(levels[a2 + j] < of_three) + np.uint8(levels[a3 + j] < of_four)
        count[i] += np.uint8(first + second)


@kernel
def _count_below(count: NDArray[np.uint8], seen: NDArray[np.uint8], allowed: np.uint8) -> None:
    for i in range(len(count)):
        count[i] += np.uint8(seen[i] < allowed)
