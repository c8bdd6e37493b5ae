"""Unknown start: the chain of nodes seen so far, searched in the map (Zhuang et al. 2005, 3.2).

A candidate is a node of the map and the way round in which the robot came to it. With each node
that the robot sees, the candidates are followed along the map's edges: a place fits as well as
its features do and as well as odometry agrees with the way to it. Nodes may have been missed, and
what was seen may have been no node of the map at all. The weights are those of the forward
algorithm: what leads to the same place adds up. Several candidates that are left are several.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.topology.features import Features
from pilotage.topology.node_chain_candidates import NOWHERE, Candidates, ChainParams, Link
from pilotage.topology.node_chain_kernels import Arrivals, Model, Seen, weigh_places
from pilotage.topology.node_chain_map import ChainMap
from pilotage.topology.topological_map import TopologicalMap

LOG_TURN_3 = float(1.5 * np.log(2.0 * np.pi))
"""Normalization of a normal density in three dimensions."""


class NodeChain:
    """The nodes seen since the robot knew nothing, and where in the map they may be."""

    def __init__(self, places: ChainMap, params: ChainParams | None = None) -> None:
        self.places = places
        self.params = params or ChainParams()
        self.links: list[Link] = []
        self.candidates = Candidates.unknown()

    @classmethod
    def over(cls, topology: TopologicalMap, params: ChainParams | None = None) -> "NodeChain":
        """Return an empty chain over a map; a ChainMap made once serves many chains."""
        return cls(ChainMap.of(topology), params)

    def add(self, link: Link) -> None:
        """Go on by one node seen."""
        carried = _carried(self.candidates, link, self.params)
        steps = _steps(carried, self.places, self.params)
        fits = _fitted(link.seen, np.unique(steps.places), self.places, self.params)
        arrived = _arrived(carried, steps, fits, self.params)
        strayed = _strayed(carried, link.seen, self.places, self.params)
        self.candidates = _kept(_joined(arrived, strayed), self.params)
        self.links.append(link)

    @property
    def best(self) -> int | None:
        """Index of the likeliest candidate that is somewhere; None if there is none."""
        somewhere = np.flatnonzero(self.candidates.places != NOWHERE)
        return int(somewhere[0]) if len(somewhere) else None

    @property
    def node(self) -> int | None:
        """Id of the likeliest candidate's node, None if there is no candidate."""
        best = self.best
        return None if best is None else int(self.nodes[best])

    @property
    def nodes(self) -> NDArray[np.int64]:
        """Ids (n,) of the candidates' nodes, NOWHERE for none."""
        places = self.candidates.places
        if len(self.places.nodes) == 0:
            return np.full(len(places), NOWHERE)
        return np.where(places == NOWHERE, NOWHERE, self.places.ids[self.places.nodes[places]])

    @property
    def pose(self) -> NDArray[np.float64] | None:
        """Pose (3,) of base_link at the last link by the likeliest candidate, map frame."""
        best = self.best
        return None if best is None else self.candidates.poses[best]

    @property
    def share(self) -> float:
        """Share of the weight that agrees with `pose`, whatever the node."""
        is_same = self._agrees
        return float(self.candidates.shares[is_same].sum())

    @property
    def is_unique(self) -> bool:
        """Say whether one candidate is left: nearly all the weight, and nothing else comes near."""
        best, is_same = self.best, self._agrees
        if best is None or not self.candidates.at_node[best]:
            return False
        others = self.candidates.log_weights[~is_same].max(initial=-np.inf)
        ahead = self.candidates.log_weights[best] - others
        return self.share >= self.params.share and bool(ahead >= np.log(self.params.ratio))

    @property
    def _agrees(self) -> NDArray[np.bool_]:
        """Mask (n,) of the candidates whose pose is that of the likeliest."""
        pose = self.pose
        if pose is None:
            return np.zeros(len(self.candidates), bool)
        off = self.candidates.poses - pose
        metres, radians = self.params.same_place
        is_near: NDArray[np.bool_] = np.hypot(off[:, 0], off[:, 1]) <= metres
        return is_near & (np.abs(wrap(off[:, 2])) <= radians)


