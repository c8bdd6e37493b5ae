"""Scans against the map from poses between the cells: refining them, and what each beam meets.

Poses (x, y, heading) and beams are in cells of the map's grid, from its corner, along its axes.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

INSIDE = 0.4
"""A ray nearer than this [cells] to the centre of a wall's cell has met the wall."""

LEAST_STEP = 0.4
"""A ray moves on by so much [cells] at least."""

ITERATIONS = 8
"""Steps of Gauss-Newton at most."""

TURN_DAMPING = 400.0
"""Damping of a turn, in cells^2: that of a place 20 cells away."""

FARTHEST_PULL = 3.0
"""An end farther than so many scales from any wall does not pull at all."""

NOWHERE = -1e3
"""Evidence for a pose in a wall or off the map."""


@kernel
def distance_at(distance: NDArray[np.float32], x: float, y: float) -> float:
    """Return the distance [cells] to the nearest wall, bilinear; -1 off the map."""
    rows, cols = distance.shape
    u, v = x - 0.5, y - 0.5
    if not (0.0 <= u < cols - 1 and 0.0 <= v < rows - 1):
        return -1.0
    col, row = int(u), int(v)
    fx, fy = u - col, v - row
    below = distance[row, col] * (1.0 - fx) + distance[row, col + 1] * fx
    above = distance[row + 1, col] * (1.0 - fx) + distance[row + 1, col + 1] * fx
    return float(below * (1.0 - fy) + above * fy)


@kernel
def first_wall(
    distance: NDArray[np.float32], x: float, y: float, angle: float, reach: float
) -> float:
    """Return how far [cells] a ray travels until it meets a wall; `reach` if it meets none.

    It may step as far as the nearest wall is away without missing one.
    """
    cos, sin = np.cos(angle), np.sin(angle)
    travelled = 0.0
    while travelled < reach:
        near = distance_at(distance, x + travelled * cos, y + travelled * sin)
        if near < 0.0:
            return reach
        if near < INSIDE:
            return travelled
        travelled += max(near - INSIDE, LEAST_STEP)
    return reach


@kernel
def refined_pose(
    distance: NDArray[np.float32],
    pose: NDArray[np.float64],
    ends: NDArray[np.float64],
    scale: float,
    damping: float,
) -> NDArray[np.float64]:
    """Return the pose (3,) near `pose` that puts beam ends (n, 2) of the robot's frame onto walls.

    Gauss-Newton on the distance to the nearest wall; an end farther than `scale` [cells] from
    any pulls less and less, so that people and furniture do not matter. `damping` is added to
    the information of each coordinate: a corridor must not slide along itself.
    """
    refined = pose.copy()
    information = np.empty((3, 3))
    force = np.empty(3)
    for _ in range(ITERATIONS):
        information[:] = 0.0
        force[:] = 0.0
        _add_ends(distance, refined, ends, scale, information, force)
        information[0, 0] += damping
        information[1, 1] += damping
        information[2, 2] += damping * TURN_DAMPING
        step = _solved(information, force)
        refined += step
        if abs(step[0]) < 2e-3 and abs(step[1]) < 2e-3 and abs(step[2]) < 1e-4:
            break
    return refined


@kernel
def _add_ends(
    distance: NDArray[np.float32],
    pose: NDArray[np.float64],
    ends: NDArray[np.float64],
    scale: float,
    information: NDArray[np.float64],
    force: NDArray[np.float64],
) -> None:
    """Add each end's part to J^T W J and -J^T W d, J being the distance's gradient by the pose."""
    rows, cols = distance.shape
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    for i in range(len(ends)):
        dx = cos * ends[i, 0] - sin * ends[i, 1]
        dy = sin * ends[i, 0] + cos * ends[i, 1]
        u, v = pose[0] + dx - 0.5, pose[1] + dy - 0.5
        if not (0.0 <= u < cols - 1 and 0.0 <= v < rows - 1):
            continue
        col, row = int(u), int(v)
        fx, fy = u - col, v - row
        a, b = distance[row, col], distance[row, col + 1]
        c, e = distance[row + 1, col], distance[row + 1, col + 1]
        d = (a * (1.0 - fx) + b * fx) * (1.0 - fy) + (c * (1.0 - fx) + e * fx) * fy
        if d > FARTHEST_PULL * scale:
            continue
        gx = (b - a) * (1.0 - fy) + (e - c) * fy
        gy = (c - a) * (1.0 - fx) + (e - b) * fx
        turning = gy * dx - gx * dy
        weight = 1.0 / (1.0 + (d / scale) ** 2) ** 2
        information[0, 0] += weight * gx * gx
        information[0, 1] += weight * gx * gy
        information[0, 2] += weight * gx * turning
        information[1, 1] += weight * gy * gy
        information[1, 2] += weight * gy * turning
        information[2, 2] += weight * turning * turning
        force[0] -= weight * gx * d
        force[1] -= weight * gy * d
        force[2] -= weight * turning * d
    information[1, 0] = information[0, 1]
    information[2, 0] = information[0, 2]
    information[2, 1] = information[1, 2]


