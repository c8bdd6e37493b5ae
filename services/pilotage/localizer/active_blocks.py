"""Which blocks (headings, rows, cols) of SIDE x SIDE cells of the grid are worked on."""

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer.kernels import SIDE

Blocks = NDArray[np.bool_]


def no_blocks(shape: tuple[int, ...]) -> Blocks:
    """Return the blocks of a belief of `shape` (headings, rows, cols), none being active."""
    headings, rows, cols = shape
    return np.zeros((headings, -(-rows // SIDE), -(-cols // SIDE)), bool)


def widened(blocks: Blocks, cells: int) -> Blocks:
    """Return the blocks with all those within `cells` cells of them in the same layer."""
    for _ in range(-(-cells // SIDE)):
        wider = blocks.copy()
        wider[:, 1:] |= blocks[:, :-1]
        wider[:, :-1] |= blocks[:, 1:]
        blocks = wider.copy()
        blocks[:, :, 1:] |= wider[:, :, :-1]
        blocks[:, :, :-1] |= wider[:, :, 1:]
    return blocks


def with_neighbours(blocks: Blocks) -> Blocks:
    """Return the blocks with the same blocks of the layers on both sides, all the way round."""
    return blocks | np.roll(blocks, 1, axis=0) | np.roll(blocks, -1, axis=0)


def add_tiles(blocks: Blocks, tiles: NDArray[np.int64], phases: NDArray[np.int64]) -> None:
    """Make the blocks active that tiles (n, 3) of layers with `phases` (headings, 2) reach into."""
    k = tiles[:, 0]
    low = SIDE * (tiles[:, 1:] - 1) + phases[k]
    ends = np.array(blocks.shape[1:]) - 1
    for up in (0, SIDE - 1):
        for right in (0, SIDE - 1):
            # Beyond the grid there is nothing: the nearest block is as good as any.
            row, col = np.clip((low + np.array((up, right))) // SIDE, 0, ends).T
            blocks[k, row, col] = True
