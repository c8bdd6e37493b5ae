"""Where a scan fits best on a piece of map: correlative search first, then sub-cell refinement."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.mapper.matching_kernels import normal_equations
from pilotage.mapper.surfel_kernels import SurfelMap


@dataclass(frozen=True)
class MatchParams:
    """How points are weighed against surfels, m."""

    across: float = 0.03
    """Standard deviation of a point across its wall: the laser's and the surfel's noise."""
    along: float = 3.0
    """The same along a straight wall, where a point says next to nothing."""
    scales: tuple[float, ...] = (0.15, 0.08, 0.05)
    """Residuals beyond this count less and less; tighter from stage to stage."""
    iterations: int = 12
    """At most so many steps a stage."""
    worth: float = 4.0
    """Points of one scan are worth so many independent ones."""


Prior = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Information (3, 3) and mean (3,) of what is known without the scan."""


@dataclass(frozen=True, eq=False)
class Match:
    """A scan's pose (3,) on a map, its information (3, 3), and how well it fits.

    `information` is that of the points alone; `cost` the mean robust
    cost, 0 perfect to 1 nothing fits; `seen` the share of points near any surfel.
    """

    pose: NDArray[np.float64]
    information: NDArray[np.float64]
    cost: float
    seen: float


def refine(
    surfels: SurfelMap,
    points: NDArray[np.float64],
    start: NDArray[np.float64],
    params: MatchParams,
    prior: Prior | None = None,
) -> Match:
    """Return the pose (3,) of points (n, 2) on the map next to `start`, by Gauss-Newton.

    With a prior the result is the most probable pose. Points of one scan err together (the map's
    errors, the laser's bias), so the information that is returned is that of no more than
    `params.worth` independent ones.
    """
    held, expected = (np.zeros((3, 3)), start) if prior is None else prior
    share = min(1.0, params.worth / max(1, len(points)))
    pose = np.array(start, float)
    H, cost, seen = np.zeros((3, 3)), 1.0, 0
    for scale in params.scales:
        sigmas = params.across, params.along, scale
        for _ in range(params.iterations):
            H, g, cost, seen = normal_equations(pose, points, surfels, sigmas)
            off = pose - expected
            off[2] = wrap(float(off[2]))
            step = -np.linalg.solve(H + held + 1e-9 * np.eye(3), g + held @ off)
            pose += step
            if np.abs(step[:2]).max() < 1e-4 and abs(step[2]) < 1e-5:
                break
    pose[2] = wrap(float(pose[2]))
    return Match(pose, share * H, cost, seen / max(1, len(points)))
