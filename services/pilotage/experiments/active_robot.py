"""The robot of Liu et al. 2008, section 3.1: how it walks, and what its camera recognises; pure.

Chances are drawn by step, not by policy: whatever a robot does at step 7 of a run, its noise is
drawn from the same random numbers, so that policies are compared under the same luck.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.planner.landmark_localization import Move, predicted
from pilotage.planner.landmark_views import Camera, views_from
from pilotage.planner.potential_field import Sources, is_within
from pilotage.planner.situation import Hypotheses

Array = NDArray[np.float64]
MOTION_ERROR = 0.1
"""Standard deviation of a displacement, ahead and aside, as a share of it."""


@dataclass(frozen=True)
class Luck:
    """One step's chances: of the walk (2,), and of each of n landmarks seen (n, 3).

    Columns of `sight`: normal errors of range and bearing, and a uniform number that says
    whether the landmark is recognised.
    """

    walk: Array
    sight: Array


def luck_of(rng: np.random.Generator, landmarks: int) -> Luck:
    """Draw the chances of a step."""
    sight = rng.standard_normal((landmarks, 3))
    sight[:, 2] = rng.random(landmarks)
    return Luck(rng.standard_normal(2), sight)


def walked(pose: Array, move: Move, luck: Luck) -> Array:
    """Return the pose (3,) after a move."""
    start = Hypotheses(pose[None], np.ones(1))
    after: Array = predicted(start, move, MOTION_ERROR * luck.walk[None]).poses[0]
    return after


def recognised_landmarks(
    sources: Sources, pose: Array, gaze: float, camera: Camera, luck: Luck
) -> tuple[NDArray[np.int64], Array]:
    """Return what the camera recognises when pointed to `gaze` off the heading.

    Returns:
        Kinds (s,), and values (s, 2): range [m] and bearing off the robot's heading [rad].
    """
    views = views_from(sources, pose[None])
    ranges, bearings, shares = views.ranges[0], views.bearings[0], views.shares[0]
    is_seen = [is_within(bearing, gaze, camera.half_view) for bearing in bearings]
    chosen = np.array(is_seen, bool) & (luck.sight[:, 2] < shares)
    measured = np.maximum(ranges * (1.0 + camera.range_error * luck.sight[:, 0]), 1e-3)
    turned = bearings + camera.bearing_error * luck.sight[:, 1]
    return sources.kinds[chosen], np.column_stack([measured, turned])[chosen]
