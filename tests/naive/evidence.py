"""What a scan says of a pose, ray by ray in plain Python, and summits one by one.

Twins of `localizer.evidence_kernels` and `localizer.peaks`; lengths are in cells as there.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.localizer import evidence_kernels as kernels

Array = NDArray[np.float64]
Field = NDArray[np.float32]

GONE_THROUGH, MET, SHORT = "through", "met", "short"
ROWS = {GONE_THROUGH: 0, MET: 1, SHORT: 2}
"""Rows of the weights of beams that came back."""


def corners_at(distance: Field, x: float, y: float) -> tuple[Array, float, float] | None:
    """The four cell centres around a point, [below, above][left, right], and where between them."""
    rows, cols = distance.shape
    left, below = math.floor(x - 0.5), math.floor(y - 0.5)
    if left < 0 or below < 0 or left + 1 >= cols or below + 1 >= rows:
        return None
    corners = distance[below : below + 2, left : left + 2].astype(float)
    return corners, x - 0.5 - left, y - 0.5 - below


def distance_at(distance: Field, x: float, y: float) -> float | None:
    """Twin of `distance_at`; None off the map."""
    around = corners_at(distance, x, y)
    if around is None:
        return None
    corners, across, up = around
    return float(np.array([1.0 - up, up]) @ corners @ np.array([1.0 - across, across]))


def along(origin: Array, way: float) -> tuple[float, float]:
    """The point of a ray from an origin (3,)."""
    x, y, direction = (float(value) for value in origin)
    return x + way * math.cos(direction), y + way * math.sin(direction)


def first_obstacle(distance: Field, origin: Array, reach: float) -> float:
    """Twin of `first_obstacle`."""
    way = 0.0
    while way < reach:
        near = distance_at(distance, *along(origin, way))
        if near is None:
            break
        if near < kernels.INSIDE:
            return way
        way += max(near - kernels.INSIDE, kernels.LEAST_STEP)
    return reach


def normal_equations(distance: Field, pose: Array, ends: Array, pull: float) -> Array:
    """Twin of `normal_equations`: the rows of J first, then the products."""
    gradients, offs, weights = [], [], []
    for end in ends:
        ((x, y),) = se2.transform_points(pose, end[None])
        around = corners_at(distance, x, y)
        if around is None:
            continue
        corners, across, up = around
        off = float(np.array([1.0 - up, up]) @ corners @ np.array([1.0 - across, across]))
        if abs(off) > kernels.FARTHEST_PULL * pull:
            continue
        by_x = float(np.array([1.0 - up, up]) @ (corners[:, 1] - corners[:, 0]))
        by_y = float((corners[1] - corners[0]) @ np.array([1.0 - across, across]))
        gradients.append([by_x, by_y, by_y * (x - pose[0]) - by_x * (y - pose[1])])
        offs.append(off)
        weights.append((1.0 + (off / pull) ** 2) ** -2)
    jacobian = np.array(gradients).reshape(-1, 3)
    weighted = jacobian.T * np.array(weights)
    return np.column_stack([weighted @ jacobian, -weighted @ np.array(offs)])


def refined_pose(distance: Field, pose: Array, ends: Array, pull: float) -> Array:
    """Twin of `refined_pose`."""
    refined = np.array(pose, float)
    for _ in range(kernels.ITERATIONS):
        system = normal_equations(distance, refined, ends, pull)
        step = np.linalg.solve(system[:, :3] + np.diag(kernels.DAMPING), system[:, 3])
        refined = refined + step
        if (np.abs(step) < kernels.SMALL_STEP).all():
            break
    return refined


def weigh_poses(
    distance: Field,
    poses: Array,
    scan: kernels.Scan,
    scales: kernels.Scales,
    weights: kernels.Weights,
) -> tuple[Array, Array]:
    """Twin of `weigh_poses`."""
    refined = np.array([believed(distance, pose, scan, scales) for pose in poses])
    words = [word_on(distance, pose, scan, scales, weights) for pose in refined]
    return refined.reshape(-1, 3), np.array(words).reshape(-1, 4)


def believed(distance: Field, pose: Array, scan: kernels.Scan, scales: kernels.Scales) -> Array:
    """The refined pose, or the pose itself if that is another place."""
    refined = refined_pose(distance, pose, scan.ends, scales.pull)
    away, turn = math.dist(refined[:2], pose[:2]), abs(refined[2] - pose[2])
    return refined if away <= scales.moved and turn <= scales.turned else np.array(pose)


def word_on(
    distance: Field,
    pose: Array,
    scan: kernels.Scan,
    scales: kernels.Scales,
    weights: kernels.Weights,
) -> list[float]:
    """Evidence, share that met, share that went through, mean weight."""
    here = distance_at(distance, float(pose[0]), float(pose[1]))
    if here is None or here < 0.5:
        return [kernels.NOWHERE[0], 0.0, 0.0, kernels.NOWHERE[1]]
    (laser,) = se2.transform_points(pose, scan.mount[None, :2])
    kinds, words, met = [], [], 0
    for bearing, length, is_silent, _ in scan.rays:
        origin = np.array([*laser, pose[2] + scan.mount[2] + bearing])
        end = end_class(distance, along(origin, length), scales)
        kind = kind_of(distance, origin, length, scales, is_at_wall=end < 3)
        kinds.append(kind)
        met += not is_silent and kind == MET and end < 3
        words.append(
            weights.silent[0 if kind == GONE_THROUGH else 1]
            if is_silent
            else weights.back[ROWS[kind], end]
        )
    count = max(1, len(words))
    evidence = float(np.dot(scan.rays[:, 3], words))
    return [evidence, met / count, kinds.count(GONE_THROUGH) / count, sum(words) / count]


def end_class(distance: Field, end: tuple[float, float], scales: kernels.Scales) -> int:
    """How many limits an end's distance from a wall reaches."""
    near = distance_at(distance, *end)
    return len(scales.limits) if near is None else int(np.sum(abs(near) >= scales.limits))


