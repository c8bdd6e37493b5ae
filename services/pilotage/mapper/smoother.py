"""The most probable way of a robot whose scans are too sparse to be matched one by one.

All poses are moved at once (Gauss-Newton): neighbours are tied by what odometry says, and each
point is drawn to the wall that the points seen from other poses show.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.mapper.smoother_kernels import Pull, binned, pull_to_walls, solve_banded

Array = NDArray[np.float64]

HELD = 1e8
"""Information that holds the first pose where it is."""
FAINT = 1e-6
"""Information that keeps every system solvable."""


@dataclass(frozen=True)
class SmootherParams:
    """How a way is smoothed."""

    sigma: float = 0.03
    """m; standard deviation of a point across its wall."""
    reach: float = 0.3
    """m around a point within which others show its wall."""
    scales: tuple[float, ...] = (0.3, 0.2, 0.1)
    """m; residuals beyond this count less and less, tighter from stage to stage."""
    iterations: int = 5
    """Steps a stage."""
    share: float = 1.0
    """Of a step so much is taken; half of it where two passes are drawn to each other, lest they
    change places."""
    nearest: int = 1
    """Points of poses nearer than so many numbers are not compared."""
    farthest: int = 1 << 40
    """Nor are points of poses farther apart."""
    doubt: float = 3.0
    """Standard deviations of odometry beyond which it is believed less and less."""
    least: float = 0.02
    """But so much of it always is."""


@dataclass(frozen=True, eq=False)
class Chain:
    """Poses (n, 3) and what odometry says of each next one, seen from the one before.

    `relative` (n - 1, 3) with `information` (n - 1, 3, 3) of its error: a small motion of the next
    pose in its own frame.
    """

    poses: Array
    relative: Array
    information: Array


@dataclass(frozen=True, eq=False)
class Views:
    """Points (n, 2), each in the frame of the pose that saw it: number `owners` (n,)."""

    points: Array
    owners: NDArray[np.int64]


def views_of(points: list[Array]) -> Views:
    """Return the points (k, 2) seen from each pose as one."""
    owners = np.repeat(np.arange(len(points)), [len(seen) for seen in points])
    return Views(np.concatenate([np.empty((0, 2)), *points]), owners)


def smoothed(chain: Chain, views: Views, params: SmootherParams) -> tuple[Array, Array]:
    """Return the most probable poses (n, 3), the first one held.

    And the information (n, 3, 3) that the points alone give each, along the axes of the poses'
    frame, turning about the pose.
    """
    poses, known = chain.poses.copy(), np.zeros((len(chain.poses), 3, 3))
    if not len(views.points):
        return poses, known
    for scale in params.scales:
        pull = Pull(params.sigma, scale, params.nearest, params.farthest)
        for _ in range(params.iterations):
            points = placed(poses, views)
            known, g = pull_to_walls(
                poses, points, views.owners, binned(points, params.reach), pull
            )
            step = params.share * _step(poses, chain, (known, g), params)
            poses += step
            poses[:, 2] = wrap(poses[:, 2])
            if np.abs(step).max() < 1e-4:
                break
    return poses, known


def placed(poses: Array, views: Views) -> Array:
    """Return the points (n, 2) in the frame of the poses."""
    seen_from = poses[views.owners]
    cos, sin = np.cos(seen_from[:, 2]), np.sin(seen_from[:, 2])
    x, y = views.points[:, 0], views.points[:, 1]
    return seen_from[:, :2] + np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


def _step(poses: Array, chain: Chain, pulls: tuple[Array, Array], params: SmootherParams) -> Array:
    """Return the motions (n, 3) of the poses that one step of Gauss-Newton says."""
    own, g = pulls[0] + FAINT * np.eye(3), pulls[1].copy()
    own[0] += HELD * np.eye(3)
    error, first, second = _odometry(poses, chain.relative)
    chi = np.einsum("ni,nij,nj->n", error, chain.information, error)
    belief = 1.0 / (1.0 + chi / params.doubt**2) ** 2 + params.least
    weight = belief[:, None, None] * chain.information
    own[:-1] += _transposed(first) @ weight @ first
    own[1:] += _transposed(second) @ weight @ second
    across = _transposed(first) @ weight @ second
    pulled = (weight @ error[:, :, None])[:, :, 0]
    g[:-1] += np.einsum("nij,ni->nj", first, pulled)
    g[1:] += np.einsum("nij,ni->nj", second, pulled)
    return solve_banded(_band(own, across), -g.ravel()).reshape(-1, 3)


def _odometry(poses: Array, relative: Array) -> tuple[Array, Array, Array]:
    """Return errors (n - 1, 3) of odometry and their derivatives by both poses (n - 1, 3, 3)."""
    error = se2.between(relative, se2.between(poses[:-1], poses[1:]))
    heading = poses[:-1, 2] + relative[:, 2]
    cos, sin = np.cos(heading), np.sin(heading)
    dx, dy = (poses[1:, :2] - poses[:-1, :2]).T
    second = np.zeros((len(error), 3, 3))
    second[:, 0, 0], second[:, 0, 1] = cos, sin
    second[:, 1, 0], second[:, 1, 1] = -sin, cos
    second[:, 2, 2] = 1.0
    first = -second
    first[:, 0, 2] = -sin * dx + cos * dy
    first[:, 1, 2] = -cos * dx - sin * dy
    return error, first, second


def _band(own: Array, across: Array) -> Array:
    """Return the band (3n, 6) of a matrix of blocks (3, 3) on and beside the diagonal."""
    band = np.zeros((3 * len(own), 6))
    for a in range(3):
        for b in range(a + 1):
            band[a::3, a - b] = own[:, a, b]
        for b in range(3):
            band[3 + a :: 3, 3 + a - b] = across[:, b, a]
    return band


def _transposed(matrices: Array) -> Array:
    return np.swapaxes(matrices, 1, 2)
