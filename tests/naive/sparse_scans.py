"""Sparse scans as formulas: the wall at a place by eigenvectors, every point asking every other."""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.particle_kernels import Cloud, Moved, Sight
from pilotage.mapper.smoother_kernels import Pull
from pilotage.mapper.wall_kernels import LEAST_SPREAD, LEAST_WEIGHT

Floats = NDArray[np.float64]
Wall = tuple[int, Floats, float, float]


def wall_at(place: Floats, points: Floats, reach: float) -> Wall:
    """What points (n, 2) show around a place: kind, normal (2,), distance and variance across.

    Twin of `wall_kernels.wall_of` and of the sums it is given.
    """
    seen = points - place
    weights = np.maximum(0.0, 1.0 - (seen**2).sum(axis=1) / reach**2)
    total = float(weights.sum())
    if total < LEAST_WEIGHT:
        return 0, np.zeros(2), 0.0, 0.0
    mean = weights @ seen / total
    spread = (weights[:, None] * (seen - mean)).T @ (seen - mean) / total
    values, vectors = np.linalg.eigh(spread)
    if values[1] < LEAST_SPREAD**2:
        return 1, np.zeros(2), float(np.hypot(*mean)), LEAST_SPREAD**2
    normal = vectors[:, 0]
    return 2, normal, -float(normal @ mean), max(float(values[0]), 0.0)


def placed(pose: Floats, points: Floats) -> Floats:
    """Points (n, 2) of the frame of a pose (3,), in the outer one."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    turned: Floats = points @ np.array([[cos, sin], [-sin, cos]])
    return turned + pose[:2]


def propose(cloud: Cloud, moved: Moved, normals: Floats, uniforms: Floats) -> None:
    """Twin of `particle_kernels.propose`: all particles at once."""
    low, high = moved.scale_limits
    scales = cloud.scales + moved.wander * normals[:, 3:5]
    scales = np.where(scales > high, 2.0 * high - scales, scales)
    cloud.scales[:] = np.where(scales < low, 2.0 * low - scales, scales)
    chance = np.where(cloud.senses > 0.0, moved.back, moved.ahead)
    cloud.senses[uniforms[:, 0] < chance] *= -1.0
    rough = np.where(uniforms[:, 1] < moved.rough, 4.0, 1.0)
    way, turn = moved.way * np.exp(cloud.scales[:, 0]), moved.turn * np.exp(cloud.scales[:, 1])
    slip = np.where(uniforms[:, 2] < moved.slip, uniforms[:, 3], 1.0)
    dx = cloud.senses * slip * moved.increment[0] + rough * way * normals[:, 0]
    dy = cloud.senses * moved.increment[1] + way * normals[:, 1]
    error = rough * turn * normals[:, 2]
    heading = cloud.poses[:, 2] + 0.5 * error
    cloud.poses[:, 0] += np.cos(heading) * dx - np.sin(heading) * dy
    cloud.poses[:, 1] += np.sin(heading) * dx + np.cos(heading) * dy
    cloud.poses[:, 2] += moved.increment[2] + error


def weigh(cloud: Cloud, counts: NDArray[np.int64], points: Floats, sight: Sight) -> Floats:
    """Twin of `particle_kernels.weigh`."""
    return np.array(
        [
            sum(
                _log_likelihood(place, _seen(seen, counts), sight) for place in placed(pose, points)
            )
            for pose, seen in zip(cloud.poses, cloud.seen, strict=True)
        ]
    )


def _seen(seen: NDArray[np.float32], counts: NDArray[np.int64]) -> Floats:
    return np.concatenate([part[:n] for part, n in zip(seen, counts, strict=True)]).astype(float)


def _log_likelihood(place: Floats, seen: Floats, sight: Sight) -> float:
    kind, _, off, spread = wall_at(place, seen, sight.reach)
    if kind == 0:
        return sight.unknown
    variance = sight.sigma**2 + spread
    fit = math.exp(-0.5 * off**2 / variance)
    wide = math.log(variance / sight.sigma**2)
    return math.log(sight.stray + (1.0 - sight.stray) * fit) - 0.25 * wide


def pull_to_walls(
    poses: Floats, points: Floats, owners: NDArray[np.int64], reach: float, pull: Pull
) -> tuple[Floats, Floats]:
    """Twin of `smoother_kernels.pull_to_walls`, which is given the points in bins."""
    H, g = np.zeros((len(poses), 3, 3)), np.zeros((len(poses), 3))
    for point, owner in zip(points, owners, strict=True):
        apart = np.abs(owners - owner)
        others = points[(apart >= pull.nearest) & (apart <= pull.farthest)]
        kind, normal, off, spread = wall_at(point, others, reach)
        if kind == 2:
            arm = point - poses[owner, :2]
            J = np.array([*normal, normal[1] * arm[0] - normal[0] * arm[1]])
            robust = 1.0 / (1.0 + off**2 / pull.scale**2)
            weight = robust**2 / (pull.sigma**2 + spread)
            H[owner] += weight * np.outer(J, J)
            g[owner] += weight * off * J
    return H, g
