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
def best_fits(
    tiles: Tiles, chosen: NDArray[np.int64], mask: NDArray[np.float32], scan: Scan
) -> NDArray[np.float32]:
    """Return the likelihood (n,) of the best state in each of the chosen tiles (n, 3)."""
    best = np.zeros(len(chosen), np.float32)
    total = np.empty(SIDE * SIDE, np.uint16)
    for i in range(len(chosen)):
        k, row, col = _first_state(tiles.phases, chosen[i])
        _sum_tile_costs(total, scan, k, row * scan.width + col)
        for up in range(max(0, -row), min(SIDE, len(mask) - row)):
            for right in range(max(0, -col), min(SIDE, mask.shape[1] - col)):
                if mask[row + up, col + right] > 0.0:
                    best[i] = max(best[i], scan.likelihood[total[SIDE * up + right]])
    return best


@kernel
def wake_tiles(
    belief: Belief,
    tiles: Tiles,
    chosen: NDArray[np.int64],
    mask: NDArray[np.float32],
    scan: Scan,
) -> None:
    """Give the chosen tiles' (n, 3) masses to their states, evenly, and weigh each by the scan."""
    total = np.empty(SIDE * SIDE, np.uint16)
    for i in range(len(chosen)):
        k, row, col = _first_state(tiles.phases, chosen[i])
        tile_row, tile_col = chosen[i, 1], chosen[i, 2]
        count = tiles.counts[tiles.phases[k, 0], tiles.phases[k, 1], tile_row, tile_col]
        share = tiles.mass[k, tile_row, tile_col] / max(count, np.float32(1.0))
        tiles.mass[k, tile_row, tile_col] = np.float32(0.0)
        _sum_tile_costs(total, scan, k, row * scan.width + col)
        for up in range(max(0, -row), min(SIDE, len(mask) - row)):
            for right in range(max(0, -col), min(SIDE, mask.shape[1] - col)):
                fit = mask[row + up, col + right] * scan.likelihood[total[SIDE * up + right]]
                belief[k, row + up, col + right] += share * fit


@kernel
def _first_state(phases: NDArray[np.int64], tile: NDArray[np.int64]) -> tuple[int, int, int]:
    k = tile[0]
    return k, SIDE * (tile[1] - 1) + phases[k, 0], SIDE * (tile[2] - 1) + phases[k, 1]


@kernel
def _sum_tile_costs(total: NDArray[np.uint16], scan: Scan, k: int, at: int) -> None:
    """Set `total` (SIDE^2,) to the costs of a tile's states, those beyond the grid too."""
    total[:] = np.uint16(0)
    # All at once: integers of an array wrap round, where a tile begins beyond the grid.
    starts, width = scan.starts[k] + np.uint64(at), np.uint64(scan.width)
    n = len(starts)
    for b in range(0, n - 3, 4):
        _add_four_blocks(total, starts[b : b + 4], scan.costs, width)
    for b in range(n - n % 4, n):
        _add_block(total, starts[b], scan.costs, width)


@kernel
def _add_four_blocks(
    total: NDArray[np.uint16],
    starts: NDArray[np.uint64],
    costs: NDArray[np.uint8],
    width: np.uint64,
) -> None:
    a0, a1, a2, a3 = starts[0], starts[1], starts[2], starts[3]
    for up in range(SIDE):
        row, to = np.uint64(up) * width, np.uint64(up * SIDE)
        for right in range(SIDE):
            j = row + np.uint64(right)
            four = np.uint8(costs[a0 + j] + costs[a1 + j] + costs[a2 + j] + costs[a3 + j])
            total[to + np.uint64(right)] += np.uint16(four)


@kernel
def _add_block(
    total: NDArray[np.uint16], start: np.uint64, costs: NDArray[np.uint8], width: np.uint64
) -> None:
    for up in range(SIDE):
        row, to = start + np.uint64(up) * width, np.uint64(up * SIDE)
        for right in range(SIDE):
            total[to + np.uint64(right)] += np.uint16(costs[row + np.uint64(right)])


