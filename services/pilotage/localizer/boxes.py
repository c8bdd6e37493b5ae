"""Boxes (n, 4) of the grid: row, end row, column and end column of what is worked on."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels import Admissible

Boxes = NDArray[np.int64]

WIDEST = 64
"""Columns of a run in a box: as many as can be passed over at once where nothing is."""


def whole(shape: tuple[int, ...]) -> Boxes:
    """Return the one box that holds a grid of `shape` (..., rows, cols)."""
    return np.array([[0, shape[-2], 0, shape[-1]]], np.int64)


def area(boxes: Boxes) -> int:
    """Return how many cells boxes that do not overlap hold."""
    return int(((boxes[:, 1] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 2])).sum())


def grown(boxes: Boxes, by: int, shape: tuple[int, ...]) -> Boxes:
    """Return the boxes wider by `by` cells on all sides, within the grid; what overlaps is one."""
    wider = boxes + np.array([-by, by, -by, by])
    return merged(np.clip(wider, 0, np.repeat(shape[-2:], 2)))


@kernel
def merged(boxes: Boxes) -> Boxes:
    """Return boxes that hold the same and do not overlap."""
    apart = np.empty_like(boxes)
    count = 0
    for box in boxes:
        united = box.copy()
        if united[0] >= united[1] or united[2] >= united[3]:
            continue
        i = 0
        while i < count:
            if _overlap(united, apart[i]):
                _unite(united, apart[i])
                count -= 1
                apart[i] = apart[count]
                i = 0
            else:
                i += 1
        apart[count] = united
        count += 1
    return apart[:count].copy()


@kernel
def _overlap(one: NDArray[np.int64], other: NDArray[np.int64]) -> bool:
    """Say whether two boxes share a cell."""
    rows = one[0] < other[1] and other[0] < one[1]
    return bool(rows and one[2] < other[3] and other[2] < one[3])


@kernel
def _unite(box: NDArray[np.int64], other: NDArray[np.int64]) -> None:
    """Widen a box so that it holds another one too."""
    box[0], box[1] = min(box[0], other[0]), max(box[1], other[1])
    box[2], box[3] = min(box[2], other[2]), max(box[3], other[3])


def restricted(admissible: Admissible, boxes: Boxes) -> Admissible:
    """Return what is admissible in the boxes: each row of a box in runs of at most WIDEST."""
    if np.array_equal(boxes, whole(admissible.mask.shape)):
        return admissible
    runs = [
        np.column_stack(np.broadcast_arrays(np.arange(low, high), first, min(first + WIDEST, end)))
        for low, high, left, end in boxes
        for first in range(left, end, WIDEST)
    ]
    return Admissible(admissible.mask, np.concatenate([np.empty((0, 3), np.int64), *runs]))
