"""Kernels of the particle filter for sparse scans: propose, weigh, and remember what was seen."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.mapper.wall_kernels import wall_of


class Cloud(NamedTuple):
    """What n particles believe: each the robot's recent way, and so what it saw on it.

    `poses` (n, 3) now; `senses` (n,) are -1 where odometry is believed to count a way back as one
    ahead; `scales` (n, 2) logarithms by which odometry's errors in way and turn differ from what is
    expected; `ways` (n, w, 4) the poses and senses at the last w scans, and `seen` (n, w, b, 2) the
    points of these in the frame of the poses, both a ring.
    """

    poses: NDArray[np.float64]
    senses: NDArray[np.float64]
    scales: NDArray[np.float64]
    ways: NDArray[np.float64]
    seen: NDArray[np.float32]


class Moved(NamedTuple):
    """A step of odometry, how far it may be off, and chances of what else may have happened.

    `increment` (3,); standard deviations `way` m and `turn` rad; chances that a particle's sense
    turns `back` and `ahead` again, of an error four times as large (`rough`), and that the wheels
    slipped (`slip`); `wander` of the logarithms of the scales, which stay within `scale_limits`.
    """

    increment: NDArray[np.float64]
    way: float
    turn: float
    back: float
    ahead: float
    rough: float
    slip: float
    wander: float
    scale_limits: tuple[float, float]


class Sight(NamedTuple):
    """How points are weighed: `sigma` m of them, `reach` m around that a wall is told from.

    A point may be of something else with a chance of `stray`; `unknown` is the log-likelihood of
    one where nothing was seen.
    """

    sigma: float
    reach: float
    stray: float
    unknown: float


@kernel
def propose(
    cloud: Cloud, moved: Moved, normals: NDArray[np.float64], uniforms: NDArray[np.float64]
) -> None:
    """Move each particle by a way that odometry allows.

    `normals` (n, 5) are standard normal numbers, `uniforms` (n, 4) numbers from 0 to 1.
    """
    low, high = moved.scale_limits
    for n in range(len(cloud.poses)):
        for a in range(2):
            scale = cloud.scales[n, a] + moved.wander * normals[n, 3 + a]
            scale = 2.0 * high - scale if scale > high else scale
            cloud.scales[n, a] = 2.0 * low - scale if scale < low else scale
        chance = moved.back if cloud.senses[n] > 0.0 else moved.ahead
        if uniforms[n, 0] < chance:
            cloud.senses[n] = -cloud.senses[n]
        rough = 4.0 if uniforms[n, 1] < moved.rough else 1.0
        way, turn = moved.way * np.exp(cloud.scales[n, 0]), moved.turn * np.exp(cloud.scales[n, 1])
        ahead = cloud.senses[n] * moved.increment[0]
        if uniforms[n, 2] < moved.slip:
            ahead *= uniforms[n, 3]
        dx = ahead + rough * way * normals[n, 0]
        dy = cloud.senses[n] * moved.increment[1] + way * normals[n, 1]
        error = rough * turn * normals[n, 2]
        # The heading errs all along the way, half of it on average.
        heading = cloud.poses[n, 2] + 0.5 * error
        cos, sin = np.cos(heading), np.sin(heading)
        cloud.poses[n, 0] += cos * dx - sin * dy
        cloud.poses[n, 1] += sin * dx + cos * dy
        cloud.poses[n, 2] += moved.increment[2] + error


@kernel
def weigh(
    cloud: Cloud, counts: NDArray[np.int64], points: NDArray[np.float64], sight: Sight
) -> NDArray[np.float64]:
    """Return each particle's log-likelihood (n,) of points (k, 2) in the robot's frame.

    A point belongs on the wall that the points of the particle's recent scans (`counts` (w,) of
    them) show there.
    """
    found = np.zeros(len(cloud.poses))
    for n in range(len(cloud.poses)):
        pose = cloud.poses[n]
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        for i in range(len(points)):
            x = pose[0] + cos * points[i, 0] - sin * points[i, 1]
            y = pose[1] + sin * points[i, 0] + cos * points[i, 1]
            found[n] += _log_likelihood(cloud.seen[n], counts, x, y, sight)
    return found


@kernel
def _log_likelihood(
    seen: NDArray[np.float32], counts: NDArray[np.int64], x: float, y: float, sight: Sight
) -> float:
    near = np.float32(sight.reach * sight.reach)
    px, py = np.float32(x), np.float32(y)
    weight, sx, sy, sxx, sxy, syy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for w in range(len(counts)):
        for b in range(counts[w]):
            ex, ey = seen[w, b, 0] - px, seen[w, b, 1] - py
            square = ex * ex + ey * ey
            if square < near:
                g = 1.0 - square / near
                weight += g
                sx += g * ex
                sy += g * ey
                sxx += g * ex * ex
                sxy += g * ex * ey
                syy += g * ey * ey
    kind, (_, _, off, spread) = wall_of(weight, (sx, sy), (sxx, sxy, syy))
    if kind == 0:
        return sight.unknown
    own = sight.sigma * sight.sigma
    variance = own + spread
    fit = np.exp(-0.5 * off * off / variance)
    return float(np.log(sight.stray + (1.0 - sight.stray) * fit) - 0.25 * np.log(variance / own))


@kernel
def note(cloud: Cloud, slot: int, points: NDArray[np.float64]) -> None:
    """Note pose, sense and points (k, 2), in the robot's frame, of each particle in a slot."""
    for n in range(len(cloud.poses)):
        pose = cloud.poses[n]
        cloud.ways[n, slot, :3] = pose
        cloud.ways[n, slot, 3] = cloud.senses[n]
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        for i in range(len(points)):
            cloud.seen[n, slot, i, 0] = pose[0] + cos * points[i, 0] - sin * points[i, 1]
            cloud.seen[n, slot, i, 1] = pose[1] + sin * points[i, 0] + cos * points[i, 1]
