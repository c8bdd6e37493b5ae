"""How far a body may go along an arc before it touches, and how fast it may then be; pure."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.motion import arc

STEP = 0.03
"""m between the places on an arc that are looked at."""
NEARER = 0.004
"""m by which a body must come nearer to a point to be said to run into it."""


def free_way(points: NDArray[np.float64], curvature: float, reach: float, horizon: float) -> float:
    """Return how far in m a disc may go along an arc before a point is within it.

    A point that is within it at the start only counts when it comes nearer: so a robot that
    stands against something can leave it.

    Args:
        points: (n, 2) m, base_link.
        curvature: 1/m, to the left positive.
        reach: radius of the disc, m.
        horizon: how far it is looked, m.
    """
    near = points[np.hypot(points[:, 0], points[:, 1]) < reach + horizon]
    if len(near) == 0:
        return horizon
    ways = np.arange(0.0, horizon + STEP, STEP)
    places = np.array([arc(np.zeros(3), 1.0, curvature, float(way))[:2] for way in ways])
    distances = np.hypot(*(near[None, :, :] - places[:, None, :]).transpose(2, 0, 1))
    touches = distances < np.minimum(reach, distances[0] - NEARER)
    blocked = touches.any(axis=1)
    return float(ways[int(np.argmax(blocked))] - STEP) if blocked.any() else horizon


def safe_speed(free: float, braking: float, delay: float) -> float:
    """Return the speed in m/s from which a robot stops within `free` m.

    Args:
        free: m.
        braking: m/s^2.
        delay: time until it begins to brake, s.
    """
    lag = braking * delay
    return float(np.sqrt(lag**2 + 2.0 * braking * max(free, 0.0)) - lag)
