"""Scans against the map from poses between the cells: refining them, and what each beam meets.

Poses (x, y, heading) and lengths are in cells of the map's grid, from its corner, along its axes.
Each kernel has a plain twin in tests/naive/evidence.py.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

INSIDE = 0.55
"""A ray nearer than this to the centre of an obstacle's cell has met the obstacle: at its face, and
between two cells that touch by a corner."""

LEAST_STEP = 0.4
"""A ray moves on by so much at least."""

OFF = -1e6
"""Distance told off the map."""

ITERATIONS = 8
"""Steps of Gauss-Newton at most."""

DAMPING = np.array([1.0, 1.0, 400.0])
"""Added to the information: a corridor must not slide along itself. A turn counts as 20 cells."""

SMALL_STEP = np.array([2e-3, 2e-3, 1e-4])
"""A step of Gauss-Newton smaller than this is the last."""

FARTHEST_PULL = 3.0
"""An end farther than so many scales from any wall does not pull at all."""

NOWHERE = -1e3, -1.0
"""Evidence, in all and of a beam, for a pose in a wall or off the map."""

TURNED = 0.02
"""A ray turned by so much [rad] is nearly the same ray."""

THROUGH, MET, SHORT = 0, 1, 2


class Scan(NamedTuple):
    """A laser scan.

    `ends`: (m, 2) of all beams that came back, in the robot's frame; `rays`: (k, 4) bearing,
    length, 1 where nothing came back, and weight of those that are weighed; `mount`: (3,) of the
    laser on the robot.
    """

    ends: NDArray[np.float64]
    rays: NDArray[np.float64]
    mount: NDArray[np.float64]


class Scales(NamedTuple):
    """`limits`: (4,) classes of an end's distance from an obstacle; `tolerance` of a range.

    `beside`: how far beside a beam it may pass an obstacle; `graze`: how near it runs along one;
    `pull`: scale of an obstacle's pull;
    `moved`, `turned`: how far a pose may be refined.
    """

    limits: NDArray[np.float64]
    tolerance: float
    beside: float
    graze: float
    pull: float
    moved: float
    turned: float


class Weights(NamedTuple):
    """`back`: (3, 5) of a beam that went through, met, fell short, by class of its end.

    `silent`: (2,) of a beam that met nothing, through an obstacle, and rightly.
    """

    back: NDArray[np.float64]
    silent: NDArray[np.float64]


@kernel
def distance_at(distance: NDArray[np.float32], x: float, y: float) -> float:
    """Return the distance to the nearest wall, bilinear, negative behind it; OFF the map."""
    rows, cols = distance.shape
    u, v = x - 0.5, y - 0.5
    if not (0.0 <= u < cols - 1 and 0.0 <= v < rows - 1):
        return OFF
    col, row = int(u), int(v)
    fx, fy = u - col, v - row
    below = distance[row, col] * (1.0 - fx) + distance[row, col + 1] * fx
    above = distance[row + 1, col] * (1.0 - fx) + distance[row + 1, col + 1] * fx
    return float(below * (1.0 - fy) + above * fy)


@kernel
def first_obstacle(
    distance: NDArray[np.float32], origin: NDArray[np.float64], reach: float
) -> float:
    """Return how far a ray from an origin (3,) travels to an obstacle; `reach` if it meets none.

    It may step as far as the nearest obstacle is away without missing one.
    """
    cos, sin = np.cos(origin[2]), np.sin(origin[2])
    travelled = 0.0
    while travelled < reach:
        near = distance_at(distance, origin[0] + travelled * cos, origin[1] + travelled * sin)
        if near == OFF:
            return reach
        if near < INSIDE:
            return travelled
        travelled += max(near - INSIDE, LEAST_STEP)
    return reach


@kernel
def refined_pose(
    distance: NDArray[np.float32], pose: NDArray[np.float64], ends: NDArray[np.float64], pull: float
) -> NDArray[np.float64]:
    """Return the pose (3,) near `pose` that puts beam ends (n, 2) of the robot's frame onto walls.

    Gauss-Newton on the distance to the nearest wall; an end farther than `pull` from any
    pulls less and less, so that people and furniture do not matter.
    """
    refined = pose.copy()
    for _ in range(ITERATIONS):
        system = normal_equations(distance, refined, ends, pull)
        for i in range(3):
            system[i, i] += DAMPING[i]
        step = _solved(system)
        refined += step
        if np.all(np.abs(step) < SMALL_STEP):
            break
    return refined


@kernel
def normal_equations(
    distance: NDArray[np.float32], pose: NDArray[np.float64], ends: NDArray[np.float64], pull: float
) -> NDArray[np.float64]:
    """Return J^T W J and -J^T W d side by side (3, 4), of the ends' distances d to a wall.

    J is their gradient by the pose, W falls with the distance over `pull`.
    """
    rows, cols = distance.shape
    system = np.zeros((3, 4))
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
        if abs(d) > FARTHEST_PULL * pull:
            continue
        gx = (b - a) * (1.0 - fy) + (e - c) * fy
        gy = (c - a) * (1.0 - fx) + (e - b) * fx
        turning = gy * dx - gx * dy
        weight = 1.0 / (1.0 + (d / pull) ** 2) ** 2
        system[0, 0] += weight * gx * gx
        system[0, 1] += weight * gx * gy
        system[0, 2] += weight * gx * turning
        system[1, 1] += weight * gy * gy
        system[1, 2] += weight * gy * turning
        system[2, 2] += weight * turning * turning
        system[0, 3] -= weight * gx * d
        system[1, 3] -= weight * gy * d
        system[2, 3] -= weight * turning * d
    system[1, 0], system[2, 0], system[2, 1] = system[0, 1], system[0, 2], system[1, 2]
    return system


@kernel
def _solved(system: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return x with a x = b for [a b] (3, 4), a positive, by Cholesky's factors written out."""
    l00 = np.sqrt(system[0, 0])
    l10, l20 = system[1, 0] / l00, system[2, 0] / l00
    l11 = np.sqrt(system[1, 1] - l10 * l10)
    l21 = (system[2, 1] - l20 * l10) / l11
    l22 = np.sqrt(system[2, 2] - l20 * l20 - l21 * l21)
    y0 = system[0, 3] / l00
    y1 = (system[1, 3] - l10 * y0) / l11
    y2 = (system[2, 3] - l20 * y0 - l21 * y1) / l22
    x2 = y2 / l22
    x1 = (y1 - l21 * x2) / l11
    return np.array([(y0 - l10 * x1 - l20 * x2) / l00, x1, x2])


