"""Where the robot is, by the constellation of features that a node is bound to.

What is seen (corners, doors, passages) is laid over what the node is bound to: pairs that may be
the same speak for poses, all pairs vote on them, the best are settled by weighted least squares
and compared. Sets are small, so nothing is left to chance. A second pose, far from the first,
that explains nearly as much makes the answer ambiguous (Zhuang et al. 2005, section 3.2; voting:
Neira & Tardos 2001 name the same test joint compatibility).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.angles import wrap
from pilotage.topology.at_nodes.matching_hypotheses import (
    FeaturePairs,
    Window,
    pose_hypotheses,
    possible_pairs,
)
from pilotage.topology.at_nodes.matching_kernels import count_votes, settle
from pilotage.topology.features import Features


@dataclass(frozen=True)
class MatchParams:
    """How alike a seen and a bound feature must be, and when a match is clear."""

    width_tolerance: float = 0.35
    """m between two views of one opening; jambs are hidden by frames and leaves."""
    direction_sigma: float = 0.07
    """rad between the directions of one feature in two views, over and above the window."""
    place_sigma: float = 0.03
    """m that a map's cells and thick frames add to every place."""
    shared: Window = (0.03, 0.015)
    """m and rad of errors that all features share, which no number of pairs averages out."""
    gate: float = 11.3
    """Squared Mahalanobis distance that 99 % of true pairs stay below (chi2, three degrees)."""
    reach: float = 6.0
    """m up to which a bound feature ought to be seen again."""
    half_view: float = 1.57
    """rad to both sides of ahead that the laser sees for certain: half of 180 degrees."""
    miss_cost: float = 0.15
    """Of a feature that ought to have been seen; small, because people and leaves hide them."""
    apart: Window = (0.3, 0.17)
    """m or rad that make two poses distinctly different."""
    least_lead: float = 0.8
    """By how many pairs the best pose must lead to be clear."""
    best_share: float = 0.8
    """What share of its score a rival may not reach, however many pairs there are."""
    kept: int = 12
    """Poses that are settled after the vote."""


@dataclass(frozen=True)
class NodeMatch:
    """The best pose of base_link in map.

    `covariance` (3, 3) of m, m, rad. `pairs` (k, 2): indices of the seen and the bound features.
    `score`: pairs, each worth between a half and one by how well it fits, less what should have
    been seen; `rival_score` the same of the best pose that is distinctly different, 0 without one.
    """

    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]
    pairs: NDArray[np.int64]
    score: float
    rival_score: float
    is_clear: bool


@dataclass(frozen=True)
class _Settled:
    pose: NDArray[np.float64]
    information: NDArray[np.float64]
    pairs: NDArray[np.int64]
    score: float


def match_features(
    seen: Features,
    bound: Features,
    map_from_base: ArrayLike,
    window: Window,
    params: MatchParams = MatchParams(),
) -> NodeMatch | None:
    """Return the pose within `window` (m, rad) of the prior that the features speak for.

    Args:
        seen: in base_link.
        bound: in map.
        map_from_base: prior (3,).
        window: by how much the prior may be wrong.
        params: what counts as alike and as clear.

    Returns:
        None where no seen feature may be a bound one.
    """
    prior = np.asarray(map_from_base, float)
    slack = (window[0] + 0.3, window[1] + 3.0 * params.direction_sigma)
    pairs = _with_floor(
        possible_pairs(seen, bound, prior, slack, params.width_tolerance), params.place_sigma
    )
    poses = pose_hypotheses(pairs, prior, window)
    if len(poses) == 0:
        return None
    counts = (len(seen), len(bound))
    best = _best_voted(poses, pairs, counts, params)
    settled = [_settle(pose, pairs, bound, counts, params) for pose in best]
    return _compared(_inside(settled, prior, window), params)


def _with_floor(pairs: FeaturePairs, sigma: float) -> FeaturePairs:
    covariances = pairs.covariances.copy()
    covariances[:, 1] += sigma**2 * np.eye(2)
    return FeaturePairs(pairs.members, pairs.places, covariances)


