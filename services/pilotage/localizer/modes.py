"""The places the robot could be: clusters of the heaviest states of a belief."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import circular_mean, difference, wrap

MODE_RADIUS = 0.5
"""States within this distance [m] of a mode's centre are the same place ..."""

MODE_TURN = np.deg2rad(15.0)
"""... if their headings differ by no more than this. The same limits define `confidence`."""

LEAST_MASS = 1e-3
"""Lighter places are not listed; a place this light may still be the right one (see `verdict`)."""

MOST_MODES = 12


@dataclass(frozen=True)
class Mode:
    """A place: `mass` of the belief in it, mean `pose` (3,) and covariance (3, 3), map frame."""

    mass: float
    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]


def find_modes(poses: NDArray[np.float64], weights: NDArray[np.float64]) -> list[Mode]:
    """Return the modes among states (n, 3) with weights (n,), by falling mass.

    Greedy: the heaviest state that is left gathers its surroundings, whose mean gathers its own;
    what has been gathered belongs to no other mode.
    """
    left = np.ones(len(weights), bool)
    modes: list[Mode] = []
    while left.any() and len(modes) < MOST_MODES:
        peak = int(np.argmax(np.where(left, weights, -1.0)))
        members = left & is_within(poses, poses[peak])
        members = left & is_within(poses, _mean(poses[members], weights[members]))
        members[peak] = True
        left &= ~members
        modes.append(_mode_of(poses[members], weights[members]))
    substantial = [mode for mode in modes if mode.mass >= LEAST_MASS] or modes[:1]
    return sorted(substantial, key=lambda mode: -mode.mass)


def find_modes_in_bins(
    poses: NDArray[np.float64], weights: NDArray[np.float64], bins: tuple[float, float]
) -> list[Mode]:
    """Return the modes among bins so wide [m] and so many radians: none is known any better.

    A pose anywhere in a bin of width w alike has the variance w^2 / 12.
    """
    width = np.diag([bins[0], bins[0], bins[1]]) ** 2 / 12.0
    found = find_modes(poses, weights)
    return [replace(mode, covariance=mode.covariance + width) for mode in found]


def is_within(
    poses: NDArray[np.float64], centre: NDArray[np.float64], scale: float = 1.0
) -> NDArray[np.bool_]:
    """Say of poses (n, 3) whether they lie in the same place as `centre` (3,)."""
    away = np.hypot(poses[:, 0] - centre[0], poses[:, 1] - centre[1])
    turn = np.abs(wrap(poses[:, 2] - centre[2]))
    near: NDArray[np.bool_] = (away <= scale * MODE_RADIUS) & (turn <= scale * MODE_TURN)
    return near


def _mode_of(poses: NDArray[np.float64], weights: NDArray[np.float64]) -> Mode:
    mean = _mean(poses, weights)
    away = poses - mean
    away[:, 2] = wrap(away[:, 2])
    share = weights / weights.sum()
    return Mode(float(weights.sum()), mean, (away * share[:, None]).T @ away)


def _mean(poses: NDArray[np.float64], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    share = weights / weights.sum()
    return np.array([*(share @ poses[:, :2]), circular_mean(poses[:, 2], share)])


def apart(one: NDArray[np.float64], other: NDArray[np.float64]) -> tuple[float, float]:
    """Return the distance [m] and the turn [rad, not negative] between two poses (3,)."""
    turn = abs(difference(float(one[2]), float(other[2])))
    return float(np.hypot(one[0] - other[0], one[1] - other[1])), turn
