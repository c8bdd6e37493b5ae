"""Passes over what is not worked on state by state: masses of tiles of SIDE x SIDE states.

Tile (row, col) of a layer holds the states from SIDE * (row - 1) + phase on, the phase being the
layer's own: so tiles move with their layer by whole cells, and no mass changes its tile. A tile's
mass is an upper bound of what its states weigh together.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels.areas import Area, Prior
from pilotage.localizer.kernels.costs import Scan, padded, sum_costs

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""

Row = NDArray[np.float32]

SIDE = 8

LEAST_FIT = np.float32(1e-30)
"""A tile's likelihood is no less, so that it can be taken back."""


class Tiles(NamedTuple):
    """Tiles over the layers of a belief.

    `mass`: (headings, tile rows, tile cols). `phases`: (headings, 2) in rows and columns, from 0
    to SIDE - 1. `counts`: (SIDE, SIDE, tile rows, tile cols) admissible states of each tile, by
    phase.
    """

    mass: NDArray[np.float32]
    phases: NDArray[np.int64]
    counts: NDArray[np.float32]


@kernel
def weigh_tiles(tiles: Tiles, prior: Prior, scan: Scan, fit: NDArray[np.float32]) -> None:
    """Multiply the prior of each tile by the most that a scan can say for any of its states.

    `scan` holds the least costs of SIDE x SIDE cells; `fit`, of the shape of the masses, is set
    to the likelihoods.
    """
    headings, rows, cols = tiles.mass.shape
    # One row after the other as a single one: what lies beyond the tiles is summed in vain.
    total = np.empty(padded(rows * scan.width), np.uint16)
    for k in range(headings):
        counts = tiles.counts[tiles.phases[k, 0], tiles.phases[k, 1]]
        gain = np.float32(prior.scale) * prior.heading[k]
        floor = np.float32(prior.floor) * prior.heading[k]
        sum_costs(total, scan.starts[k], scan.costs, 0)
        for row in range(rows):
            first = row * scan.width
            _look_up(fit[k, row], total[first : first + cols], scan.likelihood)
            _weigh_row(tiles.mass[k, row], counts[row], fit[k, row], gain, floor)


@kernel
def _look_up(fit: Row, total: NDArray[np.uint16], likelihood: Row) -> None:
    for i in range(len(fit)):
        fit[i] = max(likelihood[total[i]], LEAST_FIT)


@kernel
def _weigh_row(mass: Row, counts: Row, fit: Row, gain: np.float32, floor: np.float32) -> None:
    for i in range(len(mass)):
        # A tile of walls holds nothing, whatever has been counted into it.
        filled = min(counts[i], np.float32(1.0))
        mass[i] = (mass[i] * gain + floor * counts[i]) * filled * fit[i]


@kernel
def limit_of(mass: NDArray[np.float32], budget: float) -> float:
    """Return a power of two such that all tiles that weigh less weigh at most `budget` together."""
    by_exponent = np.zeros(256)
    flat = mass.reshape(mass.size)
    bits = flat.view(np.int32)
    for i in range(mass.size):
        by_exponent[bits[i] >> 23] += flat[i]
    below, exponent = 0.0, 0
    while exponent < 254 and below + by_exponent[exponent] <= budget:
        below += by_exponent[exponent]
        exponent += 1
    return 2.0 ** (exponent - 127)


@kernel
def sum_tiles(belief: Belief, area: Area, tiles: Tiles, runs: NDArray[np.float64]) -> Row:
    """Return what the states hold in each tile (headings, tile rows, tile cols).

    `runs` (n,) are the sums of the area's runs: those that hold nothing are passed over.
    """
    sums = np.zeros(tiles.mass.shape, np.float32)
    for k in range(len(belief)):
        up, right = tiles.phases[k]
        for i in range(area.starts[k], area.starts[k + 1]):
            row, left, end = area.runs[i]
            if runs[i] > 0.0:
                of_row = sums[k, (row + SIDE - up) // SIDE]
                for first in range(left - (left - right) % SIDE, end, SIDE):
                    piece = belief[k, row, max(left, first) : min(end, first + SIDE)]
                    of_row[(first + SIDE - right) // SIDE] += _sum(piece)
    return sums


@kernel
def _sum(piece: Row) -> np.float32:
    total = np.float32(0.0)
    for value in piece:
        total += value
    return total


@kernel
def retire(
    belief: Belief, area: Area, tiles: Tiles, sums: NDArray[np.float32], limit: float
) -> NDArray[np.bool_]:
    """Move from the states to the tiles what the area holds in tiles of at most `limit`.

    `sums` are those of `sum_tiles`. Return which blocks (headings, rows, cols), SIDE x SIDE cells
    of the grid, still hold something.
    """
    headings, rows, cols = belief.shape
    blocks = (headings, (rows + SIDE - 1) // SIDE, (cols + SIDE - 1) // SIDE)
    is_kept = np.zeros(blocks, np.bool_)
    for k in range(headings):
        up, right = tiles.phases[k]
        for row, left, end in area.runs[area.starts[k] : area.starts[k + 1]]:
            tile_row = (row + SIDE - up) // SIDE
            for first in range(left - (left - right) % SIDE, end, SIDE):
                tile_col = (first + SIDE - right) // SIDE
                start, stop = max(left, first), min(end, first + SIDE)
                held = sums[k, tile_row, tile_col]
                if held > limit:
                    is_kept[k, row // SIDE, start // SIDE] = True
                    is_kept[k, row // SIDE, (stop - 1) // SIDE] = True
                elif held > 0.0:
                    tiles.mass[k, tile_row, tile_col] += _sum(belief[k, row, start:stop])
                    belief[k, row, start:stop] = np.float32(0.0)
    return is_kept