def _best_voted(
    poses: NDArray[np.float64], pairs: FeaturePairs, counts: tuple[int, int], params: MatchParams
) -> NDArray[np.float64]:
    """Return the poses (k, 3) with most votes, each distinctly different from those before."""
    # A pose made of two pairs errs by both; what is far from them errs by more.
    lever = np.hypot(pairs.places[:, 0], pairs.places[:, 1]) * params.direction_sigma
    distance = 9.0 * (pairs.variances + 0.25 * lever**2)
    turn = np.full(len(pairs), 9.0 * 2.0 * params.direction_sigma**2)
    spreads = np.stack([distance, turn], axis=1)
    votes = count_votes(poses, pairs.places, spreads, pairs.members, counts)
    return _apart(poses[np.argsort(-votes, kind="stable")], params.apart, params.kept)


def _apart(poses: NDArray[np.float64], apart: Window, count: int) -> NDArray[np.float64]:
    kept: list[NDArray[np.float64]] = []
    left = poses
    while len(left) and len(kept) < count:
        kept.append(left[0])
        # Half as far: two that would settle on different pairs shall both have their chance.
        left = left[_differ(left, left[0], (apart[0] / 2.0, apart[1] / 2.0))]
    return np.array(kept)


def _differ(
    poses: NDArray[np.float64], pose: NDArray[np.float64], apart: Window
) -> NDArray[np.bool_]:
    off = poses - pose
    differs: NDArray[np.bool_] = np.hypot(off[..., 0], off[..., 1]) > apart[0]
    return differs | (np.abs(wrap(off[..., 2])) > apart[1])


def _settle(
    pose: NDArray[np.float64],
    pairs: FeaturePairs,
    bound: Features,
    counts: tuple[int, int],
    params: MatchParams,
) -> _Settled | None:
    all_of_them = (pairs.places, pairs.covariances, pairs.members)
    settled, information, chosen, distances = settle(
        pose, all_of_them, counts, params.direction_sigma**2, (4.0 * params.gate, params.gate)
    )
    if not chosen.any():
        return None
    members = pairs.members[chosen]
    worth = float((1.0 - 0.5 * distances[chosen] / params.gate).sum())
    is_missed = expected_in_sight(bound, settled, params)
    is_missed[members[:, 1]] = False
    return _Settled(
        settled, information, members, worth - params.miss_cost * float(is_missed.sum())
    )


def expected_in_sight(
    bound: Features, map_from_base: NDArray[np.float64], params: MatchParams
) -> NDArray[np.bool_]:
    """Say which of the features (n) in map ought to be seen from a pose (3,) of base_link."""
    offset = bound.poses[:, :2] - map_from_base[:2]
    bearing = wrap(np.arctan2(offset[:, 1], offset[:, 0]) - map_from_base[2])
    distance = np.hypot(offset[:, 0], offset[:, 1])
    in_sight: NDArray[np.bool_] = (distance < params.reach) & (np.abs(bearing) < params.half_view)
    # A corner shows both its walls only to those who stand before it.
    to_robot = np.arctan2(-offset[:, 1], -offset[:, 0])
    faces = np.abs(wrap(to_robot - bound.poses[:, 2])) < np.pi / 4.0
    expected: NDArray[np.bool_] = in_sight & (faces | (bound.kinds != 0))
    return expected


def _inside(
    settled: list[_Settled | None], prior: NDArray[np.float64], window: Window
) -> list[_Settled]:
    """Return what settled near the window, best first."""
    wider = (1.2 * window[0] + 0.1, 1.2 * window[1] + 0.05)
    inside = [s for s in settled if s is not None and not _differ(s.pose, prior, wider)]
    return sorted(inside, key=lambda s: -s.score)


def _compared(settled: list[_Settled], params: MatchParams) -> NodeMatch | None:
    if not settled:
        return None
    best = settled[0]
    rivals = [s.score for s in settled[1:] if _differ(s.pose, best.pose, params.apart)]
    rival = max([0.0, *rivals])
    is_clear = best.score - rival >= params.least_lead and rival <= params.best_share * best.score
    shared = np.diag([params.shared[0], params.shared[0], params.shared[1]]) ** 2
    covariance = np.asarray(np.linalg.inv(best.information) + shared, np.float64)
    return NodeMatch(best.pose, covariance, best.pairs, best.score, rival, is_clear)
