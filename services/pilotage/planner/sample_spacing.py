"""How far apart the samples of a belief lie, each standing for its surroundings; pure.

Gordon, Salmond & Smith 1993, "Novel approach to nonlinear/non-Gaussian Bayesian state
estimation": n samples of a belief of extent E in d dimensions lie about K E n^(-1/d) apart, with
K of 0.2. What a sensor tells apart more finely than that, it tells of chances of the sample.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import circular_mean, wrap
from pilotage.planner.situation import Hypotheses

K = 0.2
EXTENT = float(np.sqrt(12.0))
"""Of a uniform belief, in standard deviations."""


def sample_spacing(belief: Hypotheses) -> NDArray[np.float64]:
    """Return the spacing (3,) of x, y [m] and heading [rad]; 0 when all samples are one."""
    weights, poses = belief.weights, belief.poses
    turns = wrap(poses[:, 2] - circular_mean(poses[:, 2], weights))
    off = np.column_stack([poses[:, :2] - weights @ poses[:, :2], turns])
    extent = EXTENT * np.sqrt(weights @ off**2)
    spacing: NDArray[np.float64] = K * len(weights) ** (-1.0 / 3.0) * extent
    return spacing
