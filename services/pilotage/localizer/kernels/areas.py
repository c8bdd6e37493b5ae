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


class Area(NamedTuple):
    """What is worked on in each layer.

    `mask` as in Admissible. `runs`: (n, 3) row, first and last + 1 column, in order of layers,
    rows and columns; layer k has those from `starts[k]` to `starts[k + 1]`, (headings + 1,).
    `gaps`: (n, 3) what is to be cleared in every layer.
    """

    mask: NDArray[np.float32]
    runs: NDArray[np.int64]
    starts: NDArray[np.int64]
    gaps: NDArray[np.int64]


class Runs(NamedTuple):
    """Sum and maximum (n,) of each run of an area after a measurement."""

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


def in_all_layers(admissible: Admissible, headings: int) -> Area:
    """Return the area of all admissible states of `headings` layers."""
    starts = len(admissible.runs) * np.arange(headings + 1)
    runs = np.tile(admissible.runs, (headings, 1))
    return Area(admissible.mask, runs, starts, admissible.gaps)


def whole_area(shape: tuple[int, ...]) -> Area:
    """Return all cells of all layers of a belief of `shape` (headings, rows, cols)."""
    headings, rows, cols = shape
    runs = np.column_stack(np.broadcast_arrays(np.arange(rows), 0, cols)).astype(np.int64)
    return in_all_layers(Admissible(np.ones((rows, cols), np.float32), runs), headings)