def kind_of(
    distance: Field, origin: Array, length: float, scales: kernels.Scales, *, is_at_wall: bool
) -> str:
    """What a ray does at the first obstacle on its way."""
    met = first_obstacle(distance, origin, length + 1.5 * scales.tolerance)
    if met > length + scales.tolerance:
        return SHORT
    if met >= length - scales.tolerance:
        return MET
    if is_at_wall and not leaves(distance, origin, (met, length), scales.graze):
        return MET
    if any(
        first_obstacle(distance, ray, length) >= length - scales.tolerance
        for ray in rays_beside(origin, scales)
    ):
        return MET
    return GONE_THROUGH


def leaves(distance: Field, origin: Array, between: tuple[float, float], graze: float) -> bool:
    """Whether a ray gets `graze` away from all walls between where it met one and its end."""
    way, length = between
    while way < length:
        there = distance_at(distance, *along(origin, way))
        if there is None or abs(there) >= graze:
            return True
        way += max(graze - abs(there), kernels.LEAST_STEP)
    return False


def rays_beside(origin: Array, scales: kernels.Scales) -> list[Array]:
    """The same ray a little to the left and right, and turned a little."""
    x, y, direction = origin
    aside = scales.beside * np.array([-math.sin(direction), math.cos(direction)])
    return [
        np.array([x - aside[0], y - aside[1], direction]),
        np.array([x + aside[0], y + aside[1], direction]),
        np.array([x, y, direction - kernels.TURNED]),
        np.array([x, y, direction + kernels.TURNED]),
    ]


def summits(poses: Array, most: int, beside_way: float, beside_turn: float) -> list[int]:
    """Twin of `summits`."""
    chosen: list[int] = []
    for index, pose in enumerate(poses):
        is_slope = any(
            math.dist(pose[:2], poses[other][:2]) <= beside_way
            and abs(float(wrap(pose[2] - poses[other][2]))) <= beside_turn
            for other in chosen
        )
        if not is_slope and len(chosen) < most:
            chosen.append(index)
    return chosen
