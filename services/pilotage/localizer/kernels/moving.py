"""Passes that move and spread the belief inside a box: row, end row, column, end column.

A box is wide enough to hold all that moves in it: outside it, within the map, there is nothing.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""

Row = NDArray[np.float32]


@kernel
def shift_layers(belief: Belief, box: NDArray[np.int64], whole: NDArray[np.int64]) -> None:
    """Move each layer by `whole` (headings, 2) rows and columns; what leaves the box is lost."""
    for k in range(len(belief)):
        if whole[k, 0] != 0 or whole[k, 1] != 0:
            _shift_layer(belief[k], box, whole[k, 0], whole[k, 1])


@kernel
def _shift_layer(layer: NDArray[np.float32], box: NDArray[np.int64], up: int, right: int) -> None:
    """Move a layer in place, rows that are read going before those that are written."""
    low, high, left, end = box
    for i in range(high - low):
        row = high - 1 - i if up > 0 else low + i
        source = row - up
        if source < low or source >= high or abs(right) >= end - left:
            layer[row, left:end] = np.float32(0.0)
        else:
            _shift_row(layer[row, left:end], layer[source, left:end], right)


@kernel
def _shift_row(target: Row, source: Row, right: int) -> None:
    """Copy a row `right` columns farther; source and target may be the same."""
    cols = len(target)
    if right >= 0:
        for i in range(cols - 1, right - 1, -1):
            target[i] = source[i - right]
        target[:right] = np.float32(0.0)
    else:
        for i in range(cols + right):
            target[i] = source[i - right]
        target[cols + right :] = np.float32(0.0)


@kernel
def spread_layers(belief: Belief, box: NDArray[np.int64], share: float) -> None:
    """Give `share` of each cell to each of its neighbours above, below, left and right.

    Per axis this is a step of diffusion of variance 2 * share cells^2. At the box's edge the
    share that would leave stays.
    """
    low, high, left, end = box
    shares = np.float32(1.0 - 2.0 * share), np.float32(share)
    rows = np.empty((3, end - left), np.float32)
    for k in range(len(belief)):
        _blend_along(rows[0], belief[k, low, left:end], shares)
        rows[2] = rows[0]
        for row in range(low, high):
            i = row - low
            before, here, after = rows[(i + 2) % 3], rows[i % 3], rows[(i + 1) % 3]
            if row + 1 < high:
                _blend_along(after, belief[k, row + 1, left:end], shares)
            else:
                after[:] = here
            _blend(belief[k, row, left:end], before, here, after, shares)


@kernel
def _blend_along(target: Row, row: Row, shares: tuple[np.float32, np.float32]) -> None:
    """Set `target` to the row, spread along itself."""
    keep, give = shares
    last = len(row) - 1
    if last == 0:
        target[0] = row[0]
        return
    _blend(target[1:last], row[: last - 1], row[1:last], row[2:], shares)
    target[0] = (keep + give) * row[0] + give * row[1]
    target[last] = (keep + give) * row[last] + give * row[last - 1]


@kernel
def _blend(
    target: Row, before: Row, here: Row, after: Row, shares: tuple[np.float32, np.float32]
) -> None:
    keep, give = shares
    for i in range(len(target)):
        target[i] = keep * here[i] + give * (before[i] + after[i])


@kernel
def spread_headings(
    belief: Belief, box: NDArray[np.int64], share: float, shifts: NDArray[np.int64]
) -> None:
    """Give `share` of each layer to the next and to the last one, all the way round.

    `shifts` (headings, 2) says by how many rows and cols the layer k + 1 lies farther than k
    (layers move apart by parts of a cell, see markov_grid).
    """
    headings = len(belief)
    low, high, left, end = box
    keep, give = np.float32(1.0 - 2.0 * share), np.float32(share)
    first = belief[0, low:high, left:end].copy()
    before = belief[headings - 1, low:high, left:end].copy()
    current = np.empty((high - low, end - left), np.float32)
    for k in range(headings):
        ahead, behind = shifts[k], shifts[k - 1]
        for row in range(high - low):
            target = belief[k, low + row, left:end]
            current[row] = target
            _scale_row(target, keep)
            last, following = row + behind[0], row - ahead[0]
            if 0 <= last < high - low:
                _add_shifted(target, before[last], behind[1], give)
            if 0 <= following < high - low:
                after = first[following]
                if k + 1 < headings:
                    after = belief[k + 1, low + following, left:end]
                _add_shifted(target, after, -ahead[1], give)
        before, current = current, before


@kernel
def _add_shifted(target: Row, other: Row, right: int, give: np.float32) -> None:
    """Add `give` times another row, read from `right` columns on."""
    cols = len(target)
    first, last = max(0, -right), min(cols, cols - right)
    if first < last:
        _add_row(target[first:last], other[first + right : last + right], give)


@kernel
def _scale_row(target: Row, keep: np.float32) -> None:
    for i in range(len(target)):
        target[i] *= keep


@kernel
def _add_row(target: Row, source: Row, give: np.float32) -> None:
    for i in range(len(target)):
        target[i] += give * source[i]
