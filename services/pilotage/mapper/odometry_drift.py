"""How far odometry may be off after a step: what a scan matcher may search, and believe."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap


@dataclass(frozen=True)
class DriftParams:
    """Errors of odometry as a random walk, and in proportion.

    On the generous side of what raw odometry of indoor robots shows (Freiburg 079: 5 degrees after
    0.8 m): a guess too sure of itself is worse than a search too wide.
    """

    way_per_root_metre: float = 0.04
    """m of error after 1 m, growing with the square root of the way."""
    way_share: float = 0.05
    """m of error per m of way: wheels of another size than believed."""
    turn_per_root_metre: float = 0.07
    """rad of error after 1 m, growing with the square root of the way."""
    turn_share: float = 0.10
    """rad of error per rad of turn."""
    standing: tuple[float, float] = (0.005, 0.005)
    """m and rad: what is never known better, standing or not."""


def drift_covariance(increment: NDArray[np.float64], params: DriftParams) -> NDArray[np.float64]:
    """Return the covariance (3, 3) of an odometry increment (3,), in the frame it starts in."""
    way = float(np.hypot(increment[0], increment[1]))
    turn = abs(wrap(float(increment[2])))
    of_way = params.standing[0] ** 2 + params.way_per_root_metre**2 * way
    of_way += (params.way_share * way) ** 2
    of_turn = params.standing[1] ** 2 + params.turn_per_root_metre**2 * way
    of_turn += (params.turn_share * turn) ** 2
    # The heading errs all along the way, half of it on average.
    lever = np.array([-0.5 * increment[1], 0.5 * increment[0], 1.0])
    spread: NDArray[np.float64] = np.diag([of_way, of_way, 0.0]) + of_turn * np.outer(lever, lever)
    return spread


def step_sigmas(increments: NDArray[np.float64], params: DriftParams) -> NDArray[np.float64]:
    """Return the standard deviations in m and rad (n, 2) of odometry increments (n, 3)."""
    way = np.hypot(increments[:, 0], increments[:, 1])
    turn = np.abs(wrap(increments[:, 2]))
    of_way = params.standing[0] ** 2 + params.way_per_root_metre**2 * way
    of_turn = params.standing[1] ** 2 + params.turn_per_root_metre**2 * way
    of_way = of_way + (params.way_share * way) ** 2
    of_turn = of_turn + (params.turn_share * turn) ** 2
    sigmas: NDArray[np.float64] = np.sqrt(np.stack([of_way, of_turn], axis=1))
    return sigmas


def moved_covariance(
    pose: NDArray[np.float64],
    covariance: NDArray[np.float64],
    increment: NDArray[np.float64],
    drift: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the covariance (3, 3) of a pose (3,) after an increment (3,) with its own `drift`.

    Covariances of poses are over x, y and theta along the axes of the frame that the pose is in;
    that of the increment along those of the pose.
    """
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    ahead = np.array(
        [cos * increment[0] - sin * increment[1], sin * increment[0] + cos * increment[1]]
    )
    moved = np.array([[1.0, 0.0, -ahead[1]], [0.0, 1.0, ahead[0]], [0.0, 0.0, 1.0]])
    turned = turned_covariance(float(pose[2]), drift)
    carried: NDArray[np.float64] = moved @ covariance @ moved.T + turned
    return carried


def turned_covariance(angle: float, covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a covariance (3, 3) along axes that were turned back by `angle`."""
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    turned: NDArray[np.float64] = turn @ covariance @ turn.T
    return turned
