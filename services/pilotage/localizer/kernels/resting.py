"""Passes over what is not worked on state by state: masses of tiles of SIDE x SIDE states.

Tile (row, col) of a layer holds the states from SIDE * (row - 1) + phase on, the phase being the
layer's own: so tiles move with their layer by whole cells, and no mass changes its tile.

Two upper bounds are kept: of what a tile's states weigh together, and of what its heaviest state
weighs. Spreading can only raise the first, as nobody knows where in a tile its mass lies, and
never the largest of the second; but the second says little of a tile with a single heavy state.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels.areas import Prior
from pilotage.localizer.kernels.costs import Scan, padded, sum_costs

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""

Row = NDArray[np.float32]

SIDE = 8


class Tiles(NamedTuple):
    """Tiles over the layers of a belief.

    `mass` and `peak`: (headings, tile rows, tile cols), of all states and of the heaviest one.
    `phases`: (headings, 2) in rows and columns, from 0 to SIDE - 1. `counts`: (SIDE, SIDE, tile
    rows, tile cols) admissible states of each tile, by phase.
    """

    mass: NDArray[np.float32]
    peak: NDArray[np.float32]
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
            _weigh_peaks(tiles.peak[k, row], fit[k, row], gain, floor)
            _weigh_masses(
                tiles.mass[k, row], tiles.peak[k, row], counts[row], fit[k, row], (gain, floor)
            )


@kernel
def _look_up(
    fit: NDArray[np.float32], total: NDArray[np.uint16], likelihood: NDArray[np.float32]
) -> None:
    for i in range(len(fit)):
        fit[i] = likelihood[total[i]]


@kernel
def _weigh_peaks(peak: Row, fit: Row, gain: np.float32, floor: np.float32) -> None:
    for i in range(len(peak)):
        peak[i] = (peak[i] * gain + floor) * fit[i]


@kernel
def _weigh_masses(
    mass: Row, peak: Row, counts: Row, fit: Row, gain_floor: tuple[np.float32, np.float32]
) -> None:
    gain, floor = gain_floor
    for i in range(len(mass)):
        value = (mass[i] * gain + floor * counts[i]) * fit[i]
        # Also clears tiles of walls, which hold nothing, whatever has been counted into them.
        mass[i] = min(value, counts[i] * peak[i])
        peak[i] = min(peak[i], mass[i])  # no state is heavier than its tile


@kernel
def limit_of(mass: NDArray[np.float32], budget: float) -> float:
    """Return a power of two such that all tiles that weigh less weigh at most `budget` together."""
    by_exponent = np.zeros(256)
    flat = mass.reshape(mass.size)
    bits = flat.view(np.int32)
    for i in range(mass.size):
        by_exponent[bits[i] >> 23] += flat[i]
    below, exponent = 0.0, 0
    while exponent < 255 and below + by_exponent[exponent] <= budget:
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
        mass = tiles.mass[chosen[i, 0], chosen[i, 1], chosen[i, 2]]
        tiles.mass[chosen[i, 0], chosen[i, 1], chosen[i, 2]] = 0.0
        tiles.peak[chosen[i, 0], chosen[i, 1], chosen[i, 2]] = 0.0
        count = tiles.counts[tiles.phases[k, 0], tiles.phases[k, 1], chosen[i, 1], chosen[i, 2]]
        if count > 0.0:
            _sum_tile_costs(total, scan, k, row * scan.width + col)
            for up in range(max(0, -row), min(SIDE, len(mask) - row)):
                for right in range(max(0, -col), min(SIDE, mask.shape[1] - col)):
                    share = mass / count * mask[row + up, col + right]
                    fit = scan.likelihood[total[SIDE * up + right]]
                    belief[k, row + up, col + right] += share * fit


@kernel
def _first_state(phases: NDArray[np.int64], tile: NDArray[np.int64]) -> tuple[int, int, int]:
    k = tile[0]
    return k, SIDE * (tile[1] - 1) + phases[k, 0], SIDE * (tile[2] - 1) + phases[k, 1]


@kernel
def _sum_tile_costs(total: NDArray[np.uint16], scan: Scan, k: int, at: int) -> None:
    """Set `total` (SIDE^2,) to the costs of a tile's states, those beyond the grid too."""
    total[:] = np.uint16(0)
    starts, base, width = scan.starts[k], np.uint64(at), np.uint64(scan.width)
    n = len(starts)
    for b in range(0, n - 3, 4):
        _add_four_blocks(total, starts[b : b + 4], scan.costs, base, width)
    for b in range(n - n % 4, n):
        _add_block(total, starts[b] + base, scan.costs, width)


