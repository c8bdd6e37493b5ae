"""Best ways through a grid with a heap, and straight lines by looking at every cell of the grid."""

import heapq
import itertools

import numpy as np
from numpy.typing import NDArray

Cell = tuple[int, int]
STEPS = [(i, j) for i, j in itertools.product((-1, 0, 1), repeat=2) if (i, j) != (0, 0)]


def neighbours(passable: NDArray[np.bool_], cell: Cell) -> list[Cell]:
    """Cells one step away: diagonally only if both cells beside the step are passable."""
    rows, cols = passable.shape

    def is_open(row: int, col: int) -> bool:
        return 0 <= row < rows and 0 <= col < cols and bool(passable[row, col])

    row, col = cell
    return [
        (row + i, col + j)
        for i, j in STEPS
        if is_open(row + i, col + j) and is_open(row + i, col) and is_open(row, col + j)
    ]


def step_cost(cost: NDArray[np.float32], a: Cell, b: Cell, resolution: float) -> float:
    """What a step between neighbours costs."""
    length = float(np.hypot(a[0] - b[0], a[1] - b[1])) * resolution
    return length * (float(cost[a]) + float(cost[b])) / 2.0


def travel_field(
    passable: NDArray[np.bool_], cost: NDArray[np.float32], resolution: float, start: Cell
) -> NDArray[np.float64]:
    """Twin of `path_search.travel_field`."""
    field = np.full(passable.shape, np.inf)
    if not passable[start]:
        return field
    field[start] = 0.0
    heap = [(0.0, start)]
    while heap:
        so_far, cell = heapq.heappop(heap)
        if so_far > field[cell]:
            continue
        for other in neighbours(passable, cell):
            total = so_far + step_cost(cost, cell, other, resolution)
            if total < field[other]:
                field[other] = total
                heapq.heappush(heap, (total, other))
    return field


def way_cost(cost: NDArray[np.float32], way: NDArray[np.int64], resolution: float) -> float:
    """What a way (n, 2) through neighbouring cells costs."""
    cells = [(int(row), int(col)) for row, col in way]
    return sum(step_cost(cost, a, b, resolution) for a, b in itertools.pairwise(cells))


def line_cost(factors: NDArray[np.float32], start: Cell, end: Cell) -> float:
    """Twin of `path_kernels.line_cost`: clips the line to each cell of the grid."""
    a, way = np.array(start, float), np.array(end, float) - np.array(start, float)
    total = 0.0
    for cell in np.ndindex(factors.shape):
        enter, leave = 0.0, 1.0
        for axis in (0, 1):
            low, high = cell[axis] - 0.5 - a[axis], cell[axis] + 0.5 - a[axis]
            if way[axis] == 0.0:
                if not low <= 0.0 <= high:
                    enter = np.inf
                continue
            at = sorted((low / way[axis], high / way[axis]))
            enter, leave = max(enter, at[0]), min(leave, at[1])
        if leave < enter - 1e-12:
            continue
        if factors[cell] <= 0.0:
            return float("inf")
        total += max(0.0, leave - enter) * float(np.hypot(*way)) * float(factors[cell])
    return total