@dataclass(frozen=True, eq=False)
class _Steps:
    """Ways (k,) from candidate `parents` to `places`, with the `chances` of each, logarithmic."""

    parents: NDArray[np.int64]
    places: NDArray[np.int64]
    chances: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Fits:
    """What is seen, fitted at `places` (m,), rising: or for candidates, at where they may be.

    With evidence, pose in map, covariance in base_link and number of pairs.
    """

    places: NDArray[np.int64]
    evidence: NDArray[np.float64]
    poses: NDArray[np.float64]
    covariances: NDArray[np.float64]
    pairs: NDArray[np.int64]


def _carried(before: Candidates, link: Link, params: ChainParams) -> Candidates:
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
        before.places,
        np.zeros(len(before), bool),
        se2.compose(before.poses, link.moved),
        back @ spread @ back.T,
        before.log_weights,
        np.arange(len(before)),
        np.zeros(len(before), np.int64),
    )


def _steps(carried: Candidates, places: ChainMap, params: ChainParams) -> _Steps:
    """Return where each candidate may have come: near in the graph, or anywhere from nowhere."""
    known = np.flatnonzero(carried.places != NOWHERE)
    lost = np.flatnonzero(carried.places == NOWHERE)
    count = len(places.nodes)
    reached = places.reached(places.nodes[carried.places[known]], params.most_missed + 1)
    found, of_reached = places.places_of(reached[:, 1])
    # To come to the same node once more is as rare as to miss one.
    missed = np.abs(reached[of_reached, 2] - 1)
    anywhere = np.tile(np.arange(count), len(lost))
    return _Steps(
        np.concatenate([known[reached[of_reached, 0]], np.repeat(lost, count)]),
        np.concatenate([found, anywhere]),
        np.log(1.0 - params.false)
        + np.concatenate(
            [missed * np.log(params.missed), np.full(len(anywhere), -np.log(max(count, 1)))]
        ),
    )


def _fitted(
    seen: Features, which: NDArray[np.int64], places: ChainMap, params: ChainParams
) -> _Fits:
    """Return how well what is seen fits some places, and where exactly the robot is there."""
    spreads = np.tile([params.place, params.turn], (len(which), 1))
    arrivals = Arrivals(places.nodes[which], places.poses[which], spreads)
    return _weighed(seen, which, arrivals, places, params)


def _weighed(
    seen: Features,
    which: NDArray[np.int64],
    arrivals: Arrivals,
    places: ChainMap,
    params: ChainParams,
) -> _Fits:
    near = seen.chosen(np.hypot(seen.poses[:, 0], seen.poses[:, 1]) <= params.seen_within)
    variances = np.trace(near.covariances, axis1=1, axis2=2) / 2.0 + params.blur**2
    about = Seen(near.kinds, near.poses, near.widths, variances)
    evidence, offsets, known, pairs = weigh_places(about, places.bound, arrivals, _model(params))
    information = np.zeros((len(which), 3, 3))
    information[:, [0, 1], [0, 1]] = known[:, :1]
    information[:, 0, 2] = information[:, 2, 0] = known[:, 1]
    information[:, 1, 2] = information[:, 2, 1] = known[:, 2]
    information[:, 2, 2] = known[:, 3]
    covariances = _turned(np.asarray(np.linalg.inv(information), np.float64), -offsets[:, 2])
    return _Fits(which, evidence, se2.compose(arrivals.poses, offsets), covariances, pairs)


