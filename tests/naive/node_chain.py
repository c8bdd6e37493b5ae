"""Chains of nodes the plain way: every history there could have been, one by one."""

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.topology.features import Features
from pilotage.topology.node_chains.candidates import ChainParams, Link
from pilotage.topology.topological_map import TopologicalMap

ROUNDS, TRIED_WITHIN = 3, 3.0


@dataclass(frozen=True)
class Fit:
    """A constellation on a node: evidence, pose in map, covariance in base_link, pairs."""

    evidence: float
    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]
    pairs: int


@dataclass(frozen=True)
class Place:
    """A node, by its position in the map, and where base_link is expected; or a place near it."""

    node: int
    pose: NDArray[np.float64]
    at_node: bool


def fit_place(
    seen: Features, bound: Features, expected: NDArray[np.float64], params: ChainParams
) -> Fit:
    """Fit features seen (base_link) to those bound to a node (map), near the expected pose.

    `params.place` and `params.turn` say how near.
    """
    seen = seen.chosen(np.hypot(seen.poses[:, 0], seen.poses[:, 1]) <= params.seen_within)
    there = bound.moved(se2.inverse(expected))
    starts = [np.zeros(3)]
    for i, j in itertools.product(range(len(seen)), range(len(there))):
        shift = there.poses[j, :2] - seen.poses[i, :2]
        is_near = np.all(np.abs(shift) <= TRIED_WITHIN * params.place)
        if seen.kinds[i] == there.kinds[j] and is_near:
            starts.append(np.array([*shift, 0.0]))
    fits = [_fit(seen, there, params, start) for start in starts]
    evidence, offset, information, pairs = max(fits, key=lambda fit: fit[0])
    back = _rotation3(-offset[2])
    covariance = back @ np.linalg.inv(information) @ back.T
    return Fit(evidence, se2.compose(expected, offset), covariance, pairs)


def _fit(
    seen: Features, there: Features, params: ChainParams, offset: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64], NDArray[np.float64], int]:
    for _ in range(ROUNDS):
        pairs = _pairs(seen, there, params, offset)
        gradient, information = _normal(seen, there, params, offset, list(pairs))
        offset = offset + np.linalg.solve(information, gradient)
    pairs = _pairs(seen, there, params, offset)
    _, information = _normal(seen, there, params, offset, list(pairs))
    prior = np.diag(np.array([params.place, params.place, params.turn]) ** -2.0)
    evidence = 0.5 * math.log(np.linalg.det(prior) / np.linalg.det(information))
    evidence -= 0.5 * float(offset @ prior @ offset)
    evidence += sum(pairs.values())
    evidence += sum(_miss(there, j, params, offset) for j in range(len(there)))
    return evidence, offset, information, len(pairs)


def _pairs(
    seen: Features, there: Features, params: ChainParams, offset: NDArray[np.float64]
) -> dict[tuple[int, int], float]:
    """Pairs with their gains, the largest first, each feature once."""
    gains = {
        (i, j): _gain(seen, there, (i, j), params, offset)
        for i, j in itertools.product(range(len(seen)), range(len(there)))
        if seen.kinds[i] == there.kinds[j]
    }
    chosen: dict[tuple[int, int], float] = {}
    for (i, j), gain in sorted(gains.items(), key=lambda item: -item[1]):
        if gain > 0.0 and not any(i == a or j == b for a, b in chosen):
            chosen[i, j] = gain
    return chosen


def _gain(
    seen: Features,
    there: Features,
    pair: tuple[int, int],
    params: ChainParams,
    offset: NDArray[np.float64],
) -> float:
    i, j = pair
    kind = int(seen.kinds[i])
    at = se2.compose(offset, seen.poses[i])
    off = there.poses[j] - at
    period = 2.0 * math.pi if kind == 0 else math.pi
    variance = _variance(seen, there, pair, params)
    chance = params.strays[kind] / period
    likely = _normal_density(off[0], math.sqrt(variance))
    likely *= _normal_density(off[1], math.sqrt(variance))
    likely *= _normal_density(_nearest(off[2], period), params.direction)
    wider = seen.widths[i] - there.widths[j]
    if math.isfinite(wider):
        likely *= _normal_density(wider, params.width)
    ratio = likely * params.detection / chance
    if ratio == 0.0:
        return -math.inf
    return math.log(ratio) - _miss(there, j, params, offset)


