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
def beams_met(
    distance: NDArray[np.float32], pose: NDArray[np.float64], beams: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return for each beam (n, 2: bearing, range [cells]) from a pose (3,) two distances (n, 2).

    How far its end lies from the nearest wall (-1 off the map), and how far off is the
    first wall that a ray along it meets, up to a metre's worth of cells beyond its end.
    """
    met = np.empty((len(beams), 2))
    for i in range(len(beams)):
        angle = pose[2] + beams[i, 0]
        length = beams[i, 1]
        met[i, 0] = distance_at(
            distance, pose[0] + length * np.cos(angle), pose[1] + length * np.sin(angle)
        )
        met[i, 1] = first_wall(distance, pose[0], pose[1], angle, 1.5 * length + 20.0)
    return met


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
    x, y, heading = pose[0], pose[1], pose[2]
    information = np.empty((3, 3))
    force = np.empty(3)
    for _ in range(8):
        information[:] = 0.0
        force[:] = 0.0
        cos, sin = np.cos(heading), np.sin(heading)
        for i in range(len(ends)):
            dx = cos * ends[i, 0] - sin * ends[i, 1]
            dy = sin * ends[i, 0] + cos * ends[i, 1]
            u, v = x + dx - 0.5, y + dy - 0.5
            rows, cols = distance.shape
            if not (0.0 <= u < cols - 1 and 0.0 <= v < rows - 1):
                continue
            col, row = int(u), int(v)
            fx, fy = u - col, v - row
            a, b = distance[row, col], distance[row, col + 1]
            c, e = distance[row + 1, col], distance[row + 1, col + 1]
            d = (a * (1.0 - fx) + b * fx) * (1.0 - fy) + (c * (1.0 - fx) + e * fx) * fy
            if d > 3.0 * scale:
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
        information[0, 0] += damping
        information[1, 1] += damping
        information[2, 2] += damping * 400.0
        step = _solved(information, force)
        x, y, heading = x + step[0], y + step[1], heading + step[2]
        if abs(step[0]) < 2e-3 and abs(step[1]) < 2e-3 and abs(step[2]) < 1e-4:
            break
    return np.array([x, y, heading])


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
