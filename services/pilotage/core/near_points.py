"""Which points of two sets lie near each other."""

import numpy as np
from numpy.typing import NDArray


def near_pairs(
    ones: NDArray[np.float64], others: NDArray[np.float64], most_apart: float
) -> NDArray[np.int64]:
    """Return the pairs (k, 2) of points (n, 2) and (m, 2) less than so far apart.

    The others are sorted into squares as wide as that, so that a building of thousands of walls
    needs no table of all pairs: near is only what lies in the nine squares around.
    """
    if len(ones) == 0 or len(others) == 0:
        return np.empty((0, 2), np.int64)
    corner = others.min(axis=0)
    columns, rows = np.floor((others - corner) / most_apart).astype(np.int64).T
    height = int(rows.max()) + 3
    squares = columns * height + rows
    order = np.argsort(squares, kind="stable")
    column, row = np.floor((ones - corner) / most_apart).clip(-2, 2.0**31).astype(np.int64).T
    # Clipped so that a square off the top or bottom is not taken for one of the next column.
    below, above = np.clip(row - 1, 0, height - 1), np.clip(row + 1, -1, height - 2)
    found = [
        _within(
            squares[order], (column + aside) * height + below, (column + aside) * height + above
        )
        for aside in (-1, 0, 1)
    ]
    first, place = np.concatenate(found, axis=1)
    second = order[place]
    apart = np.hypot(*(ones[first] - others[second]).T)
    near: NDArray[np.int64] = np.column_stack([first, second])[apart < most_apart]
    return near


def _within(
    squares: NDArray[np.int64], lowest: NDArray[np.int64], highest: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return, (2, k), which of n ranges of squares holds which places of sorted squares (m,)."""
    low = np.searchsorted(squares, lowest, side="left")
    counts = np.maximum(np.searchsorted(squares, highest, side="right") - low, 0)
    which = np.repeat(np.arange(len(lowest)), counts)
    steps = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.stack([which, np.repeat(low, counts) + steps])
