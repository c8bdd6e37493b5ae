"""What is believed of places: by themselves, and by the belief over states that holds them.

States are the heaviest of the belief: poses (n, 3) and their shares (n,) of it.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.localizer.modes import LEAST_MASS, MOST_MODES, Mode, is_within
from pilotage.localizer.obstacles import Obstacles
from pilotage.localizer.places import Places
from pilotage.localizer.precision import fitted_covariance

States = tuple[NDArray[np.float64], NDArray[np.float64]]

MOST_WEIGHED = 40
"""Places that are held against the belief."""

BELIEF_COUNTS, LEAST_BELIEF = 0.5, 1e-3
"""Power of the belief's mass at a place in the place's probability, and the least mass."""


def with_belief(places: Places, states: States) -> Places:
    """Return the likeliest places by what both the places and the belief say of them.

    The belief sees less of a scan but forgets no state; it counts by a power of its mass there.
    """
    poses, weights = states
    likely = places.chosen(np.arange(min(MOST_WEIGHED, len(places))))
    mass = np.array([weights[is_within(poses, pose)].sum() for pose in likely.poses])
    share = likely.log_share + BELIEF_COUNTS * np.log(np.maximum(mass, LEAST_BELIEF))
    order = np.argsort(-share, kind="stable")
    fused = likely.chosen(order)
    share = share[order] - share.max()
    fused.log_share = share - np.log(np.exp(share).sum())
    return fused


def modes_of(
    places: Places, states: States, ends: NDArray[np.float64], around: Obstacles
) -> list[Mode]:
    """Return the places as modes, near ones together, by falling mass.

    `ends` (m, 2) of a scan's beams in base_link say how exactly each is known.
    """
    share = np.exp(places.log_share)
    left = share >= LEAST_MASS
    left[0] = True
    modes: list[Mode] = []
    for index in np.argsort(-share, kind="stable"):
        if not left[index] or len(modes) == MOST_MODES:
            continue
        pose = places.poses[index]
        same = left & is_within(places.poses, pose)
        left &= ~same
        covariance = fitted_covariance(pose, ends, around, _spread_about(pose, states))
        modes.append(Mode(float(share[same].sum()), pose, covariance))
    return sorted(modes, key=lambda mode: -mode.mass)


def _spread_about(pose: NDArray[np.float64], states: States) -> NDArray[np.float64]:
    """Return the covariance (3, 3) of the belief about a place; wide where it holds nothing."""
    poses, weights = states
    near = is_within(poses, pose)
    if not near.any():
        return np.diag([0.25, 0.25, 0.07]) ** 2
    away = poses[near] - pose
    away[:, 2] = wrap(away[:, 2])
    share = weights[near] / weights[near].sum()
    width = np.diag([0.03, 0.03, 0.025]) ** 2
    covariance: NDArray[np.float64] = (away * share[:, None]).T @ away + width
    return covariance
