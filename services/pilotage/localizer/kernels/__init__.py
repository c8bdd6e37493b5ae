"""Passes over the belief: float32 (headings, rows, cols), one layer per heading.

States that are not admissible hold nothing after each measurement, and only runs of columns
with admissible ones among them are worked on. Each pass has a plain twin in
tests/naive/markov.py.
"""

import numpy as np

from pilotage.localizer.kernels.areas import Admissible
from pilotage.localizer.kernels.moving import shift_layer, spread_headings, spread_layer
from pilotage.localizer.kernels.summing import Runs, sum_headings, sum_logarithms, sum_runs
from pilotage.localizer.kernels.weighing import (
    Prior,
    Sight,
    add_floor,
    weigh_ranges,
    weigh_scan,
    weigh_visibility,
)

__all__ = [
    "Admissible",
    "Prior",
    "Runs",
    "Sight",
    "add_floor",
    "shift_layer",
    "spread_headings",
    "spread_layer",
    "sum_headings",
    "sum_logarithms",
    "sum_runs",
    "weigh_ranges",
    "weigh_scan",
    "weigh_visibility",
]


def warm_up() -> None:
    """Compile every kernel for the types it meets in service."""
    belief = np.ones((2, 3, 3), np.float32)
    area = Admissible(np.ones((3, 3), np.float32), np.array([[0, 0, 3], [2, 0, 3]]))
    tables = np.zeros((2, 3, 3), np.uint8)
    pair = np.zeros((2, 5, 3), np.int64)
    ones = np.ones(5 * 255 + 1, np.float32)
    add_floor(belief, area, Prior(1.0, 0.0, np.ones(2, np.float32)))
    weigh_scan(belief, area, pair, tables, ones)
    sight = Sight(np.zeros((2, 1), np.int64), np.zeros(1, np.uint8), np.float32(0.0))
    weigh_visibility(belief, area, sight, tables, ones)
    weigh_ranges(belief, area, np.zeros((2, 1), np.int64), tables, np.ones((1, 256), np.float32))
    runs = sum_runs(belief, area)
    sum_headings(belief, area, runs.mass, 0.0)
    sum_logarithms(belief, belief.view(np.int32), area, runs.mass)
    shift_layer(belief[0], 1, 1)
    spread_layer(belief[0], 0.1)
    spread_headings(belief, 0.1, np.zeros((2, 2), np.int64))
