"""Angles in radians, wrapped to [-pi, pi)."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Angle = TypeVar("Angle", float, NDArray[np.float64])


def wrap(angle: Angle) -> Angle:
    """Return the same direction in [-pi, pi); a float stays a float, an array keeps its shape."""
    wrapped: Angle = (angle + np.pi) % (2.0 * np.pi) - np.pi
    return wrapped


def difference(target: Angle, origin: Angle) -> Angle:
    """Return the shortest turn from `origin` to `target`, in [-pi, pi)."""
    return wrap(target - origin)


def circular_mean(angles: NDArray[np.float64], weights: NDArray[np.float64]) -> float:
    """Return the direction of the weighted sum of unit vectors.

    Args:
        angles: (n,) directions in rad.
        weights: (n,) weights, not all zero.
    """
    return float(np.arctan2(weights @ np.sin(angles), weights @ np.cos(angles)))
