"""Kernels of the correlative search: layers of best values, and branch and bound over them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel


@kernel
def pooled(layer: NDArray[np.uint8], step: int) -> NDArray[np.uint8]:
    """Return the largest of the values at a cell and `step` cells on, each way (rows, cols)."""
    rows, cols = layer.shape
    best = np.empty_like(layer)
    for r in range(rows):
        down = min(r + step, rows - 1)
        for c in range(cols):
            right = min(c + step, cols - 1)
            one = max(layer[r, c], layer[r, right])
            two = max(layer[down, c], layer[down, right])
            best[r, c] = max(one, two)
    return best


@kernel
def _sum_at(layer: NDArray[np.uint8], cells: NDArray[np.int32], row: int, col: int) -> int:
    total = 0
    rows, cols = layer.shape
    for i in range(len(cells)):
        r, c = cells[i, 0] + row, cells[i, 1] + col
        if 0 <= r < rows and 0 <= c < cols:
            total += int(layer[r, c])
    return total


class Task(NamedTuple):
    """What is searched: see `branch_and_bound`."""

    layers: NDArray[np.uint8]
    cells: NDArray[np.int32]
    half: int
    per_turn: NDArray[np.float64]
    per_square: float


@kernel
def branch_and_bound(task: Task, least: float) -> tuple[int, int, int, float]:
    """Return turn, row and col offsets and score of the best match; turn -1 if none beats `least`.

    `task.layers` (depth, rows, cols): layer d holds the best value of 2**d x 2**d cells;
    `task.cells` (turns, n, 2) the scan's cells for each turn; offsets run from -half to half. The
    score is the sum of the values less a penalty `per_turn` (turns,) and `per_square` per squared
    cell of offset.
    """
    squares, bounds = _largest_squares(task)
    best = (-1, 0, 0, least)
    for k in np.argsort(-bounds):
        if bounds[k] <= best[3]:
            break
        best = _descend(task, squares[k], float(bounds[k]), best)
    return best


@kernel
def _largest_squares(task: Task) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return turn, row and col (k, 3) of the squares that together are the window, and bounds."""
    level = len(task.layers) - 1
    side = 1 << level
    count = (2 * task.half + side) // side
    squares = np.empty((len(task.cells) * count * count, 3), np.int32)
    bounds = np.empty(len(squares))
    n = 0
    for turn in range(len(task.cells)):
        for i in range(count):
            for j in range(count):
                row, col = -task.half + i * side, -task.half + j * side
                squares[n, 0], squares[n, 1], squares[n, 2] = turn, row, col
                bounds[n] = _bound(task, turn, level, row, col)
                n += 1
    return squares, bounds


@kernel
def _descend(
    task: Task, square: NDArray[np.int32], bound: float, best: tuple[int, int, int, float]
) -> tuple[int, int, int, float]:
    """Return the best offset of a square if it beats `best`, the most promising quarters first."""
    turn, depth = int(square[0]), len(task.layers)
    stack, bounds = np.empty((4 * depth, 3), np.int32), np.empty(4 * depth)
    stack[0, 0], stack[0, 1], stack[0, 2] = square[1], square[2], depth - 1
    bounds[0] = bound
    size = 1
    while size > 0:
        size -= 1
        row, col, level = int(stack[size, 0]), int(stack[size, 1]), int(stack[size, 2])
        if bounds[size] <= best[3]:
            continue
        if level == 0:
            best = (turn, row, col, float(bounds[size]))
            continue
        first, half = size, 1 << (level - 1)
        for quarter in range(4):
            r, c = row + (quarter // 2) * half, col + (quarter % 2) * half
            if r > task.half or c > task.half:
                continue
            possible = _bound(task, turn, level - 1, r, c)
            place = size
            while place > first and bounds[place - 1] > possible:
                bounds[place] = bounds[place - 1]
                stack[place] = stack[place - 1]
                place -= 1
            stack[place, 0], stack[place, 1], stack[place, 2] = r, c, level - 1
            bounds[place] = possible
            size += 1
    return best


@kernel
def _bound(task: Task, turn: int, level: int, row: int, col: int) -> float:
    """No offset of the square of 2**level cells from (row, col) on scores more than this."""
    last = (1 << level) - 1
    nearest_row = max(row, min(0, row + last))
    nearest_col = max(col, min(0, col + last))
    away = nearest_row * nearest_row + nearest_col * nearest_col
    total = _sum_at(task.layers[level], task.cells[turn], row, col)
    return float(total - task.per_square * away - task.per_turn[turn])
