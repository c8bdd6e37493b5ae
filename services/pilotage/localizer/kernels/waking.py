"""Passes that give tiles back to the states that they stand for (see resting)."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels.costs import Scan
from pilotage.localizer.kernels.resting import SIDE, Tiles

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""


@kernel
def best_fits(
    tiles: Tiles, chosen: NDArray[np.int64], mask: NDArray[np.float32], scan: Scan
) -> NDArray[np.float32]:
    """Return the likelihood (n,) of the best state in each of the chosen tiles (n, 3)."""
    best = np.zeros(len(chosen), np.float32)
    total = np.empty(SIDE * SIDE, np.uint16)
    for i in range(len(chosen)):
        k, row, col = first_state(tiles.phases, chosen[i])
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
        k, row, col = first_state(tiles.phases, chosen[i])
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
def first_state(phases: NDArray[np.int64], tile: NDArray[np.int64]) -> tuple[int, int, int]:
    """Return layer, row and column of the first state of a tile (3,); it may lie off the grid."""
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
