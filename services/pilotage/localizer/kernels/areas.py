"""Where on its layers a belief may hold anything."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Admissible(NamedTuple):
    """Where the robot may stand.

    `mask`: (rows, cols) 1 or 0. `runs`: (n, 3) row, first and last + 1 column of the stretches
    that hold all ones of the mask, in order of rows and columns.
    """

    mask: NDArray[np.float32]
    runs: NDArray[np.int64]
