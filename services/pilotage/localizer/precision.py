"""How exactly a place is known: the information that the fit of a scan gives.

The pose itself is refined in `evidence_kernels`, by Gauss-Newton on the distance from the ends
of the beams to the nearest wall. The curvature of that fit says how far the pose could
move without the ends leaving the walls; along a corridor it says nothing, and the spread of
the belief has to say it.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer.evidence_kernels import normal_equations
from pilotage.localizer.obstacles import Obstacles

END_SIGMA = 0.05
"""Standard deviation of a beam's end about the wall [m]: half a cell of a usual map and more."""

CORRELATED = 0.15
"""Share of a beam's information that counts: its neighbours meet the same wall."""

PULL = 0.25
"""Ends farther than this [m] from any wall tell nothing."""


def fitted_covariance(
    pose: NDArray[np.float64],
    ends: NDArray[np.float64],
    around: Obstacles,
    spread: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the covariance (3, 3), map frame, of a pose (3,) that a scan was fitted at.

    Args:
        pose: in map.
        ends: (n, 2) of the beams in base_link.
        around: the obstacles.
        spread: (3, 3) of the belief there, for the directions in which the fit says nothing.
    """
    cell = around.geometry.resolution
    pose_cells, ends_cells = around.in_cells(pose), ends / cell
    information = normal_equations(around.distance, pose_cells, ends_cells, PULL / cell)[:, :3]
    scale = np.array([1.0, 1.0, cell])
    information = information * np.outer(scale, scale) * (CORRELATED / END_SIGMA**2)
    cos, sin = np.cos(around.geometry.origin[2]), np.sin(around.geometry.origin[2])
    grid_from_map = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
    in_map = grid_from_map.T @ information @ grid_from_map
    covariance: NDArray[np.float64] = np.linalg.inv(in_map + np.linalg.inv(spread))
    return (covariance + covariance.T) / 2.0
