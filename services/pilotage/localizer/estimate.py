"""What a localizer says and remembers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer.confidence import Signs
from pilotage.localizer.modes import Mode
from pilotage.localizer.verdict import State


@dataclass(frozen=True)
class Estimate:
    """What is believed: the best mode's pose (3,), covariance (3, 3), and how far to trust it.

    `matched`: share of the beams that meet what the map shows; `signs`: what the confidence
    came from. Both are None where there was no scan to tell by.
    """

    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]
    state: State
    confidence: float
    modes: list[Mode]
    matched: float | None
    signs: Signs | None = None


@dataclass(frozen=True)
class Memory:
    """A belief cut down to its heaviest states: poses (n, 3), weights (n,), and where it stood.

    `odom_from_base` (3,) and `stamp_ns` are of the last measurement.
    """

    poses: NDArray[np.float64]
    weights: NDArray[np.float64]
    odom_from_base: NDArray[np.float64]
    stamp_ns: int
    was_localized: bool