@kernel
def _add_four_blocks(
    total: NDArray[np.uint16],
    starts: NDArray[np.uint64],
    costs: NDArray[np.uint8],
    base: np.uint64,
    width: np.uint64,
) -> None:
    a0, a1, a2, a3 = base + starts[0], base + starts[1], base + starts[2], base + starts[3]
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
                count = counts[tile_row, col]
                mass = tiles.mass[k, tile_row, col]
                share[col] = mass / count if count > 0.0 else np.float32(0.0)
            for col in range(cols):
                belief[k, row, col] += share[(col + SIDE - right) // SIDE] * mask[row, col]
    tiles.mass[:] = np.float32(0.0)
    tiles.peak[:] = np.float32(0.0)


@kernel
def sum_tiles(
    belief: Belief, boxes: NDArray[np.int64], phases: NDArray[np.int64], sums: NDArray[np.float32]
) -> None:
    """Add to `sums` (headings, tile rows, tile cols) what boxes (n, 4) hold in each tile."""
    for low, high, left, end in boxes:
        for k in range(len(belief)):
            up, right = phases[k]
            for row in range(low, high):
                of_row = sums[k, (row + SIDE - up) // SIDE]
                for first in range(left - (left - right) % SIDE, end, SIDE):
                    piece = belief[k, row, max(left, first) : min(end, first + SIDE)]
                    of_row[(first + SIDE - right) // SIDE] += _sum(piece)


@kernel
def _sum(piece: Row) -> np.float32:
    total = np.float32(0.0)
    for value in piece:
        total += value
    return total


@kernel
def retire(
    belief: Belief,
    boxes: NDArray[np.int64],
    tiles: Tiles,
    sums: NDArray[np.float32],
    limit: float,
) -> NDArray[np.bool_]:
    """Move from the states to the tiles what boxes (n, 4) hold in tiles of at most `limit`.

    `sums` are those of `sum_tiles`. Return which blocks, SIDE x SIDE cells of the grid, still
    hold something.
    """
    rows, cols = belief.shape[1:]
    is_kept = np.zeros(((rows + SIDE - 1) // SIDE, (cols + SIDE - 1) // SIDE), np.bool_)
    for low, high, left, end in boxes:
        for k in range(len(belief)):
            up, right = tiles.phases[k]
            for row in range(low, high):
                tile_row = (row + SIDE - up) // SIDE
                for first in range(left - (left - right) % SIDE, end, SIDE):
                    tile_col = (first + SIDE - right) // SIDE
                    start, stop = max(left, first), min(end, first + SIDE)
                    if sums[k, tile_row, tile_col] > limit:
                        is_kept[row // SIDE, start // SIDE] = True
                        is_kept[row // SIDE, (stop - 1) // SIDE] = True
                    elif sums[k, tile_row, tile_col] > 0.0:
                        mass = _sum(belief[k, row, start:stop])
                        tiles.mass[k, tile_row, tile_col] += mass
                        # What the tile holds already may lie in the same state.
                        tiles.peak[k, tile_row, tile_col] += mass
                        belief[k, row, start:stop] = np.float32(0.0)
    return is_kept


@kernel
def spread_tiles(tiles: Tiles, share: float) -> None:
    """Bound what is left in each tile when states give `share` above, below, left and right.

    Only states at a tile's edge pass anything to the next one, but they may hold all of it; and
    no state has neighbours in the tiles on both sides.
    """
    headings, rows, cols = tiles.mass.shape
    give = np.float32(share)
    before = np.empty((rows, cols), np.float32)
    for k in range(headings):
        mass, peak = tiles.mass[k], tiles.peak[k]
        before[:] = mass
        for row in range(rows):
            if row > 0:
                _add_row(mass[row], before[row - 1], give)
            if row + 1 < rows:
                _add_row(mass[row], before[row + 1], give)
        before[:] = mass
        for row in range(rows):
            _add_row(mass[row, 1:], before[row, :-1], give)
            _add_row(mass[row, :-1], before[row, 1:], give)
        before[:] = peak
        for row in range(rows):
            below, above = before[max(0, row - 1)], before[min(rows - 1, row + 1)]
            _raise_row(peak[row], before[row], below, above, give)
        before[:] = peak
        for row in range(rows):
            here = before[row]
            _raise_row(peak[row, 1:-1], here[1:-1], here[:-2], here[2:], give)
            peak[row, 0] += give * max(np.float32(0.0), here[1] - here[0])
            peak[row, -1] += give * max(np.float32(0.0), here[-2] - here[-1])


@kernel
def _raise_row(target: Row, here: Row, before: Row, after: Row, give: np.float32) -> None:
    """Set each value to what it can become by `give` of the larger of its neighbours."""
    for i in range(len(target)):
        most = max(here[i], before[i], after[i])
        target[i] = here[i] + give * (most - here[i])


@kernel
def spread_tile_headings(tiles: Tiles, share: float, shifts: NDArray[np.int64]) -> None:
    """Bound what is left in each tile when states give `share` to the neighbouring layers.

    `shifts` as in `spread_headings`; a tile that only partly reaches in counts as a whole.
    """
    headings, rows, cols = tiles.mass.shape
    masses, peaks = tiles.mass.copy(), tiles.peak.copy()
    reaching = np.empty((rows, cols), np.float32)
    keep, give = np.float32(1.0 - 2.0 * share), np.float32(share)
    for k in range(headings):
        ahead, behind = (k + 1) % headings, (k - 1) % headings
        tiles.mass[k] *= keep
        tiles.peak[k] *= keep
        to_ahead = tiles.phases[k] - tiles.phases[ahead] - shifts[k]
        to_behind = tiles.phases[k] - tiles.phases[behind] + shifts[behind]
        for other, apart in ((ahead, to_ahead), (behind, to_behind)):
            _sum_reaching(reaching, masses[other], apart)
            _add_layer(tiles.mass[k], reaching, give)
            _largest_reaching(reaching, peaks[other], apart)
            _add_layer(tiles.peak[k], reaching, give)


@kernel
def _add_layer(target: NDArray[np.float32], source: NDArray[np.float32], give: np.float32) -> None:
    for row in range(len(target)):
        _add_row(target[row], source[row], give)


@kernel
def _sum_reaching(
    target: NDArray[np.float32], other: NDArray[np.float32], apart: NDArray[np.int64]
) -> None:
    """Set `target` to the sums of the up to four tiles that lie `apart` (2,) states off."""
    target[:] = np.float32(0.0)
    rows, cols = target.shape
    for row in range(rows):
        for source in _reached(row, apart[0], rows):
            for aside in range(apart[1] // SIDE, -(-apart[1] // SIDE) + 1):
                first, last = max(0, -aside), min(cols, cols - aside)
                if first < last:
                    _add_row(
                        target[row, first:last],
                        other[source, first + aside : last + aside],
                        np.float32(1.0),
                    )


@kernel
def _largest_reaching(
    target: NDArray[np.float32], other: NDArray[np.float32], apart: NDArray[np.int64]
) -> None:
    """Set `target` to the largest of the up to four tiles that lie `apart` (2,) states off."""
    target[:] = np.float32(0.0)
    rows, cols = target.shape
    for row in range(rows):
        for source in _reached(row, apart[0], rows):
            for aside in range(apart[1] // SIDE, -(-apart[1] // SIDE) + 1):
                first, last = max(0, -aside), min(cols, cols - aside)
                if first < last:
                    _raise_to(target[row, first:last], other[source, first + aside : last + aside])


@kernel
def _reached(row: int, apart: int, rows: int) -> range:
    """Return the rows of tiles that lie `apart` states off a row of tiles."""
    return range(max(0, row + apart // SIDE), min(rows, row - (-apart // SIDE) + 1))


@kernel
def _raise_to(target: Row, source: Row) -> None:
    for i in range(len(target)):
        target[i] = max(target[i], source[i])


@kernel
def _add_row(target: Row, source: Row, give: np.float32) -> None:
    for i in range(len(target)):
        target[i] += give * source[i]


@kernel
def boxes_of(is_kept: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the boxes (n, 4), in blocks, round the kept blocks that touch, corners too."""
    rows, cols = is_kept.shape
    left_over, stack = is_kept.copy(), [(0, 0)]
    boxes = np.empty((rows * cols, 4), np.int64)
    count = 0
    for row in range(rows):
        for col in range(cols):
            if left_over[row, col]:
                boxes[count] = np.array([row, row + 1, col, col + 1])
                stack.append((row, col))
                left_over[row, col] = False
                while len(stack) > 1:
                    _take_block(stack, left_over, boxes[count])
                count += 1
    return boxes[:count]


@kernel
def _take_block(
    stack: list[tuple[int, int]], left_over: NDArray[np.bool_], box: NDArray[np.int64]
) -> None:
    """Widen the box by the block on top of the stack, and put its neighbours there instead."""
    row, col = stack.pop()
    box[0], box[1] = min(box[0], row), max(box[1], row + 1)
    box[2], box[3] = min(box[2], col), max(box[3], col + 1)
    for r in range(max(0, row - 1), min(len(left_over), row + 2)):
        for c in range(max(0, col - 1), min(left_over.shape[1], col + 2)):
            if left_over[r, c]:
                left_over[r, c] = False
                stack.append((r, c))
