"""How good a trajectory is: against measured relations of poses, and against reference poses.

Trajectories are stamps (n,) in s, ascending, and poses (n, 3) of base_link.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap

Array = NDArray[np.float64]
Trajectory = tuple[Array, Array]

LARGEST_GAP = 5.0
"""Poses [s] farther apart than this do not say where the robot was in between."""


@dataclass(frozen=True, eq=False)
class Relations:
    """Where the robot was at `second` (n,) s, seen from where it was at `first`: (n, 3)."""

    first: Array
    second: Array
    poses: Array


@dataclass(frozen=True, eq=False)
class RelationErrors:
    """Lengths (m,) in m and turns (m,) in rad of what is left, and how many had no pose."""

    translation: Array
    rotation: Array
    missing: int


def read_tum(file: Path) -> Trajectory:
    """Return the trajectory in lines `stamp x y z qx qy qz qw`, flat on the ground."""
    table = np.atleast_2d(np.loadtxt(file))
    theta = 2.0 * np.arctan2(table[:, 6], table[:, 7])
    return table[:, 0], np.column_stack([table[:, 1:3], wrap(theta)])


def read_relations(file: Path) -> Relations:
    """Return the lines `t1 t2 x y z roll pitch yaw` of the SLAM benchmark of Freiburg."""
    table = np.atleast_2d(np.loadtxt(file))
    return Relations(table[:, 0], table[:, 1], table[:, [2, 3, 7]])


def read_reference(file: Path) -> Trajectory:
    """Return the lines `stamp x y theta` of a reference."""
    table = np.atleast_2d(np.loadtxt(file))
    return table[:, 0], table[:, 1:4]


def poses_at(trajectory: Trajectory, stamps: Array, largest_gap: float = LARGEST_GAP) -> Array:
    """Return poses (n, 3) between their neighbours; NaN where those are missing or far in time."""
    times, poses = trajectory
    after = np.clip(np.searchsorted(times, stamps), 1, len(times) - 1)
    gap = times[after] - times[after - 1]
    share = (stamps - times[after - 1]) / np.where(gap > 0.0, gap, 1.0)
    step = poses[after] - poses[after - 1]
    step[:, 2] = wrap(step[:, 2])
    found = poses[after - 1] + share[:, None] * step
    found[:, 2] = wrap(found[:, 2])
    # A hair's breadth outside is rounding of the stamps in a file.
    slack = 1e-3
    is_known = (stamps > times[0] - slack) & (stamps < times[-1] + slack)
    found[~is_known | ((gap > largest_gap) & (share * (1 - share) * gap > slack))] = np.nan
    return found


def relation_errors(trajectory: Trajectory, relations: Relations) -> RelationErrors:
    """Compare each relation with the same two poses of a trajectory (Kuemmerle et al. 2009)."""
    first = poses_at(trajectory, relations.first)
    second = poses_at(trajectory, relations.second)
    left = se2.between(relations.poses, se2.between(first, second))
    left = left[np.isfinite(left).all(axis=1)]
    return RelationErrors(
        np.hypot(left[:, 0], left[:, 1]), np.abs(left[:, 2]), len(relations.first) - len(left)
    )


def alignment(points: Array, onto: Array) -> Array:
    """Return the pose (3,) that takes points (n, 2) nearest to others, by least squares."""
    middle, goal = points.mean(axis=0), onto.mean(axis=0)
    a, b = points - middle, onto - goal
    turn = math.atan2(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(np.sum(a * b)))
    turned = se2.transform_points((0.0, 0.0, turn), middle[None, :])[0]
    return np.array([*(goal - turned), turn])


def distances_to_reference(trajectory: Trajectory, reference: Trajectory) -> Array:
    """Return how far (m,) in m each reference pose lies from the trajectory laid over them all.

    Reference poses from a time that the trajectory does not cover are left out.
    """
    stamps, goal = reference
    poses = poses_at(trajectory, stamps)
    is_known = np.isfinite(poses).all(axis=1)
    found, wanted = poses[is_known, :2], goal[is_known, :2]
    laid = se2.transform_points(alignment(found, wanted), found)
    distances: Array = np.linalg.norm(laid - wanted, axis=1)
    return distances


def relations_of(reference: Trajectory, apart: int) -> Relations:
    """Return the relations of reference poses that are `apart` poses from each other."""
    stamps, poses = reference
    return Relations(stamps[:-apart], stamps[apart:], se2.between(poses[:-apart], poses[apart:]))