def _normal(
    seen: Features,
    there: Features,
    params: ChainParams,
    offset: NDArray[np.float64],
    pairs: list[tuple[int, int]],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Gradient and information of the offset."""
    sigmas = np.array([params.place, params.place, params.turn])
    information = np.diag(sigmas**-2.0)
    gradient = -information @ offset
    for i, j in pairs:
        at = se2.compose(offset, seen.poses[i])
        lever = at[:2] - offset[:2]
        jacobian = np.array([[1.0, 0.0, -lever[1]], [0.0, 1.0, lever[0]], [0.0, 0.0, 1.0]])
        off = there.poses[j] - at
        off[2] = _nearest(off[2], 2.0 * math.pi if seen.kinds[i] == 0 else math.pi)
        variance = _variance(seen, there, (i, j), params)
        weight = np.diag([1.0 / variance, 1.0 / variance, params.direction**-2.0])
        information = information + jacobian.T @ weight @ jacobian
        gradient = gradient + jacobian.T @ weight @ off
    return gradient, information


def _variance(seen: Features, there: Features, pair: tuple[int, int], params: ChainParams) -> float:
    one, other = seen.covariances[pair[0]], there.covariances[pair[1]]
    return float(np.trace(one + other) / 2.0) + params.blur**2


def _miss(there: Features, j: int, params: ChainParams, offset: NDArray[np.float64]) -> float:
    x, y, _ = se2.between(offset, there.poses[j])
    in_view = abs(math.atan2(y, x)) <= params.half_view and math.hypot(x, y) <= params.reach
    return math.log(1.0 - params.detection) if in_view else 0.0


def _nearest(turn: float, period: float) -> float:
    return (turn + 0.5 * period) % period - 0.5 * period


def _normal_density(x: float, sigma: float) -> float:
    return math.exp(-0.5 * (x / sigma) ** 2) / (sigma * math.sqrt(2.0 * math.pi))


def _rotation3(angle: float) -> NDArray[np.float64]:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def edges_between(topology: TopologicalMap, start: int, end: int) -> float:
    """Least number of edges between two nodes, by their positions; infinite if there is no way."""
    index = {node.id: k for k, node in enumerate(topology.nodes)}
    reached, edges = {start}, 0
    while end not in reached:
        pairs = [(index[edge.start], index[edge.end]) for edge in topology.edges]
        grown = (
            reached | {b for a, b in pairs if a in reached} | {a for a, b in pairs if b in reached}
        )
        if grown == reached:
            return math.inf
        reached, edges = grown, edges + 1
    return edges


History = tuple[int | None, ...]
"""A place for each link, None where what was seen is no node of the map."""


def weigh_chain(
    topology: TopologicalMap, places: list[Place], links: list[Link], params: ChainParams
) -> dict[History, tuple[float, int | None]]:
    """Return the likelihood of each history that is possible, and the node that it ends near."""
    choices: list[int | None] = [None, *range(len(places))]
    fits = [
        [
            fit_place(link.seen, topology.nodes[place.node].features, place.pose, params)
            for place in places
        ]
        for link in links
    ]
    weights = {
        history: _likelihood(history, (topology, places), links, fits, params)
        for history in itertools.product(choices, repeat=len(links))
    }
    return {history: ended for history, ended in weights.items() if ended[0] > 0.0}


def _likelihood(
    history: History,
    world: tuple[TopologicalMap, list[Place]],
    links: list[Link],
    fits: list[list[Fit]],
    params: ChainParams,
) -> tuple[float, int | None]:
    topology, places = world
    at_nodes = sum(place.at_node for place in places)
    along = len(places) - at_nodes
    weight, last, at = 1.0, None, None
    for now, place in enumerate(history):
        if at is not None:
            at = _carried(at, links[now], params)
        if place is None:
            weight *= params.false
            if at is None or last is None:
                weight *= params.off_map
            else:
                last, at = _beside(topology, last, at, links[now].seen, params)
                weight *= math.exp(at.evidence)
            continue
        fit, node = fits[now][place], places[place].node
        weight *= math.exp(fit.evidence)
        if at is None or last is None:
            is_node = places[place].at_node
            beside = params.false * (1.0 - params.off_map) / max(along, 1)
            weight *= (1.0 - params.false) / at_nodes if is_node else beside
        else:
            edges = edges_between(topology, last, node)
            if edges > params.most_missed + 1 or not places[place].at_node:
                return 0.0, None
            weight *= (1.0 - params.false) * params.missed ** abs(edges - 1)
            weight *= _agreement(at, fit, params)
        last, at = node, fit
    return weight, last


def _carried(at: Fit, link: Link, params: ChainParams) -> Fit:
    """Where odometry has taken a pose."""
    x, y, theta = link.moved
    way = math.hypot(x, y)
    lever = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
    sigmas = np.array([params.way_growth, params.way_growth, params.turn_growth]) * way
    spread = lever @ at.covariance @ lever.T + link.covariance + np.diag(sigmas**2)
    back = _rotation3(-theta)
    return Fit(0.0, se2.compose(at.pose, link.moved), back @ spread @ back.T, 0)


def _beside(
    topology: TopologicalMap, start: int, at: Fit, seen: Features, params: ChainParams
) -> tuple[int, Fit]:
    """Fit what is seen at a place that is no node to the nearest node's features."""
    near = [
        k
        for k in range(len(topology.nodes))
        if edges_between(topology, start, k) <= params.most_missed + 1
    ]
    off = [math.hypot(*(topology.nodes[k].pose[:2] - at.pose[:2])) for k in near]
    nearest = near[int(np.argmin(off))]
    x, y, theta = np.diag(at.covariance)
    spread = replace(params, place=math.sqrt((x + y) / 2.0), turn=math.sqrt(theta))
    return nearest, fit_place(seen, topology.nodes[nearest].features, at.pose, spread)


def _agreement(at: Fit, end: Fit, params: ChainParams) -> float:
    """How much likelier it is that odometry leads to a fit than anywhere else."""
    off = se2.between(at.pose, end.pose)
    turn = _rotation3(off[2])
    spread = at.covariance + turn @ end.covariance @ turn.T
    squared = float(off @ np.linalg.solve(spread, off))
    if squared > params.gate:
        return 0.0
    volume = math.sqrt((2.0 * math.pi) ** 3 * float(np.linalg.det(spread)))
    return math.exp(-0.5 * squared) / volume / params.stray_ways