def _arrived(carried: Candidates, steps: _Steps, fits: _Fits, params: ChainParams) -> Candidates:
    """Return the candidates at nodes: what leads to the same place adds up."""
    fit = np.searchsorted(fits.places, steps.places)
    agreement = _agreement(carried, steps.parents, fits, fit, params)
    weights = carried.log_weights[steps.parents] + steps.chances + agreement + fits.evidence[fit]
    heaviest_last = np.lexsort((weights, fit))
    heaviest_last = heaviest_last[np.isfinite(weights[heaviest_last])]
    fit, weights = fit[heaviest_last], weights[heaviest_last]
    which, firsts = np.unique(fit, return_index=True)
    lasts = np.append(firsts, len(fit))[1:] - 1
    return Candidates(
        fits.places[which],
        np.ones(len(which), bool),
        fits.poses[which],
        fits.covariances[which],
        np.logaddexp.reduceat(weights, firsts) if len(firsts) else np.empty(0),
        steps.parents[heaviest_last[lasts]],
        fits.pairs[which],
    )


def _agreement(
    carried: Candidates,
    parents: NDArray[np.int64],
    fits: _Fits,
    fit: NDArray[np.int64],
    params: ChainParams,
) -> NDArray[np.float64]:
    """Return what odometry says to each way (k,): a log-likelihood ratio, -inf if impossible."""
    agreement = np.zeros(len(parents))
    known = np.flatnonzero(carried.places[parents] != NOWHERE)
    parents, fit = parents[known], fit[known]
    off = se2.between(carried.poses[parents], fits.poses[fit])
    spread = carried.covariances[parents] + _turned(fits.covariances[fit], off[:, 2])
    # No variance along any axis is larger than the trace: what is too far for that is too far.
    agreement[known] = -np.inf
    reach = params.gate * np.trace(spread, axis1=1, axis2=2)
    near = np.flatnonzero((off**2).sum(axis=1) <= reach)
    off, spread = off[near], spread[near]
    squared = np.einsum("ni,ni->n", off, np.linalg.solve(spread, off[..., None])[..., 0])
    density = -0.5 * squared - 0.5 * np.log(np.linalg.det(spread)) - LOG_TURN_3
    density[squared > params.gate] = -np.inf
    agreement[known[near]] = density - np.log(params.stray_ways)
    return agreement


def _strayed(
    carried: Candidates, seen: Features, places: ChainMap, params: ChainParams
) -> Candidates:
    """Return the candidates for which what was seen is no node of the map.

    Where odometry says that they are, what is about there is known from the nearest node.
    """
    strayed = replace(carried, log_weights=carried.log_weights + np.log(params.false))
    known = np.flatnonzero(carried.places != NOWHERE)
    if len(known) == 0:
        return strayed
    poses, variances = carried.poses[known], carried.covariances[known][:, range(3), range(3)]
    spreads = np.sqrt(np.stack([variances[:, :2].mean(axis=1), variances[:, 2]], axis=1))
    reached = places.reached(places.nodes[carried.places[known]], params.most_missed + 1)
    arrivals = Arrivals(places.nearest(reached, poses), poses, spreads)
    fits = _weighed(seen, known, arrivals, places, params)
    strayed.log_weights[known] += fits.evidence
    strayed.poses[known], strayed.covariances[known] = fits.poses, fits.covariances
    strayed.pairs[known] = fits.pairs
    return strayed


def _joined(one: Candidates, other: Candidates) -> Candidates:
    pairs = [(getattr(one, name), getattr(other, name)) for name in vars(one)]
    return Candidates(*(np.concatenate(pair) for pair in pairs))


def _kept(candidates: Candidates, params: ChainParams) -> Candidates:
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


def _model(params: ChainParams) -> Model:
    return Model(
        params.direction,
        params.width,
        params.detection,
        np.array(params.strays),
        params.reach,
        params.half_view,
    )


def _rotation(angle: float) -> NDArray[np.float64]:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def _turned(covariances: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return covariances (n, 3, 3) of x, y, theta in frames that are turned by angles (n,)."""
    turns = np.tile(np.eye(3), (len(angles), 1, 1))
    cos, sin = np.cos(angles), np.sin(angles)
    turns[:, 0, 0], turns[:, 0, 1], turns[:, 1, 0], turns[:, 1, 1] = cos, -sin, sin, cos
    turned: NDArray[np.float64] = turns @ covariances @ turns.transpose(0, 2, 1)
    return turned
