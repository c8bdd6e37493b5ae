"""Ways between the nodes of a map: each cell belongs to the node it is nearest to by driving.

Where the cells of two nodes meet, a way leads from one to the other: over the meeting place that
is cheapest, back along both trees. So no way crosses a wall, and none passes a third node's ground.
"""

import heapq
from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.topology.from_map.space import Space

WORTH = 1.02
"""A way is straightened where that costs at most so many times as much."""
DETOUR = 1.4
"""A way is dropped if other ways lead there at most so many times as long."""


@dataclass(frozen=True)
class Way:
    """A way between two sources, by their indices: `points` (k, 2) in map, and its length, m."""

    start: int
    end: int
    points: NDArray[np.float64]
    length: float


@dataclass(frozen=True)
class Gates:
    """Which sources (n,) stand in openings, and the cells (rows, cols) that shut these."""

    sources: NDArray[np.bool_]
    cells: NDArray[np.bool_]

    @classmethod
    def none(cls, count: int, space: Space) -> "Gates":
        """Return that none of so many sources stands in an opening."""
        return cls(np.zeros(count, bool), np.zeros(space.geometry.shape, bool))


def find_ways(
    space: Space, sources: NDArray[np.int64], costs: NDArray[np.float32], gates: Gates
) -> list[Way]:
    """Return the ways between neighbouring sources, cells (n, 2) that the robot may stand in.

    Those between places within a room are found with all openings shut, so that no opening's
    ground lies in between; the others have one end in an opening.
    """
    shut = np.where(gates.cells, np.float32(np.inf), costs)
    inside = _ways_among(space, np.flatnonzero(~gates.sources), sources, shut)
    through = [
        way
        for way in _ways_among(space, np.arange(len(sources)), sources, costs)
        if gates.sources[[way.start, way.end]].any()
    ]
    return _without_detours(inside + through)


def _ways_among(
    space: Space, which: NDArray[np.int64], sources: NDArray[np.int64], costs: NDArray[np.float32]
) -> list[Way]:
    """Return the ways between neighbours among some of the sources."""
    if len(which) == 0:
        return []
    spent, owner, came_from = spread(costs, sources[which])
    found = np.where(owner >= 0, which[owner], -1), came_from
    return [_way(space, costs, meeting, found) for meeting in _meetings(spent, found[0])]