@kernel
def weigh_poses(
    distance: NDArray[np.float32],
    poses: NDArray[np.float64],
    scan: Scan,
    scales: Scales,
    weights: Weights,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Refine poses (n, 3) of the robot on a scan and weigh each by its rays.

    Returns:
        The refined poses (n, 3), and per pose (n, 4) the evidence, the share of rays that met
        an obstacle as they should, the share that went through one, and the mean weight.
    """
    refined = np.empty_like(poses)
    sums = np.empty((len(poses), 4))
    for i in range(len(poses)):
        pose = refined_pose(distance, poses[i], scan.ends, scales.pull)
        moved = np.hypot(pose[0] - poses[i, 0], pose[1] - poses[i, 1])
        if moved > scales.moved or abs(pose[2] - poses[i, 2]) > scales.turned:
            pose = poses[i].copy()
        refined[i] = pose
        sums[i] = _weighed(distance, pose, scan, scales, weights)
    return refined, sums


@kernel
def _weighed(
    distance: NDArray[np.float32],
    pose: NDArray[np.float64],
    scan: Scan,
    scales: Scales,
    weights: Weights,
) -> NDArray[np.float64]:
    """Return what rays say of a pose: evidence, shares that met and went through, mean weight."""
    sums = np.zeros(4)
    if distance_at(distance, pose[0], pose[1]) < 0.5:
        sums[0], sums[3] = NOWHERE
        return sums
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    origin = np.empty(3)
    origin[0] = pose[0] + cos * scan.mount[0] - sin * scan.mount[1]
    origin[1] = pose[1] + sin * scan.mount[0] + cos * scan.mount[1]
    for ray in scan.rays:
        origin[2] = pose[2] + scan.mount[2] + ray[0]
        kind, place = _met(distance, origin, ray[1], scales)
        if ray[2] > 0.0:
            word = weights.silent[min(kind, 1)]
        else:
            word = weights.back[kind, place]
            sums[1] += kind == MET and place < 3
        sums[2] += kind == THROUGH
        sums[0] += ray[3] * word
        sums[3] += word
    sums[1:] /= max(1, len(scan.rays))
    return sums


@kernel
def _met(
    distance: NDArray[np.float32], origin: NDArray[np.float64], length: float, scales: Scales
) -> tuple[int, int]:
    """Return whether a ray went through an obstacle, met it or fell short; and its end's class."""
    x = origin[0] + length * np.cos(origin[2])
    y = origin[1] + length * np.sin(origin[2])
    end = distance_at(distance, x, y)
    place = 0
    while place < len(scales.limits) and (end == OFF or abs(end) >= scales.limits[place]):
        place += 1
    met = first_obstacle(distance, origin, length + 1.5 * scales.tolerance)
    if met > length + scales.tolerance:
        return SHORT, place
    if met >= length - scales.tolerance:
        return MET, place
    if place < 3 and not _leaves(distance, origin, met, length, scales.graze):
        return MET, place
    if _passes_beside(distance, origin, length, scales):
        return MET, place
    return THROUGH, place


@kernel
def _leaves(
    distance: NDArray[np.float32],
    origin: NDArray[np.float64],
    met: float,
    length: float,
    graze: float,
) -> bool:
    """Say whether a ray that met a wall at `met` gets away from all walls again before its end.

    Many maps draw walls thicker than they are, or not quite straight: a beam that ends within one,
    or that grazes along it, has met it.
    """
    cos, sin = np.cos(origin[2]), np.sin(origin[2])
    travelled = met
    while travelled < length:
        near = distance_at(distance, origin[0] + travelled * cos, origin[1] + travelled * sin)
        if abs(near) >= graze:
            return True
        travelled += max(graze - abs(near), LEAST_STEP)
    return False


@kernel
def _passes_beside(
    distance: NDArray[np.float32], origin: NDArray[np.float64], length: float, scales: Scales
) -> bool:
    """Say whether a ray a little beside or turned meets no obstacle before `length`.

    A beam along a wall grazes what the map rounds to cells, and one past a door its frame.
    """
    beside = origin.copy()
    for side in (-1.0, 1.0):
        beside[0] = origin[0] - side * scales.beside * np.sin(origin[2])
        beside[1] = origin[1] + side * scales.beside * np.cos(origin[2])
        beside[2] = origin[2]
        if first_obstacle(distance, beside, length) >= length - scales.tolerance:
            return True
        beside[:2] = origin[:2]
        beside[2] = origin[2] + side * TURNED
        if first_obstacle(distance, beside, length) >= length - scales.tolerance:
            return True
    return False


def warm_up() -> None:
    """Compile the kernels for the types they meet in service."""
    distance = np.ones((4, 4), np.float32)
    scan = Scan(np.ones((1, 2)), np.ones((1, 4)), np.zeros(3))
    scales = Scales(np.ones(4), 1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    weigh_poses(distance, np.ones((1, 3)), scan, scales, Weights(np.ones((3, 5)), np.ones(2)))
    normal_equations(distance, np.ones(3), np.ones((1, 2)), 1.0)
