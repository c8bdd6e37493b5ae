"""What is seen at a node, fitted at each place where the robot may be."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.topology.features import Features
from pilotage.topology.node_chains.candidates import ChainParams
from pilotage.topology.node_chains.kernels import Arrivals, weigh_places
from pilotage.topology.node_chains.map import ChainMap
from pilotage.topology.node_chains.pairs import Model, Seen


@dataclass(frozen=True, eq=False)
class Fits:
    """What is seen, fitted at `places` (m,), rising: or for candidates, at where they may be.

    With evidence, pose in map, covariance in base_link and number of pairs.
    """

    places: NDArray[np.int64]
    evidence: NDArray[np.float64]
    poses: NDArray[np.float64]
    covariances: NDArray[np.float64]
    pairs: NDArray[np.int64]


def within(seen: Features, reach: float) -> Features:
    """Return the features within so many metres of the robot."""
    return seen.chosen(np.hypot(seen.poses[:, 0], seen.poses[:, 1]) <= reach)


def fitted(seen: Features, which: NDArray[np.int64], places: ChainMap, params: ChainParams) -> Fits:
    """Return how well what is seen fits some places, and where exactly the robot is there."""
    spreads = np.tile([params.place, params.turn], (len(which), 1))
    arrivals = Arrivals(places.nodes[which], places.poses[which], spreads)
    return fitted_near(seen, which, arrivals, places, params)


def fitted_near(
    seen: Features,
    which: NDArray[np.int64],
    arrivals: Arrivals,
    places: ChainMap,
    params: ChainParams,
) -> Fits:
    """Return how well what is seen fits arrivals, those of `which`, rising (m,)."""
    near = within(seen, params.seen_within)
    variances = np.trace(near.covariances, axis1=1, axis2=2) / 2.0 + params.blur**2
    about = Seen(near.kinds, near.poses, near.widths, variances)
    evidence, offsets, known, pairs = weigh_places(about, places.bound, arrivals, _model(params))
    information = np.zeros((len(which), 3, 3))
    information[:, [0, 1], [0, 1]] = known[:, :1]
    information[:, 0, 2] = information[:, 2, 0] = known[:, 1]
    information[:, 1, 2] = information[:, 2, 1] = known[:, 2]
    information[:, 2, 2] = known[:, 3]
    covariances = turned(np.asarray(np.linalg.inv(information), np.float64), -offsets[:, 2])
    return Fits(which, evidence, se2.compose(arrivals.poses, offsets), covariances, pairs)


def _model(params: ChainParams) -> Model:
    return Model(
        params.direction,
        params.width,
        params.detection,
        np.array(params.strays),
        params.reach,
        params.half_view,
    )


def turned(covariances: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return covariances (n, 3, 3) of x, y, theta in frames that are turned by angles (n,)."""
    turns = np.tile(np.eye(3), (len(angles), 1, 1))
    cos, sin = np.cos(angles), np.sin(angles)
    turns[:, 0, 0], turns[:, 0, 1], turns[:, 1, 0], turns[:, 1, 1] = cos, -sin, sin, cos
    turned: NDArray[np.float64] = turns @ covariances @ turns.transpose(0, 2, 1)
    return turned
