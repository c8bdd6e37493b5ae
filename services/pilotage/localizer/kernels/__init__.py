"""Passes over the belief: float32 (headings, rows, cols), one layer per heading.

States that are not admissible hold nothing after each measurement, and only runs of columns
with admissible ones among them are worked on. Each pass has a plain twin in
tests/naive/markov.py.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer.kernels.areas import (
    Admissible,
    Area,
    Prior,
    Runs,
    in_all_layers,
    whole_area,
)
from pilotage.localizer.kernels.blocks import runs_of_blocks
from pilotage.localizer.kernels.costs import LANES, MOST_COST, Scan
from pilotage.localizer.kernels.moving import shift_layers, spread_headings, spread_layers
from pilotage.localizer.kernels.ranging import Echoes, echoes_of, shift_levels, weigh_ranges
from pilotage.localizer.kernels.resting import (
    LEAST_FIT,
    SIDE,
    Tiles,
    limit_of,
    retire,
    sum_tiles,
    weigh_tiles,
)
from pilotage.localizer.kernels.seeing import Sight, weigh_visibility
from pilotage.localizer.kernels.spreading import spread_tile_headings, spread_tiles
from pilotage.localizer.kernels.summing import (
    states_above,
    sum_headings,
    sum_logarithms,
    sum_runs,
)
from pilotage.localizer.kernels.waking import best_fits, first_state, open_tiles, wake_tiles
from pilotage.localizer.kernels.weighing import weigh_prior, weigh_scan

__all__ = [
    "LANES",
    "LEAST_FIT",
    "MOST_COST",
    "SIDE",
    "Admissible",
    "Area",
    "Echoes",
    "Prior",
    "Runs",
    "Scan",
    "Sight",
    "Tiles",
    "best_fits",
    "echoes_of",
    "first_state",
    "in_all_layers",
    "limit_of",
    "open_tiles",
    "retire",
    "runs_of_blocks",
    "shift_layers",
    "shift_levels",
    "spread_headings",
    "spread_layers",
    "spread_tile_headings",
    "spread_tiles",
    "states_above",
    "sum_headings",
    "sum_logarithms",
    "sum_runs",
    "sum_tiles",
    "wake_tiles",
    "weigh_prior",
    "weigh_ranges",
    "weigh_scan",
    "weigh_tiles",
    "weigh_visibility",
    "whole_area",
]


def warm_up() -> None:
    """Compile every kernel for the types it meets in service."""
    belief = np.ones((2, 3, 3), np.float32)
    area, prior = whole_area(belief.shape), Prior(1.0, 0.0, np.ones(2, np.float32))
    _warm_up_weighing(belief, area, prior)
    runs = sum_runs(belief, area)
    sum_headings(belief, area, runs.mass, 0.0)
    states_above(belief, area, np.zeros(1, np.int64), 0.0)
    sum_logarithms(belief, belief.view(np.int32), area, runs.mass)
    shift_layers(belief, area, np.ones((2, 2), np.int64))
    spread_layers(belief, area, 0.1)
    spread_headings(belief, area, 0.1, np.zeros((2, 2), np.int64))
    _warm_up_resting(belief, area, prior)


def _scan() -> Scan:
    """A scan of one beam that ends nowhere, wherever it is looked up."""
    starts = np.zeros((2, 1), np.uint64)
    costs = np.zeros(4096 + LANES, np.uint8)
    return Scan(starts, costs, 4, np.ones(MOST_COST + 1, np.float32))


def _warm_up_weighing(belief: NDArray[np.float32], area: Area, prior: Prior) -> None:
    levels, directions = np.zeros((2, 3, 3), np.uint8), np.zeros((2, 1), np.int64)
    runs = weigh_prior(belief, area, prior)
    weigh_scan(belief, area, prior, _scan())
    likelihoods = shift_levels(np.ones((1, 2), np.float32), np.arange(2.0), np.zeros((2, 1)))
    weigh_ranges(belief, area, prior, echoes_of(directions, levels, likelihoods))
    allowed, likelihood = np.zeros(1, np.uint8), np.ones(2, np.float32)
    sight = Sight(directions, levels, allowed, likelihood, np.float32(0.0))
    weigh_visibility(belief, area, runs, sight)


def _warm_up_resting(belief: NDArray[np.float32], area: Area, prior: Prior) -> None:
    counts = np.ones((SIDE, SIDE, 2, 2), np.float32)
    tiles = Tiles(np.ones((2, 2, 2), np.float32), np.zeros((2, 2), np.int64), counts)
    chosen = np.array([[0, 1, 1]])
    weigh_tiles(tiles, prior, _scan(), np.ones((2, 2, 2), np.float32))
    limit_of(tiles.mass, 1.0)
    best_fits(tiles, chosen, area.mask, _scan())
    wake_tiles(belief, tiles, chosen, area.mask, _scan())
    sums = sum_tiles(belief, area, tiles, sum_runs(belief, area).mass)
    runs_of_blocks(retire(belief, area, tiles, sums, 0.0), 3, 3)
    open_tiles(belief, tiles, area.mask)
    spread_tiles(tiles.mass, 0.1)
    spread_tile_headings(tiles, 0.1, np.zeros((2, 2), np.int64))
