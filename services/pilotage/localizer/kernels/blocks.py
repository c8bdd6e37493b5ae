"""From the blocks that are worked on to runs, as the passes over the belief want them."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels.resting import SIDE


@kernel
def runs_of_blocks(
    is_active: NDArray[np.bool_], rows: int, cols: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return runs and starts, as in Area, of the active blocks (headings, rows, cols)."""
    headings, block_rows, block_cols = is_active.shape
    stretches = np.empty((headings * block_rows * (block_cols // 2 + 1), 2), np.int64)
    runs = np.empty((SIDE * len(stretches), 3), np.int64)
    starts = np.zeros(headings + 1, np.int64)
    count = 0
    for k in range(headings):
        for block_row in range(block_rows):
            found = _find_stretches(is_active[k, block_row], stretches)
            for row in range(SIDE * block_row, min(SIDE * (block_row + 1), rows)):
                for i in range(found):
                    runs[count, 0] = row
                    runs[count, 1] = SIDE * stretches[i, 0]
                    runs[count, 2] = min(SIDE * stretches[i, 1], cols)
                    count += 1
        starts[k + 1] = count
    return runs[:count].copy(), starts


@kernel
def _find_stretches(is_active: NDArray[np.bool_], stretches: NDArray[np.int64]) -> int:
    """Set the first rows of `stretches` to first and end of what is active; return how many."""
    count, was_active = 0, False
    for i in range(len(is_active)):
        if is_active[i] and not was_active:
            stretches[count, 0] = i
            count += 1
        if is_active[i]:
            stretches[count - 1, 1] = i + 1
        was_active = is_active[i]
    return count
