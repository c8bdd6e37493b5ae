"""What is left of an estimate while nothing is seen: odometry moves it on, and it gets less sure.

The pose's covariance grows by odometry's noise; a heading that is not known makes the way sideways
uncertain. Confidence, the probability of being within the limits of a place (see `modes`), falls
as the probability of a normal distribution with that covariance does.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.measurement import Measurement
from pilotage.localizer.modes import MODE_RADIUS, MODE_TURN, Mode
from pilotage.localizer.motion_spread import MotionSpread

STRIPS = 200
"""Strips that a place is cut into for its probability."""

LEAST_VARIANCE = 1e-12
"""[m^2], [rad^2]: what is known more exactly is as good as certain."""


def says_nothing(seen: Measurement) -> bool:
    """Say whether a measurement tells nothing of where the robot is.

    A compass keeps the heading but no place; a laser of which nothing came back may be covered.
    """
    beams = seen.beams
    is_blind = beams is None or not np.isfinite(beams.ranges).any()
    return is_blind and seen.ranges is None and seen.landmarks is None


def reckoned(before: Estimate, increment: NDArray[np.float64], spread: MotionSpread) -> Estimate:
    """Return an estimate moved on by odometry's `increment` (3,) alone; its state is as it was."""
    covariance = grown(before.pose, before.covariance, increment, spread)
    left = within_limits(covariance) / max(within_limits(before.covariance), np.finfo(float).tiny)
    modes = [
        Mode(
            mode.mass,
            se2.compose(mode.pose, increment),
            grown(mode.pose, mode.covariance, increment, spread),
        )
        for mode in before.modes
    ]
    return replace(
        before,
        pose=se2.compose(before.pose, increment),
        covariance=covariance,
        confidence=before.confidence * min(1.0, left),
        modes=modes,
        matched=None,
        signs=None,
    )


def grown(
    pose: NDArray[np.float64],
    covariance: NDArray[np.float64],
    increment: NDArray[np.float64],
    spread: MotionSpread,
) -> NDArray[np.float64]:
    """Return the covariance (3, 3), map frame, of a pose (3,) moved by an increment (3,)."""
    x, y = (se2.compose(pose, increment) - pose)[:2]
    turned = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
    way, turn = float(np.hypot(x, y)), abs(float(increment[2]))
    along, around = spread.variances(way, turn)
    noise = np.diag([along, along, around])
    # Headings err all along the way: on average, half of it lies ahead.
    halfway = np.array([[1.0, 0.0, -y / 2.0], [0.0, 1.0, x / 2.0], [0.0, 0.0, 1.0]])
    moved: NDArray[np.float64] = turned @ covariance @ turned.T + halfway @ noise @ halfway.T
    return moved


def within_limits(covariance: NDArray[np.float64]) -> float:
    """Return the probability of being within MODE_RADIUS and MODE_TURN of a normal one's mean.

    Place and heading are taken to be independent.
    """
    variances = np.maximum(np.linalg.eigvalsh(covariance[:2, :2]), LEAST_VARIANCE)
    narrow, wide = (math.sqrt(2.0 * variance) for variance in variances)
    edges = np.linspace(-MODE_RADIUS, MODE_RADIUS, STRIPS + 1)
    strips = np.diff([math.erf(edge / wide) for edge in edges]) / 2.0
    heights = np.sqrt(MODE_RADIUS**2 - ((edges[1:] + edges[:-1]) / 2.0) ** 2)
    place = float(strips @ [math.erf(height / narrow) for height in heights])
    return place * math.erf(MODE_TURN / math.sqrt(2.0 * max(covariance[2, 2], LEAST_VARIANCE)))
