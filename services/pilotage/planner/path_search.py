"""The best ways from a place through a grid, and any-angle ways by straight lines; pure.

Steps go to the eight neighbours, diagonally only where both cells beside the step are free. A
step costs its length times the mean cost of its two cells, so there and back cost the same.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.planner.path_kernels import descend, pull_tight, spread, warm_up

__all__ = ["shortened", "travel_field", "warm_up", "way_to"]

Mask = NDArray[np.bool_]
Field = NDArray[np.float32]
Cells = NDArray[np.int64]

PATIENCE = 20
"""Cells of a way in a row that no straight line reaches before the line is ended."""


def travel_field(
    passable: Mask,
    cost: Field,
    resolution: float,
    start: ArrayLike,
    goal: ArrayLike | None = None,
) -> Field:
    """Return what the best way from a cell to each cell costs, infinity where there is none.

    Args:
        passable: (rows, cols) where a way may lead.
        cost: (rows, cols) >= 1, of a metre through each cell.
        resolution: m.
        start: row, col; inside the grid.
        goal: row, col where the search may end; then only costs along its way are final.

    Returns:
        (rows, cols) cost-metres; all infinite if the start is not passable.
    """
    first, last = _number(start, passable), -1 if goal is None else _number(goal, passable)
    factors = _with_rim(passable, cost)
    if factors.flat[first] <= 0.0:
        return np.full(passable.shape, np.inf, np.float32)
    return spread(factors, resolution, first, last)[1:-1, 1:-1]


def way_to(field: Field, passable: Mask, cell: ArrayLike, cost: Field | None = None) -> Cells:
    """Return the cells (n, 2) of the way from the start of a field to `cell`, both included.

    The way is the best one if `cost` is that of the field (None: 1 everywhere); empty (0, 2) if
    the field does not reach the cell.
    """
    row, col = np.asarray(cell, int)
    if not np.isfinite(field[row, col]):
        return np.zeros((0, 2), np.int64)
    factors = _with_rim(passable, np.ones_like(field) if cost is None else cost)
    reached = np.pad(field, 1, constant_values=np.float32(np.inf))
    way = descend(reached, factors, _number(cell, passable))
    return np.stack([way // factors.shape[1], way % factors.shape[1]], axis=1) - 1


def shortened(way: Cells, passable: Mask, cost: Field) -> Cells:
    """Return the few cells (m, 2) of a way (n, 2) between which straight lines can take its place.

    No line leads through or by the corner of an impassable cell, or costs more than the piece
    of the way it replaces; so none shaves a wall to save a step.
    """
    if len(way) < 3:
        return way
    # Contiguous, as the kernel was compiled for.
    return way[pull_tight(_with_rim(passable, cost), np.ascontiguousarray(way + 1), PATIENCE)]


def _number(cell: ArrayLike, passable: Mask) -> int:
    """Return the number of a cell (row, col) in the grid with its rim."""
    row, col = np.asarray(cell, int)
    return int((row + 1) * (passable.shape[1] + 2) + col + 1)


def _with_rim(passable: Mask, cost: Field) -> Field:
    """Return the costs (rows + 2, cols + 2) with 0 where no way leads, and all round."""
    factors = np.zeros((passable.shape[0] + 2, passable.shape[1] + 2), np.float32)
    np.multiply(cost, passable, out=factors[1:-1, 1:-1], where=passable)
    return factors
