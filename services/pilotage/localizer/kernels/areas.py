"""Where on its layers a belief may hold anything, and where it is worked on."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

NONE = np.empty((0, 3), np.int64)


class Admissible(NamedTuple):
    """Where the robot may stand.

    `mask`: (rows, cols) 1 or 0. `runs`: (n, 3) row, first and last + 1 column of the stretches
    that hold all ones of the mask, in order of rows and columns. `gaps`: (n, 3) the stretches
    between them; what has moved into these is cleared by the next measurement.
    """

    mask: NDArray[np.float32]
    runs: NDArray[np.int64]
    gaps: NDArray[np.int64] = NONE


class Runs(NamedTuple):
    """Sum and maximum (headings, runs) of each run of the belief after a measurement."""

    mass: NDArray[np.float64]
    peak: NDArray[np.float32]


class Prior(NamedTuple):
    """What a state weighs before the measurement: belief * `scale` + `floor`, times `heading`.

    `heading` (headings,) is the compass's likelihood of each layer. `floor` is the paper's P0
    times the recovery weight (eq. 8); 0 gives M1.
    """

    scale: float
    floor: float
    heading: NDArray[np.float32]
