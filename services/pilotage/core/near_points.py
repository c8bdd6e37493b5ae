"""Which points of two sets lie near each other."""

import numpy as np
from numpy.typing import NDArray


def near_pairs(
    ones: NDArray[np.float64], others: NDArray[np.float64], most_apart: float
) -> NDArray[np.int64]:
    """Return the pairs (k, 2) of points (n, 2) and (m, 2) less than so far apart.

    Sorted along x, so that a building of thousands of walls needs no table of all pairs.
    """
    order = np.argsort(others[:, 0], kind="stable")
    sorted_x = others[order, 0]
    low = np.searchsorted(sorted_x, ones[:, 0] - most_apart)
    high = np.searchsorted(sorted_x, ones[:, 0] + most_apart)
    counts = high - low
    first = np.repeat(np.arange(len(ones)), counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    second = order[np.repeat(low, counts) + within]
    apart = np.hypot(*(ones[first] - others[second]).T)
    near: NDArray[np.int64] = np.column_stack([first, second])[apart < most_apart]
    return near
