"""Where particles may be after a motion that odometry measured."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.motion import OdometryNoise, sample_odometry
from pilotage.localizer import particle_kernels as kernels
from pilotage.localizer.markov_grid import MotionSpread

MotionModel = MotionSpread | OdometryNoise
"""Variances that grow along the way, as the Markov grid's; or AMCL's alpha1 to alpha4."""


def predict(
    poses: NDArray[np.float64],
    increment: NDArray[np.float64],
    motion: MotionModel,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return poses (n, 3) moved by odometry's increment (3,), each with an error of its own."""
    if isinstance(motion, OdometryNoise):
        return sample_odometry(poses, increment, motion, rng)
    errors = rng.standard_normal((len(poses), 3))
    moved = poses.copy()
    kernels.move(moved, increment + errors * standard_deviations(increment, motion))
    return moved


def standard_deviations(
    increment: NDArray[np.float64], motion: MotionSpread
) -> NDArray[np.float64]:
    """Return the standard deviations (3,) of x, y [m] and theta [rad] after an increment (3,)."""
    way, turn = float(np.hypot(increment[0], increment[1])), abs(float(increment[2]))
    across = motion.translation**2 * way + motion.translation_from_turn**2 * turn
    around = motion.rotation**2 * turn + motion.rotation_from_way**2 * way
    deviations: NDArray[np.float64] = np.sqrt(np.array([across, across, around]))
    return deviations
