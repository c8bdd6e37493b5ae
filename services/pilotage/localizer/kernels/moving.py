"""Passes that move and spread the belief inside an area.

The area is wide enough to hold all that moves in it: outside it there is nothing.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels.areas import Area

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""

Layer = NDArray[np.float32]
Row = NDArray[np.float32]
Places = NDArray[np.int64]
"""(n, 3) row, first and last + 1 column of runs in one layer."""


@kernel
def shift_layers(belief: Belief, area: Area, cells: NDArray[np.int64]) -> None:
    """Move each layer by `cells` (headings, 2) rows and columns; what leaves the grid is lost."""
    for k in range(len(belief)):
        if cells[k, 0] != 0 or cells[k, 1] != 0:
            places = area.runs[area.starts[k] : area.starts[k + 1]]
            _shift_layer(belief[k], places, cells[k, 0], cells[k, 1])


@kernel
def _shift_layer(layer: Layer, places: Places, up: int, right: int) -> None:
    """Move a layer in place, those runs first that others are read from."""
    rows, cols = layer.shape
    backwards = up > 0 or (up == 0 and right > 0)
    for i in range(len(places)):
        row, first, last = places[len(places) - 1 - i if backwards else i]
        source = row - up
        start, end = max(first, right), min(last, cols + right)
        if source < 0 or source >= rows or start >= end:
            layer[row, first:last] = np.float32(0.0)
        else:
            _copy_row(layer[row, start:end], layer[source, start - right : end - right], right)
            layer[row, first:start] = np.float32(0.0)
            layer[row, end:last] = np.float32(0.0)


@kernel
def _copy_row(target: Row, source: Row, right: int) -> None:
    """Copy a row that may lie in the same memory, `right` places on."""
    if right > 0:
        for i in range(len(target) - 1, -1, -1):
            target[i] = source[i]
    else:
        for i in range(len(target)):
            target[i] = source[i]


@kernel
def spread_layers(belief: Belief, area: Area, share: float) -> None:
    """Give `share` of each cell to each of its neighbours above, below, left and right.

    Per axis this is a step of diffusion of variance 2 * share cells^2. At the grid's edge the
    share that would leave stays.
    """
    rows, cols = belief.shape[1:]
    shares = np.float32(1.0 - 2.0 * share), np.float32(share)
    along = np.zeros((rows, cols), np.float32)
    for k in range(len(belief)):
        layer, places = belief[k], area.runs[area.starts[k] : area.starts[k + 1]]
        for row, first, last in places:
            _blend_along(along[row], layer[row], first, last, shares)
        for row, first, last in places:
            before, after = along[max(row - 1, 0)], along[min(row + 1, rows - 1)]
            here = along[row, first:last]
            _blend(layer[row, first:last], before[first:last], here, after[first:last], shares)
        for row, first, last in places:
            along[row, first:last] = np.float32(0.0)


@kernel
def _blend_along(
    target: Row, row: Row, first: int, last: int, shares: tuple[np.float32, np.float32]
) -> None:
    """Set a run of `target` to that of the row, spread along it."""
    keep, give = shares
    cols = len(row)
    start, end = max(first, 1), min(last, cols - 1)
    if start < end:
        before, after = row[start - 1 : end - 1], row[start + 1 : end + 1]
        _blend(target[start:end], before, row[start:end], after, shares)
    if first == 0:
        target[0] = (keep + give) * row[0] + give * row[min(1, cols - 1)]
    if last == cols and cols > 1:
        target[cols - 1] = (keep + give) * row[cols - 1] + give * row[cols - 2]


@kernel
def _blend(
    target: Row, before: Row, here: Row, after: Row, shares: tuple[np.float32, np.float32]
) -> None:
    keep, give = shares
    for i in range(len(target)):
        target[i] = keep * here[i] + give * (before[i] + after[i])


@kernel
def spread_headings(belief: Belief, area: Area, share: float, shifts: NDArray[np.int64]) -> None:
    """Give `share` of each layer to the next and to the last one, all the way round.

    `shifts` (headings, 2) says by how many rows and cols the layer k + 1 lies farther than k
    (layers move apart by parts of a cell, see layers).
    """
    headings, rows, cols = belief.shape
    shares = np.float32(1.0 - 2.0 * share), np.float32(share)
    # Copies of layers, empty but for their areas.
    first, before = np.zeros((rows, cols), np.float32), np.zeros((rows, cols), np.float32)
    current = np.zeros((rows, cols), np.float32)
    _copy_layer(first, belief[0], area.runs[area.starts[0] : area.starts[1]])
    _copy_layer(before, belief[-1], area.runs[area.starts[headings - 1] :])
    for k in range(headings):
        places = area.runs[area.starts[k] : area.starts[k + 1]]
        after = first if k == headings - 1 else belief[k + 1]
        for row, start, end in places:
            target = belief[k, row, start:end]
            current[row, start:end] = target
            _scale_row(target, shares[0])
            _add_shifted(target, (row, start), before, shifts[k - 1], shares[1])
            _add_shifted(target, (row, start), after, -shifts[k], shares[1])
        last = (k - 1) % headings
        _clear_layer(before, area.runs[area.starts[last] : area.starts[last + 1]])
        before, current = current, before


@kernel
def _copy_layer(target: Layer, source: Layer, places: Places) -> None:
    for row, first, last in places:
        target[row, first:last] = source[row, first:last]


@kernel
def _clear_layer(layer: Layer, places: Places) -> None:
    for row, first, last in places:
        layer[row, first:last] = np.float32(0.0)


@kernel
def _add_shifted(
    target: Row, at: tuple[int, int], other: Layer, off: NDArray[np.int64], give: np.float32
) -> None:
    """Add `give` times what another layer holds `off` (2,) beyond a run that begins `at` a cell."""
    rows, cols = other.shape
    row, column = at[0] + off[0], at[1] + off[1]
    first, last = max(0, -column), min(len(target), cols - column)
    if 0 <= row < rows and first < last:
        _add_row(target[first:last], other[row, column + first : column + last], give)


@kernel
def _scale_row(target: Row, keep: np.float32) -> None:
    for i in range(len(target)):
        target[i] *= keep


@kernel
def _add_row(target: Row, source: Row, give: np.float32) -> None:
    for i in range(len(target)):
        target[i] += give * source[i]
