"""How the free space of a map is searched for openings and ways, cell by cell."""

import numpy as np
from numpy.typing import NDArray

Cell = tuple[int, int]


def walls_as_near(is_wall: NDArray[np.bool_], cell: Cell) -> set[Cell]:
    """The cells that `distance_field.nearest_walls` may give for a cell: all that are as near."""
    walls = np.argwhere(is_wall)
    if len(walls) == 0:
        return {(-1, -1)}
    squared = ((walls - np.array(cell)) ** 2).sum(axis=1)
    return {(int(row), int(col)) for row, col in walls[squared == squared.min()]}


def opposite_walls(
    is_free: NDArray[np.bool_], nearest: NDArray[np.int32], limits: NDArray[np.float64]
) -> dict[Cell, float]:
    """Which cells `map_chords.opposite_walls` finds, each with the least cosine there is."""
    found = {}
    for row, col in np.argwhere(is_free[1:-1, 1:-1]) + 1:
        to_nearest = nearest[row, col] - (row, col)
        if limits[0] <= np.hypot(*to_nearest) <= limits[1]:
            around = nearest[row - 1 : row + 2, col - 1 : col + 2].reshape(-1, 2)
            least = min(cosine(to_nearest, wall - (row, col)) for wall in around)
            if least <= limits[2]:
                found[int(row), int(col)] = least
    return found


def cosine(one: NDArray[np.int64], other: NDArray[np.int64]) -> float:
    """Of the angle between two vectors."""
    return float(one @ other / (np.hypot(*one) * np.hypot(*other) + 1e-9))


def widenings(
    clearance: NDArray[np.float32],
    walls: NDArray[np.int64],
    scale: NDArray[np.float64],
    askew: float,
) -> NDArray[np.float64]:
    """Twin of `map_chords.widenings`."""
    found = np.zeros((len(walls), 2))
    for i, chord in enumerate(walls):
        half = 0.5 * float(np.hypot(*(chord[2:] - chord[:2])))
        steps = np.arange(1, int(scale[0] + half))
        for side, sign in enumerate((1.0, -1.0)):
            looks = [_look(chord, sign, turn * askew) for turn in (-1.0, 1.0)]
            seen = [_widest_on(clearance, chord, steps, look) for look in looks]
            found[i, side] = max(seen) / (half * float(scale[1]))
    return found


def _look(chord: NDArray[np.int64], side: float, askew: float) -> tuple[float, float]:
    """One step as rows and cols: a cell away from the chord to one side, and so far along it."""
    up, right = chord[2:] - chord[:2]
    length = float(np.hypot(up, right))
    return side / length * right + askew / length * up, askew / length * right - side / length * up


def _widest_on(
    clearance: NDArray[np.float32],
    chord: NDArray[np.int64],
    steps: NDArray[np.int64],
    look: tuple[float, float],
) -> float:
    """The greatest clearance on a line from the middle of a chord, before it comes to a wall."""
    rows = np.rint((chord[0] + chord[2]) / 2.0 + steps * look[0]).astype(int)
    cols = np.rint((chord[1] + chord[3]) / 2.0 + steps * look[1]).astype(int)
    seen = [0.0]
    for row, col in zip(rows, cols, strict=True):
        inside = 0 <= row < clearance.shape[0] and 0 <= col < clearance.shape[1]
        if not inside or clearance[row, col] <= 0.0:
            break
        seen.append(float(clearance[row, col]))
    return max(seen)


def spent_from(costs: NDArray[np.float32], source: Cell) -> NDArray[np.float64]:
    """What `map_ways.spread` spends from one source alone: relaxed until nothing gets cheaper."""
    spent = np.full(costs.shape, np.inf)
    spent[source] = 0.0
    while True:
        cheaper = spent.copy()
        for up in (-1, 0, 1):
            for right in (-1, 0, 1):
                there = _shifted(spent, up, right) + step_cost(costs, up, right)
                cheaper = np.minimum(cheaper, there)
        if np.array_equal(cheaper, spent):
            return spent
        spent = cheaper


def step_cost(costs: NDArray[np.float32], up: int, right: int) -> NDArray[np.float64]:
    """What a step into each cell costs, coming from the cell so far up and to the right."""
    mean = (costs.astype(float) + _shifted(costs.astype(float), up, right)) / 2.0
    return np.asarray(mean * np.hypot(up, right)) if (up, right) != (0, 0) else np.zeros_like(mean)


def _shifted(field: NDArray[np.float64], up: int, right: int) -> NDArray[np.float64]:
    """The values of the cells so far up and to the right of each; infinite beyond the rim."""
    rows, cols = field.shape
    padded = np.pad(field, 1, constant_values=np.inf)
    return padded[1 + up : 1 + up + rows, 1 + right : 1 + right + cols]


def trace(came_from: NDArray[np.int64], cell: int) -> list[int]:
    """Twin of `map_ways.trace`."""
    before = int(came_from[cell])
    return [cell, *trace(came_from, before)] if before >= 0 else [cell]
