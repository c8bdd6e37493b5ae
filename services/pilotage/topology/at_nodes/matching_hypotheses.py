"""Pairs of a seen and a bound feature that may be the same, and the poses that they speak for."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.topology.features import Features

Window = tuple[float, float]
"""How far the pose may be from the prior: metres, radians."""

LEAST_BASE = 0.6
"""m between two features below which their places say too little about the heading."""


@dataclass(frozen=True)
class FeaturePairs:
    """Seen and bound features that may be the same.

    `members` (p, 2): indices of the seen and of the bound one. `places` (p, 7): seen x, y and
    direction in base_link, bound x, y and direction in map, and the angle after which the direction
    repeats (an opening is walked through either way). `covariances` (p, 2, 2, 2): of the seen place
    in base_link and of the bound place in map, m^2.
    """

    members: NDArray[np.int64]
    places: NDArray[np.float64]
    covariances: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.members)

    @property
    def variances(self) -> NDArray[np.float64]:
        """Variances (p,) of a pair's distance, m^2, whatever its direction."""
        both: NDArray[np.float64] = self.covariances.sum(axis=1).trace(axis1=1, axis2=2)
        return both

    def turns(self, headings: ArrayLike) -> NDArray[np.float64]:
        """Return the turns (p,) that the pairs lack at headings, () or (p,) rad."""
        period = self.places[:, 6]
        lack = self.places[:, 5] - self.places[:, 2] - np.asarray(headings, float)
        turn: NDArray[np.float64] = (lack + period / 2.0) % period - period / 2.0
        return turn


def possible_pairs(
    seen: Features,
    bound: Features,
    prior: NDArray[np.float64],
    reach: Window,
    width_tolerance: float,
) -> FeaturePairs:
    """Return the pairs of the same sort and width that come together within the window.

    A corner is no opening, but a door and a passage are both one: an open door is a passage.

    Args:
        seen: (n) in base_link.
        bound: (m) in map.
        prior: map_from_base (3,).
        reach: by how much (m, rad) the prior and the features may be wrong together.
        width_tolerance: m by which two views of one opening may differ.
    """
    is_corner_seen, is_corner_bound = seen.kinds == 0, bound.kinds == 0
    fits = is_corner_seen[:, None] == is_corner_bound
    # A width that nobody knows forbids nothing, nor do corners, which have none.
    fits &= ~(np.abs(seen.widths[:, None] - bound.widths) > width_tolerance)
    expected = se2.compose(prior, seen.poses)
    offset = bound.poses[None, :, :2] - expected[:, None, :2]
    from_robot = np.hypot(seen.poses[:, 0], seen.poses[:, 1])
    swing = 2.0 * np.sin(min(reach[1], np.pi) / 2.0) * from_robot
    fits &= np.hypot(offset[..., 0], offset[..., 1]) <= reach[0] + swing[:, None]
    pairs = _paired(seen, bound, np.argwhere(fits))
    turned = np.abs(pairs.turns(prior[2])) <= reach[1]
    return FeaturePairs(pairs.members[turned], pairs.places[turned], pairs.covariances[turned])


def _paired(seen: Features, bound: Features, members: NDArray[np.int64]) -> FeaturePairs:
    i, j = members.T
    period = np.where(seen.kinds[i] == 0, 2.0 * np.pi, np.pi)
    places = np.concatenate([seen.poses[i], bound.poses[j], period[:, None]], axis=1)
    covariances = np.stack([seen.covariances[i], bound.covariances[j]], axis=1)
    return FeaturePairs(members, places, covariances)


def pose_hypotheses(
    pairs: FeaturePairs, prior: NDArray[np.float64], window: Window
) -> NDArray[np.float64]:
    """Return the poses (h, 3) within the window that one pair or two pairs speak for."""
    poses = np.concatenate([_from_one(pairs, prior), _from_two(pairs)])
    off = poses - prior
    is_near = (np.hypot(off[:, 0], off[:, 1]) <= window[0]) & (np.abs(wrap(off[:, 2])) <= window[1])
    return _without_repeats(poses[is_near])


def _from_one(pairs: FeaturePairs, prior: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the poses (p, 3) that bring each pair together, place and direction."""
    headings = prior[2] + pairs.turns(prior[2])
    return _poses(pairs.places[:, :2], pairs.places[:, 3:5], headings)


def _from_two(pairs: FeaturePairs) -> NDArray[np.float64]:
    """Return the poses (h, 3) that bring the places of two pairs together."""
    a, b = np.triu_indices(len(pairs), 1)
    base_seen = pairs.places[b, :2] - pairs.places[a, :2]
    base_bound = pairs.places[b, 3:5] - pairs.places[a, 3:5]
    length_seen, length_bound = np.hypot(*base_seen.T), np.hypot(*base_bound.T)
    spread = 3.0 * np.sqrt(pairs.variances[a] + pairs.variances[b])
    fits = (pairs.members[a] != pairs.members[b]).all(axis=1)
    fits &= np.minimum(length_seen, length_bound) > LEAST_BASE
    fits &= np.abs(length_seen - length_bound) < spread
    a, b, base_seen, base_bound = a[fits], b[fits], base_seen[fits], base_bound[fits]
    headings = np.arctan2(base_bound[:, 1], base_bound[:, 0])
    headings -= np.arctan2(base_seen[:, 1], base_seen[:, 0])
    middle = (pairs.places[a] + pairs.places[b]) / 2.0
    return _poses(middle[:, :2], middle[:, 3:5], headings)


def _poses(
    seen: NDArray[np.float64], bound: NDArray[np.float64], headings: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the poses (k, 3) at these headings that take points seen (k, 2) to points bound."""
    cos, sin = np.cos(headings), np.sin(headings)
    x = bound[:, 0] - cos * seen[:, 0] + sin * seen[:, 1]
    y = bound[:, 1] - sin * seen[:, 0] - cos * seen[:, 1]
    return np.stack([x, y, wrap(headings)], axis=1)


def _without_repeats(poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return one pose of those that differ by less than 5 cm and 1 degree: they vote alike."""
    _, first = np.unique(np.round(poses / [0.05, 0.05, 0.02]), axis=0, return_index=True)
    return poses[np.sort(first)]
