"""Rigid motions of the plane as arrays (..., 3): x [m], y [m], theta [rad] in [-pi, pi).

A pose `map_from_base` takes points of frame `base` to frame `map`; in a composition the inner
frame names meet: `map_from_base = compose(map_from_odom, odom_from_base)`.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.angles import wrap

Poses = NDArray[np.float64]


def compose(outer: ArrayLike, inner: ArrayLike) -> Poses:
    """Return `outer` followed by `inner`, broadcast over the leading axes."""
    a, b = np.broadcast_arrays(np.asarray(outer, float), np.asarray(inner, float))
    cos, sin = np.cos(a[..., 2]), np.sin(a[..., 2])
    x = a[..., 0] + cos * b[..., 0] - sin * b[..., 1]
    y = a[..., 1] + sin * b[..., 0] + cos * b[..., 1]
    return np.stack([x, y, wrap(a[..., 2] + b[..., 2])], axis=-1)


def inverse(pose: ArrayLike) -> Poses:
    """Return the motion that undoes `pose`."""
    p = np.asarray(pose, float)
    cos, sin = np.cos(p[..., 2]), np.sin(p[..., 2])
    x = -cos * p[..., 0] - sin * p[..., 1]
    y = sin * p[..., 0] - cos * p[..., 1]
    return np.stack([x, y, wrap(-p[..., 2])], axis=-1)


def between(origin: ArrayLike, target: ArrayLike) -> Poses:
    """Return `target` as seen from `origin`; composed with `origin` it gives `target` again."""
    return compose(inverse(origin), target)


def transform_points(pose: ArrayLike, points: ArrayLike) -> NDArray[np.float64]:
    """Take points (n, 2) of the inner frame to the outer frame of one pose (3,)."""
    x, y, theta = np.asarray(pose, float)
    cos, sin = np.cos(theta), np.sin(theta)
    rotation = np.array([[cos, -sin], [sin, cos]])
    moved: NDArray[np.float64] = np.asarray(points, float) @ rotation.T + np.array([x, y])
    return moved


def interpolate(origin: ArrayLike, target: ArrayLike, fraction: float) -> Poses:
    """Return the pose at `fraction` of the way, x, y and theta (the short way round) linearly."""
    a, b = np.asarray(origin, float), np.asarray(target, float)
    step = b - a
    step[2] = wrap(float(step[2]))
    moved: Poses = a + fraction * step
    moved[2] = wrap(float(moved[2]))
    return moved
