"""The cheapest way through a graph in compact arrays: A* with a binary heap (Hart et al. 1968).

What the rest of a way costs at least is told by landmarks: from one that is a m from here and b m
from the goal, the two lie |a - b| m apart or more (Goldberg & Harrelson 2005). Unlike a straight
line that holds for lifts too, and round a building it tells more.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

Numbers = NDArray[np.int64]


@kernel
def _rise(heap: Numbers, where: Numbers, rank: NDArray[np.float64], child: int) -> None:
    """Move a node up in the heap as far as its rank, which has fallen, wants it."""
    node = heap[child]
    while child > 0:
        parent = (child - 1) // 2
        if rank[heap[parent]] <= rank[node]:
            break
        heap[child] = heap[parent]
        where[heap[child]] = child
        child = parent
    heap[child] = node
    where[node] = child


@kernel
def _take_first(heap: Numbers, where: Numbers, rank: NDArray[np.float64], count: int) -> int:
    """Take the node of least rank out of a heap of `count` nodes."""
    first, last = heap[0], heap[count - 1]
    where[first] = -1
    count -= 1
    place = 0
    while 2 * place + 1 < count:
        child = 2 * place + 1
        if child + 1 < count and rank[heap[child + 1]] < rank[heap[child]]:
            child += 1
        if rank[last] <= rank[heap[child]]:
            break
        heap[place] = heap[child]
        where[heap[place]] = place
        place = child
    heap[place] = last
    if count > 0:
        where[last] = place
    return int(first)


@kernel
def _rest(landmarks: NDArray[np.float64], node: int, end: int) -> float:
    """Return what the way from a node to the end costs at least."""
    most = 0.0
    for i in range(landmarks.shape[1]):
        apart = abs(landmarks[node, i] - landmarks[end, i])
        # A landmark that cannot be reached from here is infinitely far from both: NaN apart.
        most = max(most, apart) if apart < np.inf else most
    # A trifle less, so that rounding never makes a way look dearer than it is.
    return 0.999999999 * most


@kernel
def cheapest_steps(
    steps: tuple[Numbers, Numbers, NDArray[np.float64]],
    landmarks: NDArray[np.float64],
    start: int,
    end: int,
) -> tuple[NDArray[np.float64], Numbers]:
    """Return what the cheapest ways from `start` cost, and the steps of the one to `end`.

    Args:
        steps: first step of each node (n + 1,), where each step leads (m,), what it costs (m,).
        landmarks: (n, k) what the way from each node to k landmarks costs.
        start: index of a node.
        end: index of the node at which the search may end, -1 to reach all of them.

    Returns:
        The cost of each node (n,), infinite if no way leads there, and, if the search did not
        end before, as it does with an end; and indices (k,) of the steps to the end in order.
    """
    firsts, targets, costs = steps
    n = len(firsts) - 1
    cost, rank = np.full(n, np.inf), np.full(n, np.inf)
    came_by, came_from = np.full(n, -1, np.int64), np.full(n, -1, np.int64)
    heap, where = np.empty(n, np.int64), np.full(n, -1, np.int64)
    cost[start] = rank[start] = 0.0
    heap[0], where[start], count = start, 0, 1
    while count > 0:
        node = _take_first(heap, where, rank, count)
        count -= 1
        if node == end:
            break
        for step in range(firsts[node], firsts[node + 1]):
            other = targets[step]
            wanted = cost[node] + costs[step]
            if wanted < cost[other]:
                cost[other] = wanted
                rank[other] = wanted + (_rest(landmarks, other, end) if end >= 0 else 0.0)
                came_by[other], came_from[other] = step, node
                if where[other] < 0:
                    heap[count], where[other] = other, count
                    count += 1
                _rise(heap, where, rank, where[other])
    return cost, _steps_back(came_by, came_from, end)


@kernel
def _in_largest_part(firsts: Numbers, targets: Numbers) -> int:
    """Return a node of the part of the graph that has most nodes."""
    n = len(firsts) - 1
    is_known, stack = np.zeros(n, np.bool_), np.empty(n, np.int64)
    best, most = 0, 0
    for seed in range(n):
        if is_known[seed]:
            continue
        stack[0], is_known[seed] = seed, True
        waiting, size = 1, 0
        while waiting > 0:
            waiting, size = waiting - 1, size + 1
            node = stack[waiting]
            for step in range(firsts[node], firsts[node + 1]):
                if not is_known[targets[step]]:
                    stack[waiting], is_known[targets[step]] = targets[step], True
                    waiting += 1
        if size > most:
            best, most = seed, size
    return best


@kernel
def landmark_costs(
    steps: tuple[Numbers, Numbers, NDArray[np.float64]], count: int
) -> NDArray[np.float64]:
    """Return what the way from each node to each of `count` <= n landmarks costs (n, count).

    They lie in the largest part of the graph, each as far as can be from those before it, which
    is at its rims; infinitely far from the other parts, of which they tell nothing.
    """
    n = len(steps[0]) - 1
    found = np.empty((n, count))
    if count == 0:
        return found
    nothing = np.empty((n, 0))
    seed = _in_largest_part(steps[0], steps[1])
    nearest, _ = cheapest_steps(steps, nothing, seed, -1)
    for i in range(count):
        farthest = int(np.argmax(np.where(np.isfinite(nearest), nearest, -1.0)))
        costs, _ = cheapest_steps(steps, nothing, farthest, -1)
        found[:, i] = costs
        nearest = costs if i == 0 else np.minimum(nearest, costs)
    return found


@kernel
def _steps_back(came_by: Numbers, came_from: Numbers, end: int) -> Numbers:
    """Return the steps that led to a node, in order."""
    node, length = end, 0
    while node >= 0 and came_by[node] >= 0:
        node, length = came_from[node], length + 1
    taken = np.empty(length, np.int64)
    node = end
    for i in range(length):
        taken[length - 1 - i] = came_by[node]
        node = came_from[node]
    return taken


def warm_up() -> None:
    """Compile the kernels, or load them."""
    steps = np.array([0, 1, 2]), np.array([1, 0]), np.ones(2)
    cheapest_steps(steps, landmark_costs(steps, 1), 0, 1)
