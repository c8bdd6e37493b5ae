"""Walls as segments (n, 4), x and y of both ends in m: what cones and rays meet of them; pure."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

HAIR = 1e-6
"""m; how near a point must be to lie on a wall."""


def nearest_in_cone(walls: Floats, sonars: Floats, half_cone: float) -> tuple[Floats, Bools]:
    """Return the nearest point (m, n, 2) of each wall inside each cone, and whether there is one.

    It is the foot of the perpendicular, or where an edge of the cone meets the wall; ends of
    walls are left to the corners.
    """
    starts, along = walls[:, :2], walls[:, 2:] - walls[:, :2]
    off = sonars[:, None, :2] - starts[None]
    share = np.einsum("mnd,nd->mn", off, along) / np.einsum("nd,nd->n", along, along)
    feet = starts[None] + share[..., None] * along[None]
    candidates = [(feet, (share >= 0.0) & (share <= 1.0))]
    for side in (-half_cone, half_cone):
        way, where = cross(walls, sonars[:, :2], sonars[:, 2] + side)
        direction = np.stack([np.cos(sonars[:, 2] + side), np.sin(sonars[:, 2] + side)], axis=-1)
        reach = np.where(np.isfinite(way), way, 0.0)
        meeting = sonars[:, None, :2] + reach[..., None] * direction[:, None]
        candidates.append((meeting, where & np.isfinite(way)))
    is_held = candidates[0][1] & is_in_cone(feet - sonars[:, None, :2], sonars, half_cone)
    best, holds = candidates[0][0], is_held
    nearest = np.where(holds, _distance(best, sonars), np.inf)
    for points, valid in candidates[1:]:
        away = np.where(valid, _distance(points, sonars), np.inf)
        best = np.where((away < nearest)[..., None], points, best)
        nearest = np.minimum(nearest, away)
    return best, np.isfinite(nearest)


def cross(walls: Floats, origins: Floats, bearings: Floats) -> tuple[Floats, Bools]:
    """Return how far (m, n) rays go to the lines of walls, and whether they hit the walls."""
    along = walls[:, 2:] - walls[:, :2]
    ahead = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
    off = walls[None, :, :2] - origins[:, None]
    slant = _wedge(ahead[:, None], along[None])
    is_parallel = np.abs(slant) < 1e-12
    slant = np.where(is_parallel, 1.0, slant)
    way = np.where(is_parallel, np.inf, _wedge(off, along[None]) / slant)
    share = _wedge(off, ahead[:, None]) / slant
    return way, ~is_parallel & (way >= 0.0) & (share >= 0.0) & (share <= 1.0)


def is_seen(walls: Floats, sonars: Floats, points: Floats) -> Bools:
    """Say of points (m, k, 2) whether no wall stands between them and their sonars (m, 3)."""
    towards = points - sonars[:, None, :2]
    away = np.hypot(towards[..., 0], towards[..., 1])
    bearings = np.arctan2(towards[..., 1], towards[..., 0])
    seen = np.empty(away.shape, bool)
    for column in range(points.shape[1]):
        way, where = cross(walls, sonars[:, :2], bearings[:, column])
        ahead = np.where(where & (way > HAIR), way, np.inf).min(axis=1)
        seen[:, column] = ahead >= away[:, column] - 1e-4
    return seen


def distance_to_walls(walls: Floats, points: Floats) -> Floats:
    """Return how far points (k, 2) are from the nearest wall (k,), m."""
    along = walls[:, 2:] - walls[:, :2]
    off = points[:, None] - walls[None, :, :2]
    share = np.einsum("knd,nd->kn", off, along) / np.einsum("nd,nd->n", along, along)
    nearest = walls[None, :, :2] + np.clip(share, 0.0, 1.0)[..., None] * along[None]
    away = points[:, None] - nearest
    return np.asarray(np.hypot(away[..., 0], away[..., 1]).min(axis=1), float)


def normals_of(walls: Floats) -> Floats:
    """Return a unit normal (n, 2) of each wall."""
    along = walls[:, 2:] - walls[:, :2]
    across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    normals: Floats = across / np.hypot(across[:, 0], across[:, 1])[:, None]
    return normals


def is_concave(walls: Floats, corners: Floats, sonars: Floats) -> Bools:
    """Say (m, c) whether two walls meet at a corner around the side that a sonar stands on."""
    concave = np.zeros((len(sonars), len(corners)), bool)
    for index, corner in enumerate(corners):
        begins = np.hypot(*(walls[:, :2] - corner).T) < 1e-5
        ends = np.hypot(*(walls[:, 2:] - corner).T) < 1e-5
        arms = np.concatenate([walls[begins, 2:], walls[ends, :2]]) - corner
        if len(arms) == 2:
            shares = np.linalg.lstsq(arms.T, (sonars[:, :2] - corner).T, rcond=None)[0]
            concave[:, index] = np.all(shares > 0.0, axis=0)
    return concave


def is_in_cone(towards: Floats, sonars: Floats, half_cone: float) -> Bools:
    """Say of directions (m, k, 2) from sonars (m, 3) whether their cones hold them."""
    bearing = np.arctan2(towards[..., 1], towards[..., 0]) - sonars[:, None, 2]
    inside: Bools = np.abs(wrap(bearing)) <= half_cone
    return inside


def directions_of(walls: Floats) -> Floats:
    """Return the direction (n,) of each wall from its first end to its second, rad."""
    along = walls[:, 2:] - walls[:, :2]
    return np.asarray(np.arctan2(along[:, 1], along[:, 0]), float)


def _distance(points: Floats, sonars: Floats) -> Floats:
    towards = points - sonars[:, None, :2]
    return np.asarray(np.hypot(towards[..., 0], towards[..., 1]), float)


def _wedge(one: Floats, other: Floats) -> Floats:
    """Return the cross product of plane vectors (..., 2)."""
    product: Floats = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return product
