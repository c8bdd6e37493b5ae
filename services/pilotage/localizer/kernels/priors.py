"""What every measurement begins with: the prior of eq. 8, layer by layer."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels.areas import Prior, Runs


@kernel
def no_runs(count: int) -> Runs:
    """Return sums and maxima of so many runs that hold nothing."""
    return Runs(np.zeros(count), np.zeros(count, np.float32))


@kernel
def prior_of(prior: Prior, k: int) -> tuple[np.float32, np.float32]:
    """Return what the layer k is multiplied by, and what is added to each of its states."""
    heading = prior.heading[k]
    return np.float32(prior.scale) * heading, np.float32(prior.floor) * heading


@kernel
def clear(layer: NDArray[np.float32], gaps: NDArray[np.int64]) -> None:
    """Empty what lies between the runs."""
    for row, first, last in gaps:
        layer[row, first:last] = np.float32(0.0)
