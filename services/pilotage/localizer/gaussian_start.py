"""A belief around a pose that somebody states, as weights of the states in a window around it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.localizer.pose_grid import PoseGrid

REACH = 5.0
"""Standard deviations: beyond them the belief begins with nothing."""


@dataclass(frozen=True)
class StartWindow:
    """Weights (headings, n, m), the best at most 1, of the cells `rows` x `cols` of the grid."""

    rows: slice
    cols: slice
    weights: NDArray[np.float32]


def gaussian_start(
    grid: PoseGrid, map_from_base: ArrayLike, covariance: NDArray[np.float64]
) -> StartWindow:
    """Return the belief around a pose; ValueError if it is no belief or nowhere in free space.

    Args:
        grid: the states, their layers at headings 0, 1, ... times the heading step.
        map_from_base: (3,).
        covariance: (3, 3) over x, y, theta, map frame; widened to the width of a state.
    """
    geometry = grid.geometry
    pose = se2.compose(se2.inverse(geometry.origin), map_from_base)
    spread = _in_grid(_checked(covariance), geometry.origin[2])
    spread += np.diag(np.array([geometry.resolution] * 2 + [grid.heading_step]) / 2.0) ** 2
    rows, dy = _near(pose[1], spread[1, 1], geometry.rows, geometry.resolution)
    cols, dx = _near(pose[0], spread[0, 0], geometry.cols, geometry.resolution)
    information = np.linalg.inv(spread)
    mask = grid.admissible.mask[rows, cols]
    weights = np.empty((grid.headings, *mask.shape), np.float32)
    for k in range(grid.headings):
        turn = wrap(k * grid.heading_step - float(pose[2]))
        away = np.stack(np.broadcast_arrays(dx, dy[:, None], turn), axis=-1)
        squared = np.einsum("...i,...i", away @ information, away)
        weights[k] = np.where(squared <= REACH**2, np.exp(-0.5 * squared), 0.0) * mask
    if not weights.any():
        raise ValueError("the pose is not in the map's free space")
    return StartWindow(rows, cols, weights)


def _checked(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a covariance made symmetric to the last bit; ValueError if it is none."""
    symmetric = (covariance + covariance.T) / 2.0
    is_one = np.allclose(covariance, symmetric) and np.linalg.eigvalsh(symmetric)[0] >= -1e-12
    if not is_one:
        raise ValueError("the covariance is not symmetric and positive")
    return symmetric


def _in_grid(covariance: NDArray[np.float64], grid_theta: float) -> NDArray[np.float64]:
    """Return a covariance of the map frame over the grid's own axes."""
    cos, sin = np.cos(grid_theta), np.sin(grid_theta)
    grid_from_map = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    turned: NDArray[np.float64] = grid_from_map @ covariance @ grid_from_map.T
    return turned


def _near(
    middle: float, variance: float, count: int, resolution: float
) -> tuple[slice, NDArray[np.float64]]:
    """Return the cells of one axis within reach of `middle` [m], and how far (n,) they lie off."""
    bounds = (middle + np.array([-REACH, REACH]) * np.sqrt(variance)) / resolution
    first, end = np.clip([np.floor(bounds[0]), np.ceil(bounds[1])], 0, count).astype(int)
    return slice(first, end), (np.arange(first, end) + 0.5) * resolution - middle
