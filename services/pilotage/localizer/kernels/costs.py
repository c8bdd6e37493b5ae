"""Sums of the costs of a scan's beams, 64 states at a time.

The costs lie in one flat array and beams are offsets into it, unsigned, so that no index can be
negative and the compiler needs no wraparound. Lengths are rounded up to whole vectors: the last
states of a run are computed in vain rather than one by one, and the array ends with LANES bytes
to spare for it. Four costs of at most 63 add up within a byte, so only their sum is widened.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

LANES = 64
MOST_COST = 63


class Scan(NamedTuple):
    """A scan, ready to be looked up.

    `starts`: (headings, n) index in `costs` of each beam's end, seen from the state (0, 0).
    `costs`: flat rows of `width` bytes, LANES more at the end. `likelihood`: (63 n + 1,) by
    summed cost.
    """

    starts: NDArray[np.uint64]
    costs: NDArray[np.uint8]
    width: int
    likelihood: NDArray[np.float32]


@kernel
def padded(count: int) -> int:
    """Return the length of `count` states in whole vectors."""
    return (count + LANES - 1) // LANES * LANES


@kernel
def sum_costs(
    total: NDArray[np.uint16],
    starts: NDArray[np.uint64],
    costs: NDArray[np.uint8],
    at: int,
) -> None:
    """Set `total` (m,), m whole vectors, to the summed costs of the states from index `at` on."""
    total[:] = np.uint16(0)
    n = len(starts)
    base = np.uint64(at)
    for b in range(0, n - 7, 8):
        _add_eight(total, starts[b : b + 8], costs, base)
    if n % 8 >= 4:
        first = n - n % 8
        _add_four(total, starts[first : first + 4], costs, base)
    for b in range(n - n % 4, n):
        _add_one(total, starts[b], costs, base)


@kernel
def _add_eight(
    total: NDArray[np.uint16],
    starts: NDArray[np.uint64],
    costs: NDArray[np.uint8],
    base: np.uint64,
) -> None:
    a0, a1, a2, a3 = base + starts[0], base + starts[1], base + starts[2], base + starts[3]
    a4, a5, a6, a7 = base + starts[4], base + starts[5], base + starts[6], base + starts[7]
    for i in range(len(total)):
        j = np.uint64(i)
        one = np.uint8(costs[a0 + j] + costs[a1 + j] + costs[a2 + j] + costs[a3 + j])
        two = np.uint8(costs[a4 + j] + costs[a5 + j] + costs[a6 + j] + costs[a7 + j])
        total[i] += np.uint16(one) + np.uint16(two)


@kernel
def _add_four(
    total: NDArray[np.uint16],
    starts: NDArray[np.uint64],
    costs: NDArray[np.uint8],
    base: np.uint64,
) -> None:
    a0, a1, a2, a3 = base + starts[0], base + starts[1], base + starts[2], base + starts[3]
    for i in range(len(total)):
        j = np.uint64(i)
        four = np.uint8(costs[a0 + j] + costs[a1 + j] + costs[a2 + j] + costs[a3 + j])
        total[i] += np.uint16(four)


@kernel
def _add_one(
    total: NDArray[np.uint16], start: np.uint64, costs: NDArray[np.uint8], base: np.uint64
) -> None:
    for i in range(len(total)):
        total[i] += np.uint16(costs[base + start + np.uint64(i)])
