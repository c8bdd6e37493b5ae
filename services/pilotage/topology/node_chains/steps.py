"""From one node of a chain to the next: where candidates may come, and what speaks for each."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.topology.features import Features
from pilotage.topology.node_chains.candidates import (
    NOWHERE,
    Candidates,
    ChainParams,
    Link,
)
from pilotage.topology.node_chains.fits import Fits, fitted_near, turned
from pilotage.topology.node_chains.kernels import Arrivals
from pilotage.topology.node_chains.map import ChainMap

LOG_TURN_3 = float(1.5 * np.log(2.0 * np.pi))
"""Normalization of a normal density in three dimensions."""


@dataclass(frozen=True, eq=False)
class Ways:
    """Ways (k,) from candidate `parents` to `places`, with the `chances` of each, logarithmic."""

    parents: NDArray[np.int64]
    places: NDArray[np.int64]
    chances: NDArray[np.float64]


def carried_on(before: Candidates, link: Link, params: ChainParams) -> Candidates:
    """Return the candidates where odometry has taken them."""
    x, y, theta = link.moved
    back = np.eye(3)
    back[:2, :2] = _rotation(-theta)
    lever = np.eye(3)
    lever[:2, 2] = -y, x
    way = np.hypot(x, y)
    grown = np.diag([params.way_growth * way, params.way_growth * way, params.turn_growth * way])
    spread = lever @ before.covariances @ lever.T + link.covariance + grown**2
    return Candidates(
        before.places.copy(),
        np.zeros(len(before), bool),
        se2.compose(before.poses, link.moved),
        back @ spread @ back.T,
        before.log_weights,
        np.arange(len(before)),
        np.zeros(len(before), np.int64),
        before.explained.copy(),
    )


def ways_on(carried: Candidates, places: ChainMap, params: ChainParams) -> Ways:
    """Return where each candidate may have come: near in the graph, or anywhere from nowhere."""
    known = np.flatnonzero(carried.places != NOWHERE)
    lost = np.flatnonzero(carried.places == NOWHERE)
    anywhere = np.arange(len(places.nodes))
    reached = places.reached(places.nodes[carried.places[known]], params.most_missed + 1)
    found, of_reached = places.places_of(reached[:, 1])
    # To come to the same node once more is as rare as to miss one.
    missed = np.abs(reached[of_reached, 2] - 1)
    return Ways(
        np.concatenate([known[reached[of_reached, 0]], np.repeat(lost, len(anywhere))]),
        np.concatenate([found, np.tile(anywhere, len(lost))]),
        np.concatenate(
            [
                np.log(1.0 - params.false) + missed * np.log(params.missed),
                np.tile(_chances_anywhere(places, params), len(lost)),
            ]
        ),
    )


def _chances_anywhere(places: ChainMap, params: ChainParams) -> NDArray[np.float64]:
    """Return how likely each place (m,) is to who knows nothing, logarithmic."""
    at_nodes = int(np.count_nonzero(places.at_node))
    along = len(places.at_node) - at_nodes
    chances: NDArray[np.float64] = np.where(
        places.at_node,
        (1.0 - params.false) / max(at_nodes, 1),
        params.false * (1.0 - params.off_map) / max(along, 1),
    )
    return np.log(chances)


def arrived_by(
    ways: Ways, carried: Candidates, fits: Fits, at_node: NDArray[np.bool_], params: ChainParams
) -> Candidates:
    """Return the candidates at places: what leads to the same one adds up.

    `at_node`: which places are nodes.
    """
    fit = np.searchsorted(fits.places, ways.places)
    agreement = _agreement(carried, ways.parents, fits, fit, params)
    weights = carried.log_weights[ways.parents] + ways.chances + agreement + fits.evidence[fit]
    heaviest_last = np.lexsort((weights, fit))
    heaviest_last = heaviest_last[np.isfinite(weights[heaviest_last])]
    fit, weights = fit[heaviest_last], weights[heaviest_last]
    which, firsts = np.unique(fit, return_index=True)
    lasts = np.append(firsts, len(fit))[1:] - 1
    parents = ways.parents[heaviest_last[lasts]]
    return Candidates(
        fits.places[which],
        at_node[fits.places[which]],
        fits.poses[which],
        fits.covariances[which],
        np.logaddexp.reduceat(weights, firsts) if len(firsts) else np.empty(0),
        parents,
        fits.pairs[which],
        carried.explained[parents] + fits.pairs[which],
    )


def _agreement(
    carried: Candidates,
    parents: NDArray[np.int64],
    fits: Fits,
    fit: NDArray[np.int64],
    params: ChainParams,
) -> NDArray[np.float64]:
    """Return what odometry says to each way (k,): a log-likelihood ratio, -inf if impossible."""
    agreement = np.zeros(len(parents))
    known = np.flatnonzero(carried.places[parents] != NOWHERE)
    parents, fit = parents[known], fit[known]
    off = se2.between(carried.poses[parents], fits.poses[fit])
    # No variance along any axis is larger than the trace, and no frame changes the trace: what is
    # too far for that is too far.
    trace = np.trace(carried.covariances, axis1=1, axis2=2)[parents]
    trace += np.trace(fits.covariances, axis1=1, axis2=2)[fit]
    near = np.flatnonzero((off**2).sum(axis=1) <= params.gate * trace)
    off, parents, fit = off[near], parents[near], fit[near]
    spread = carried.covariances[parents] + turned(fits.covariances[fit], off[:, 2])
    squared = np.einsum("ni,ni->n", off, np.linalg.solve(spread, off[..., None])[..., 0])
    density = -0.5 * squared - 0.5 * np.log(np.linalg.det(spread)) - LOG_TURN_3
    density[squared > params.gate] = -np.inf
    agreement[known] = -np.inf
    agreement[known[near]] = density - np.log(params.stray_ways)
    return agreement


def strayed_to(
    seen: Features, carried: Candidates, places: ChainMap, params: ChainParams
) -> Candidates:
    """Return the candidates for which what was seen is no node of the map.

    Where odometry says that they are, what is about there is known from the nearest node.
    """
    is_known = carried.places != NOWHERE
    chance = np.where(is_known, params.false, params.false * params.off_map)
    strayed = replace(carried, log_weights=carried.log_weights + np.log(chance))
    known = np.flatnonzero(is_known)
    if len(known) == 0:
        return strayed
    poses, variances = carried.poses[known], carried.covariances[known][:, range(3), range(3)]
    spreads = np.sqrt(np.stack([variances[:, :2].mean(axis=1), variances[:, 2]], axis=1))
    reached = places.reached(places.nodes[carried.places[known]], params.most_missed + 1)
    nearest = places.nearest(reached, poses)
    arrivals = Arrivals(places.nodes[nearest], poses, spreads)
    fits = fitted_near(seen, known, arrivals, places, params)
    strayed.log_weights[known] += fits.evidence
    strayed.poses[known], strayed.covariances[known] = fits.poses, fits.covariances
    strayed.places[known], strayed.pairs[known] = nearest, fits.pairs
    strayed.explained[known] += fits.pairs
    return strayed


def joined(one: Candidates, other: Candidates) -> Candidates:
    """Return the candidates of both."""
    pairs = [(getattr(one, name), getattr(other, name)) for name in vars(one)]
    return Candidates(*(np.concatenate(pair) for pair in pairs))


def kept_of(candidates: Candidates, params: ChainParams) -> Candidates:
    """Return the candidates that are not given up, normalized, the heaviest first.

    What weighs the same is ordered by its pose, so that the numbers of nodes decide nothing.
    """
    heaviest = candidates.log_weights.max()
    kept = candidates.chosen(candidates.log_weights >= heaviest - params.prune)
    weights = kept.log_weights - np.logaddexp.reduce(kept.log_weights)
    x, y, theta = np.round(kept.poses, 9).T
    order = np.lexsort((theta, y, x, -np.round(weights, 9)))
    kept.log_weights[:] = weights
    return kept.chosen(order)


def _rotation(angle: float) -> NDArray[np.float64]:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])