@kernel
def fit_information(
    distance: NDArray[np.float32],
    pose: NDArray[np.float64],
    ends: NDArray[np.float64],
    scale: float,
) -> NDArray[np.float64]:
    """Return J^T W J (3, 3) of the ends' distances to the nearest wall, as `refined_pose` has it."""
    information = np.zeros((3, 3))
    force = np.zeros(3)
    _add_ends(distance, pose, ends, scale, information, force)
    return information


@kernel
def _solved(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return x with a x = b for a positive (3, 3), by Cholesky's factors written out."""
    l00 = np.sqrt(a[0, 0])
    l10, l20 = a[1, 0] / l00, a[2, 0] / l00
    l11 = np.sqrt(a[1, 1] - l10 * l10)
    l21 = (a[2, 1] - l20 * l10) / l11
    l22 = np.sqrt(a[2, 2] - l20 * l20 - l21 * l21)
    y0 = b[0] / l00
    y1 = (b[1] - l10 * y0) / l11
    y2 = (b[2] - l20 * y0 - l21 * y1) / l22
    x2 = y2 / l22
    x1 = (y1 - l21 * x2) / l11
    return np.array([(y0 - l10 * x1 - l20 * x2) / l00, x1, x2])


@kernel
def weigh_poses(
    distance: NDArray[np.float32],
    poses: NDArray[np.float64],
    ends: NDArray[np.float64],
    rays: NDArray[np.float64],
    mount: NDArray[np.float64],
    limits: NDArray[np.float64],
    reach: NDArray[np.float64],
    weights: NDArray[np.float64],
    silent_weights: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Refine poses (n, 3) on the ends (m, 2) of beams and weigh each by rays (k, 4).

    Args:
        distance: (rows, cols) to the nearest obstacle.
        poses: of the robot.
        ends: of all beams that came back, in the robot's frame.
        rays: bearing, length, 1 where nothing came back, and weight of each ray of the laser.
        mount: (3,) of the laser on the robot.
        limits: (5,) classes of an end's distance, and tolerance of a range.
        reach: (3,) of the pull of an obstacle, and how far a pose may move and turn.
        weights: (3, 5) of beams that went through, met, fell short; by class of distance.
        silent_weights: (2,) of beams without a return: rightly, and through an obstacle.

    Returns:
        The refined poses (n, 3), and per pose (n, 4) the evidence, the share of rays that met
        an obstacle as they should, the share that went through one, and the mean weight.
    """
    refined = np.empty_like(poses)
    sums = np.zeros((len(poses), 4))
    for i in range(len(poses)):
        pose = refined_pose(distance, poses[i], ends, reach[0], 1.0)
        moved = np.hypot(pose[0] - poses[i, 0], pose[1] - poses[i, 1])
        if moved > reach[1] or abs(pose[2] - poses[i, 2]) > reach[2]:
            pose = poses[i].copy()
        refined[i] = pose
        if distance_at(distance, pose[0], pose[1]) < 0.5:
            sums[i, 0] = NOWHERE
            sums[i, 3] = -1.0
            continue
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        x = pose[0] + cos * mount[0] - sin * mount[1]
        y = pose[1] + sin * mount[0] + cos * mount[1]
        for ray in rays:
            kind, place = _met(distance, x, y, pose[2] + mount[2] + ray[0], ray, limits)
            word = weights[kind, place]
            if ray[2] > 0.0:
                word = silent_weights[1 if kind == 0 else 0]
            elif kind == 1 and place < 3:
                sums[i, 1] += 1.0
            if kind == 0:
                sums[i, 2] += 1.0
            sums[i, 0] += ray[3] * word
            sums[i, 3] += word
        sums[i, 1:] /= max(1, len(rays))
    return refined, sums


@kernel
def _met(
    distance: NDArray[np.float32],
    x: float,
    y: float,
    angle: float,
    ray: NDArray[np.float64],
    limits: NDArray[np.float64],
) -> tuple[int, int]:
    """Return whether a ray went through (0), met (1), fell short (2), and the class of its end."""
    length, tolerance = ray[1], limits[4]
    met = first_wall(distance, x, y, angle, length + 1.5 * tolerance)
    kind = 1
    if met < length - tolerance:
        kind = 0
    elif met > length + tolerance:
        kind = 2
    end = distance_at(distance, x + length * np.cos(angle), y + length * np.sin(angle))
    place = 0
    while place < 4 and (end < 0.0 or end >= limits[place]):
        place += 1
    return kind, place