@kernel
def open_tiles(belief: Belief, tiles: Tiles, mask: NDArray[np.float32]) -> None:
    """Give all tiles' masses to their states, evenly."""
    headings, rows, cols = belief.shape
    share = np.empty(tiles.mass.shape[2], np.float32)
    for k in range(headings):
        up, right = tiles.phases[k]
        counts = tiles.counts[up, right]
        for row in range(rows):
            tile_row = (row + SIDE - up) // SIDE
            for col in range(len(share)):
                share[col] = tiles.mass[k, tile_row, col] / max(
                    counts[tile_row, col], np.float32(1.0)
                )
            for col in range(cols):
                belief[k, row, col] += share[(col + SIDE - right) // SIDE] * mask[row, col]
    tiles.mass[:] = np.float32(0.0)


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


@kernel
def spread_tiles(mass: NDArray[np.float32], share: float) -> None:
    """Give each tile `share` of each of its neighbours above, below, left and right.

    Only states at its edge can pass anything on, but they may hold all of it.
    """
    headings, rows, cols = mass.shape
    give = np.float32(share)
    before = np.empty((rows, cols), np.float32)
    for k in range(headings):
        layer = mass[k]
        before[:] = layer
        for row in range(rows):
            if row > 0:
                _add_row(layer[row], before[row - 1], give)
            if row + 1 < rows:
                _add_row(layer[row], before[row + 1], give)
        before[:] = layer
        for row in range(rows):
            _add_row(layer[row, 1:], before[row, :-1], give)
            _add_row(layer[row, :-1], before[row, 1:], give)


@kernel
def spread_tile_headings(tiles: Tiles, share: float, shifts: NDArray[np.int64]) -> None:
    """Give each tile `share` of all tiles of the neighbouring layers that reach into it.

    `shifts` as in `spread_headings`; a tile that only partly reaches in counts as a whole.
    """
    headings = len(tiles.mass)
    before = tiles.mass.copy()
    keep, give = np.float32(1.0 - 2.0 * share), np.float32(share)
    for k in range(headings):
        ahead, behind = (k + 1) % headings, (k - 1) % headings
        tiles.mass[k] *= keep
        apart = tiles.phases[k] - tiles.phases[ahead] - shifts[k]
        _add_reaching(tiles.mass[k], before[ahead], apart, give)
        apart = tiles.phases[k] - tiles.phases[behind] + shifts[behind]
        _add_reaching(tiles.mass[k], before[behind], apart, give)


@kernel
def _add_reaching(
    target: NDArray[np.float32],
    other: NDArray[np.float32],
    apart: NDArray[np.int64],
    give: np.float32,
) -> None:
    """Add `give` times the up to four tiles of another layer that lie `apart` (2,) states off."""
    rows, cols = target.shape
    up, right = apart[0] // SIDE, apart[1] // SIDE
    end_up, end_right = -(-apart[0] // SIDE) + 1, -(-apart[1] // SIDE) + 1
    for row in range(rows):
        for source in range(max(0, row + up), min(rows, row + end_up)):
            for aside in range(right, end_right):
                first, last = max(0, -aside), min(cols, cols - aside)
                if first < last:
                    _add_row(
                        target[row, first:last], other[source, first + aside : last + aside], give
                    )


@kernel
def _add_row(target: Row, source: Row, give: np.float32) -> None:
    for i in range(len(target)):
        target[i] += give * source[i]


@kernel
def runs_of_blocks(
    is_active: NDArray[np.bool_], rows: int, cols: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return runs and starts, as in Area, of the active blocks (headings, rows, cols)."""
    headings, block_rows, block_cols = is_active.shape
    stretches = np.empty((headings * block_rows * (block_cols // 2 + 1), 2), np.int64)
    runs = np.empty((SIDE * len(stretches), 3), np.int64)
    starts = np.zeros(headings + 1, np.int64)
    count = 0
    for k in range(headings):
        for block_row in range(block_rows):
            found = _find_stretches(is_active[k, block_row], stretches)
            for row in range(SIDE * block_row, min(SIDE * (block_row + 1), rows)):
                for i in range(found):
                    runs[count, 0] = row
                    runs[count, 1] = SIDE * stretches[i, 0]
                    runs[count, 2] = min(SIDE * stretches[i, 1], cols)
                    count += 1
        starts[k + 1] = count
    return runs[:count].copy(), starts


@kernel
def _find_stretches(is_active: NDArray[np.bool_], stretches: NDArray[np.int64]) -> int:
    """Set the first rows of `stretches` to first and end of what is active; return how many."""
    count, was_active = 0, False
    for i in range(len(is_active)):
        if is_active[i] and not was_active:
            stretches[count, 0] = i
            count += 1
        if is_active[i]:
            stretches[count - 1, 1] = i + 1
        was_active = is_active[i]
    return count
