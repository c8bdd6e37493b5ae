"""Passes that move and spread the belief."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""


@kernel
def shift_layer(layer: NDArray[np.float32], up: int, right: int) -> None:
    """Move a layer (rows, cols) by whole cells in place; what enters is 0, what leaves is lost."""
    rows, cols = layer.shape
    for i in range(rows):
        row = rows - 1 - i if up > 0 else i
        source = row - up
        if source < 0 or source >= rows or abs(right) >= cols:
            layer[row, :] = 0.0
        elif right >= 0:
            for col in range(cols - 1, right - 1, -1):
                layer[row, col] = layer[source, col - right]
            layer[row, :right] = 0.0
        else:
            for col in range(cols + right):
                layer[row, col] = layer[source, col - right]
            layer[row, cols + right :] = 0.0


@kernel
def spread_layer(layer: NDArray[np.float32], share: float) -> None:
    """Give `share` of each cell to each of its neighbours above, below, left and right.

    Per axis this is a step of diffusion of variance 2 * share cells^2. At the grid's edge the
    share that would leave stays.
    """
    rows, cols = layer.shape
    keep, give = np.float32(1.0 - 2.0 * share), np.float32(share)
    before = layer[0].copy()
    current = layer[0].copy()
    for row in range(rows):
        after = layer[min(row + 1, rows - 1)]
        _blend(layer[row], before, after, keep, give)
        before[:] = current
        current[:] = after
    edge = np.empty(cols + 2, np.float32)
    for row in range(rows):
        edge[1:-1] = layer[row]
        edge[0], edge[-1] = edge[1], edge[-2]
        _blend(layer[row], edge[:-2], edge[2:], keep, give)


@kernel
def _blend(
    row: NDArray[np.float32],
    before: NDArray[np.float32],
    after: NDArray[np.float32],
    keep: np.float32,
    give: np.float32,
) -> None:
    for i in range(len(row)):
        row[i] = keep * row[i] + give * (before[i] + after[i])


@kernel
def spread_headings(belief: Belief, share: float, shifts: NDArray[np.int64]) -> None:
    """Give `share` of each layer to the next and to the last one, all the way round.

    `shifts` (headings, 2) says by how many rows and cols the layer k + 1 lies farther than k
    (layers move apart by parts of a cell, see markov_grid).
    """
    headings, rows, cols = belief.shape
    keep, give = np.float32(1.0 - 2.0 * share), np.float32(share)
    first = belief[0].copy()
    before = belief[headings - 1].copy()
    current = np.empty((rows, cols), np.float32)
    for k in range(headings):
        current[:] = belief[k]
        after = first if k == headings - 1 else belief[k + 1]
        last = shifts[k - 1]
        belief[k] *= keep
        _add_shifted(belief[k], before, give, -last)
        _add_shifted(belief[k], after, give, shifts[k])
        before, current = current, before


@kernel
def _add_shifted(
    layer: NDArray[np.float32],
    other: NDArray[np.float32],
    give: np.float32,
    shift: NDArray[np.int64],
) -> None:
    """Add `give` times `other`, whose cells lie `shift` (rows, cols) farther than the layer's."""
    rows, cols = layer.shape
    for row in range(max(0, shift[0]), min(rows, rows + shift[0])):
        source = other[row - shift[0]]
        first, last = max(0, shift[1]), min(cols, cols + shift[1])
        target = layer[row, first:last]
        _add_row(target, source[first - shift[1] : last - shift[1]], give)


@kernel
def _add_row(target: NDArray[np.float32], source: NDArray[np.float32], give: np.float32) -> None:
    for i in range(len(target)):
        target[i] += give * source[i]