def _meetings(spent: NDArray[np.float32], owner: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the cheapest pair of neighbouring cells (n, 2), flat, of each two owners that meet."""
    cells = np.arange(owner.size, dtype=np.int64).reshape(owner.shape)
    here, there = [], []
    for one, other in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        meets = (owner[one] != owner[other]) & (owner[one] >= 0) & (owner[other] >= 0)
        here.append(cells[one][meets])
        there.append(cells[other][meets])
    pairs = np.stack([np.concatenate(here), np.concatenate(there)], axis=1)
    owners = np.sort(owner.ravel()[pairs], axis=1)
    total = spent.ravel()[pairs].sum(axis=1)
    order = np.lexsort((total, owners[:, 1], owners[:, 0]))
    _, first = np.unique(owners[order], axis=0, return_index=True)
    return np.asarray(pairs[order[first]])


def _way(
    space: Space,
    costs: NDArray[np.float32],
    meeting: NDArray[np.int64],
    found: tuple[NDArray[np.int64], NDArray[np.int64]],
) -> Way:
    """Return the way over a meeting place, from the owners of cells and where cells come from."""
    owner, came_from = found
    first, second = (trace(came_from.ravel(), int(cell)) for cell in meeting)
    flat = np.concatenate([first[::-1], second])
    cells = np.stack(np.divmod(flat, owner.shape[1]), axis=1)
    points = space.geometry.centres_of(straightened(cells, costs))
    length = float(np.hypot(*np.diff(points, axis=0).T).sum())
    start, end = owner.ravel()[meeting]
    if start > end:
        start, end, points = end, start, points[::-1]
    return Way(int(start), int(end), points, length)


def straightened(cells: NDArray[np.int64], costs: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return the cells (k, 2) of a way (n, 2) between which it may as well go straight.

    Straight is as well if it costs hardly more; a grid's own ways have only eight directions.
    """
    if len(cells) <= 2:
        return cells
    there = costs[tuple(cells.T)].astype(float)
    steps = np.hypot(*np.diff(cells, axis=0).T)
    as_it_is = float(np.sum(steps * (there[1:] + there[:-1]) / 2.0))
    if _straight_cost(cells[0], cells[-1], costs) <= WORTH * as_it_is:
        return cells[[0, -1]]
    bend = _farthest(cells)
    first = straightened(cells[: bend + 1], costs)
    return np.concatenate([first[:-1], straightened(cells[bend:], costs)])


def _straight_cost(
    start: NDArray[np.int64], end: NDArray[np.int64], costs: NDArray[np.float32]
) -> float:
    """Return what a straight line between two cells costs, in cells."""
    step = end - start
    count = 2 * int(np.abs(step).max()) + 1
    at = np.rint(start + np.linspace(0.0, 1.0, count)[:, None] * step).astype(np.int64)
    return float(costs[tuple(at.T)].mean() * np.hypot(*step))


def _farthest(cells: NDArray[np.int64]) -> int:
    """Return which inner cell of a way lies farthest from the line between its ends."""
    along = (cells[-1] - cells[0]).astype(float)
    away = cells[1:-1] - cells[0]
    if not along.any():
        return 1 + int(np.argmax(np.hypot(*away.T)))
    return 1 + int(np.argmax(np.abs(along[0] * away[:, 1] - along[1] * away[:, 0])))


def _without_detours(ways: list[Way]) -> list[Way]:
    """Return the fewest ways that leave no detour: a greedy spanner (Althöfer et al. 1993)."""
    kept: list[Way] = []
    beside: dict[int, list[tuple[int, float]]] = defaultdict(list)
    for way in sorted(ways, key=lambda way: way.length):
        if not _reaches(beside, way, DETOUR * way.length):
            kept.append(way)
            beside[way.start].append((way.end, way.length))
            beside[way.end].append((way.start, way.length))
    return kept


def _reaches(beside: dict[int, list[tuple[int, float]]], way: Way, limit: float) -> bool:
    """Say whether ways lead from start to end of another within a length, m."""
    nearest: dict[int, float] = {}
    queue = [(0.0, way.start)]
    while queue:
        length, at = heapq.heappop(queue)
        if at == way.end:
            return True
        if at not in nearest:
            nearest[at] = length
            steps = ((length + step, other) for other, step in beside[at])
            for reached in steps:
                if reached[0] <= limit:
                    heapq.heappush(queue, reached)
    return False


@kernel
def spread(
    costs: NDArray[np.float32], sources: NDArray[np.int64]
) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.int64]]:
    """Spread from all sources at once, nearest first (Dijkstra 1959).

    Args:
        costs: of a step of one cell (rows, cols); infinite where nothing goes. The rim must be.
        sources: cells (n, 2).

    Returns:
        What it costs to get to each cell, in cells; the source it belongs to, -1 for none; the
        cell, flat, that it is reached from, -1 at sources. All (rows, cols).
    """
    rows, cols = costs.shape
    spent = np.full((rows, cols), np.inf, np.float32)
    owner = np.full((rows, cols), -1, np.int32)
    came_from = np.full((rows, cols), -1, np.int64)
    queue = [(np.float32(0.0), np.int64(0)) for _ in range(0)]
    for i in range(len(sources)):
        row, col = sources[i]
        spent[row, col], owner[row, col] = 0.0, i
        heapq.heappush(queue, (np.float32(0.0), np.int64(row * cols + col)))
    while queue:
        cost, cell = heapq.heappop(queue)
        row, col = cell // cols, cell % cols
        if cost > spent[row, col]:
            continue
        for i in range(-1, 2):
            for j in range(-1, 2):
                step = costs[row + i, col + j]
                if step == np.inf:
                    continue
                far = np.float32(np.sqrt(float(i * i + j * j)))
                new = np.float32(cost + np.float32(0.5) * far * (step + costs[row, col]))
                if new < spent[row + i, col + j]:
                    spent[row + i, col + j] = new
                    owner[row + i, col + j] = owner[row, col]
                    came_from[row + i, col + j] = cell
                    heapq.heappush(queue, (new, np.int64((row + i) * cols + col + j)))
    return spent, owner, came_from


@kernel
def trace(came_from: NDArray[np.int64], cell: int) -> NDArray[np.int64]:
    """Return the cells, flat, from `cell` back to its source."""
    count = 1
    at = cell
    while came_from[at] >= 0:
        at = came_from[at]
        count += 1
    cells = np.empty(count, np.int64)
    at = cell
    for i in range(count):
        cells[i] = at
        at = came_from[at]
    return cells
