"""The kernels of path search: costs of ways through a grid, and what a straight line costs; pure.

Cells are numbered in a grid with a rim of blocked cells, so that every cell has eight neighbours.
Ways are found nearest first (Dijkstra 1959), or nearest to the goal first (Hart, Nilsson &
Raphael 1968), with a ring of buckets in place of a heap (Dial 1969): a step costs at least
`resolution`, so what lies in one bucket of that width hardly ever improves another in it; and if
it does, the other is taken out again.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

Field = NDArray[np.float32]
Cells = NDArray[np.int64]

NOT_QUEUED = 2**31 - 1
MOST_BUCKETS = 4096
ROOT_2 = math.sqrt(2.0)


@kernel
def _put_in(cell: int, bucket: int, firsts: NDArray[np.int32], links: NDArray[np.int32]) -> None:
    """Put a cell first in a bucket; links (n, 2) are the cells before and after each."""
    after = firsts[bucket]
    links[cell, 0], links[cell, 1] = -1 - bucket, after
    if after >= 0:
        links[after, 0] = cell
    firsts[bucket] = cell


@kernel
def _take_out(cell: int, firsts: NDArray[np.int32], links: NDArray[np.int32]) -> None:
    """Take a cell out of its bucket; the first of a bucket has -1 - bucket before it."""
    before, after = links[cell, 0], links[cell, 1]
    if before < 0:
        firsts[-1 - before] = after
    else:
        links[before, 1] = after
    if after >= 0:
        links[after, 0] = before
    links[cell, 0] = NOT_QUEUED


@kernel
def _least_way(cell: int, goal: int, cols: int, resolution: float) -> float:
    """Return what the way to the goal costs at least; 0 without a goal (-1)."""
    if goal < 0:
        return 0.0
    across = abs(cell // cols - goal // cols)
    along = abs(cell % cols - goal % cols)
    steps = max(across, along) + (ROOT_2 - 1.0) * min(across, along)
    # A trifle less, so that sums in single precision never fall below it.
    return 0.9999 * steps * resolution


@kernel
def spread(factors: Field, resolution: float, start: int, goal: int) -> Field:
    """Return what the best way from `start` to each cell costs, infinity where none is known.

    Args:
        factors: (rows, cols) cost of a metre through each cell, >= 1; 0 is blocked, as the rim is.
        resolution: m.
        start: number of a free cell: row * cols + col.
        goal: number of the cell at which the search may end, -1 to reach all of them.

    Returns:
        (rows, cols) cost-metres; a step costs its length times the mean of both factors. With
        a goal, cells off its way may be dearer than need be.
    """
    rows, cols = factors.shape
    factor, field = factors.ravel(), np.full(rows * cols, np.inf, np.float32)
    steps = np.array([-1, 1, -cols, cols, -cols - 1, -cols + 1, cols - 1, cols + 1])
    dearest = 2.0 * ROOT_2 * resolution * float(factor.max())
    width = max(resolution, dearest / MOST_BUCKETS)
    count = int(dearest / width) + 3
    firsts = np.full(count, -1, np.int32)
    links = np.full((rows * cols, 2), NOT_QUEUED, np.int32)
    field[start] = 0.0
    turn = int(_least_way(start, goal, cols, resolution) / width)
    _put_in(start, turn % count, firsts, links)
    queued, empty = 1, 0
    while queued > 0 and empty <= count:
        cell = firsts[turn % count]
        if cell < 0:
            if goal >= 0 and field[goal] < turn * width:
                break
            turn, empty = turn + 1, empty + 1
            continue
        _take_out(cell, firsts, links)
        queued, empty = queued - 1, 0
        for i in range(8):
            other = cell + steps[i]
            if factor[other] <= 0.0:
                continue
            length = resolution
            if i >= 4:
                # Diagonally only if neither cell beside the way is blocked.
                aside = 1 if (i % 2) else -1
                if factor[cell + aside] <= 0.0 or factor[other - aside] <= 0.0:
                    continue
                length = resolution * ROOT_2
            cost = np.float32(field[cell] + 0.5 * length * (factor[cell] + factor[other]))
            if cost < field[other]:
                field[other] = cost
                if links[other, 0] != NOT_QUEUED:
                    _take_out(other, firsts, links)
                    queued -= 1
                ahead = cost + _least_way(other, goal, cols, resolution)
                _put_in(other, max(turn, int(ahead / width)) % count, firsts, links)
                queued += 1
    return field.reshape(rows, cols)


@kernel
def descend(field: Field, factors: Field, cell: int) -> Cells:
    """Return the cells (n,) of the way from the start of a field to a cell that it reaches."""
    cols = factors.shape[1]
    factor, cost = factors.ravel(), field.ravel()
    steps = np.array([-1, 1, -cols, cols, -cols - 1, -cols + 1, cols - 1, cols + 1])
    way = [cell]
    while cost[cell] > 0.0:
        best, steepest = -1, 0.0
        for i in range(8):
            other = cell + steps[i]
            if factor[other] <= 0.0 or cost[other] >= cost[cell]:
                continue
            length = 1.0
            if i >= 4:
                aside = 1 if (i % 2) else -1
                if factor[cell + aside] <= 0.0 or factor[other - aside] <= 0.0:
                    continue
                length = ROOT_2
            slope = (cost[cell] - cost[other]) / (length * (factor[cell] + factor[other]))
            if slope > steepest:
                best, steepest = other, slope
        if best < 0:
            break
        cell = best
        way.append(cell)
    return np.array(way[::-1])


@kernel
def line_cost(factors: Field, start: Cells, end: Cells) -> float:
    """Return what the straight line between two cells' centres costs, in cells times factor.

    Infinite if it touches a blocked cell, be it at a corner. `start`, `end`: (2,) row, col.
    """
    rise, run = float(end[0] - start[0]), float(end[1] - start[1])
    length = math.hypot(rise, run)
    row, col = start[0], start[1]
    if length == 0.0:
        return 0.0 if factors[row, col] > 0.0 else math.inf
    up, right = (1 if rise > 0.0 else -1), (1 if run > 0.0 else -1)
    per_row = length / abs(rise) if rise != 0.0 else math.inf
    per_col = length / abs(run) if run != 0.0 else math.inf
    next_row, next_col = 0.5 * per_row, 0.5 * per_col
    travelled, cost = 0.0, 0.0
    while True:
        if factors[row, col] <= 0.0:
            return math.inf
        until = min(next_row, next_col, length)
        cost += (until - travelled) * float(factors[row, col])
        travelled = until
        if travelled >= length - 1e-9:
            return float(cost)
        is_corner = abs(next_row - next_col) < 1e-9
        if is_corner and (factors[row + up, col] <= 0.0 or factors[row, col + right] <= 0.0):
            return math.inf
        if is_corner or next_row < next_col:
            row, next_row = row + up, next_row + per_row
        if is_corner or next_col <= until:
            col, next_col = col + right, next_col + per_col


@kernel
def pull_tight(factors: Field, way: Cells, patience: int) -> Cells:
    """Return the indices (m,) of those cells of a way (n, 2) that straight lines need to join.

    A line replaces a piece of the way if it costs no more. After `patience` cells in a row that
    no line reaches, no more are tried.
    """
    last = len(way) - 1
    kept, here = [0], 0
    while here < last:
        farthest, so_far, failed = here + 1, 0.0, 0
        for there in range(here + 1, last + 1):
            so_far += line_cost(factors, way[there - 1], way[there])
            if line_cost(factors, way[here], way[there]) <= so_far + 1e-6:
                farthest, failed = there, 0
            else:
                failed += 1
                if failed > patience:
                    break
        kept.append(farthest)
        here = farthest
    return np.array(kept)


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    factors = np.zeros((3, 4), np.float32)
    factors[1, 1:3] = 1.0
    field = spread(factors, 1.0, 5, -1)
    descend(field, factors, 6)
    pull_tight(factors, np.array([[1, 1], [1, 2]]), 1)
