"""How well features seen fit those bound to nodes: constellations against constellations.

Every pairing is weighed against chance: a pair says by how much its nearness beats a feature that
is there by accident, a bound feature that should be in view and is not says how seldom that
happens, and a feature seen too much says nothing. So whatever is missing or extra, the evidence
of a place is a log-likelihood ratio that can be compared with any other's. Each kernel has a
plain twin in tests/naive/node_chain.py.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.topology.node_chains.pairs import (
    Model,
    Seen,
    There,
    all_unseen,
    choose_pairs,
    fit_pairs,
    weigh_pairs,
)

ROUNDS = 3
"""Times that pairs are chosen and the pose is fitted to them, from each place tried."""

TRIED_WITHIN = 3.0
"""Places tried lie within so many standard deviations of an arrival, along either axis."""


class Bound(NamedTuple):
    """Features of all nodes in map, one node's after the other; node k's begin at `firsts[k]`."""

    kinds: NDArray[np.int64]
    poses: NDArray[np.float64]
    widths: NDArray[np.float64]
    variances: NDArray[np.float64]
    firsts: NDArray[np.int64]


class Arrivals(NamedTuple):
    """Where the robot may be (m): at which of the `nodes`, and at what `poses` (m, 3) in map.

    `spreads` (m, 2): standard deviations of the place along either axis, m, and of the heading.
    """

    nodes: NDArray[np.int64]
    poses: NDArray[np.float64]
    spreads: NDArray[np.float64]


@kernel
def weigh_places(
    seen: Seen,
    bound: Bound,
    arrivals: Arrivals,
    model: Model,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Return how well what is seen fits arrivals (m) at nodes.

    Returns evidence (m,), a log-likelihood ratio against features that are there by chance; the
    fitted offset (m, 3) of the arrival in the frame of its pose; the information (m, 4) of that
    offset as xx (= yy), x-theta, y-theta, theta-theta; and the number of pairs (m,).
    """
    count = len(arrivals.nodes)
    evidence, pairs = np.empty(count), np.empty(count, np.int64)
    offsets, information = np.empty((count, 3)), np.empty((count, 4))
    for k in range(count):
        node = arrivals.nodes[k]
        first, last = bound.firsts[node], bound.firsts[node + 1]
        near = _in_frame(bound.poses[first:last], arrivals.poses[k])
        there = There(
            bound.kinds[first:last],
            near,
            bound.widths[first:last],
            bound.variances[first:last],
            arrivals.spreads[k, 0],
            arrivals.spreads[k, 1],
        )
        pairs[k], evidence[k] = _best_fit(seen, there, model, offsets[k], information[k])
    return evidence, offsets, information, pairs


@kernel
def _in_frame(poses: NDArray[np.float64], frame: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return poses (n, 3) as seen from another."""
    moved = np.empty_like(poses)
    cos, sin = np.cos(frame[2]), np.sin(frame[2])
    for j in range(len(poses)):
        dx, dy = poses[j, 0] - frame[0], poses[j, 1] - frame[1]
        moved[j, 0], moved[j, 1] = cos * dx + sin * dy, cos * dy - sin * dx
        moved[j, 2] = poses[j, 2] - frame[2]
    return moved


@kernel
def _best_fit(
    seen: Seen,
    there: There,
    model: Model,
    offset: NDArray[np.float64],
    information: NDArray[np.float64],
) -> tuple[int, float]:
    """Fit from the expected place and from each that lays a feature on its like; keep the best.

    Fills `offset` (3,) and `information` (4,); returns the number of pairs and the evidence.
    """
    most, best = 0, -np.inf
    tried, found = np.zeros(3), np.empty(4)
    widest = TRIED_WITHIN * there.place
    for seed in range(-1, len(seen.kinds) * len(there.kinds)):
        tried[:] = 0.0
        if seed >= 0:
            i, j = seed // len(there.kinds), seed % len(there.kinds)
            tried[:2] = there.poses[j, :2] - seen.poses[i, :2]
            unlike = seen.kinds[i] != there.kinds[j]
            if unlike or abs(tried[0]) > widest or abs(tried[1]) > widest:
                continue
        pairs, evidence = _fit(seen, there, model, tried, found)
        if evidence > best:
            most, best = pairs, evidence
            offset[:], information[:] = tried, found
    return most, best


@kernel
def _fit(
    seen: Seen,
    there: There,
    model: Model,
    offset: NDArray[np.float64],
    information: NDArray[np.float64],
) -> tuple[int, float]:
    """Pair and fit in turns from `offset` (3,), which moves; return pairs and evidence."""
    gains = np.empty((len(seen.kinds), len(there.kinds)))
    partner = np.empty(len(seen.kinds), np.int64)
    for _ in range(ROUNDS):
        weigh_pairs(seen, there, model, offset, gains)
        choose_pairs(gains, partner)
        fit_pairs((seen, there), model, partner, offset, information)
    weigh_pairs(seen, there, model, offset, gains)
    choose_pairs(gains, partner)
    fit_pairs((seen, there), model, partner, offset.copy(), information)
    across, along_x, along_y, turning = information
    volume = across * (across * turning - along_x**2 - along_y**2)
    prior = 1.0 / (there.place**4 * there.turn**2)
    off_place = (offset[0] ** 2 + offset[1] ** 2) / there.place**2
    evidence = 0.5 * (np.log(prior / volume) - off_place - (offset[2] / there.turn) ** 2)
    evidence += all_unseen(there, model, offset)
    pairs = 0
    for i in range(len(partner)):
        if partner[i] >= 0:
            pairs += 1
            evidence += gains[i, partner[i]]
    return pairs, evidence
