"""What a cell's last slices of time decide (Li 2008, 4.7): noise does not last.

A slice is what a few rounds together say of a cell: occupied (1) or free (0); slices that do not
see the cell leave it alone. Votes are the bits of a byte, the latest the lowest.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

FREE_VOTE, OCCUPIED_VOTE, UNDECIDED = 0, 1, 2
MOST_VOTES = 8
LEAST_SAID = 0.8
"""Log-odds of a slice that is no vote but a rumour: the cell is 0 or 1 by less than 0.69."""


def verdict(votes: int, count: int) -> int:
    """Return what `count` votes say: 000, 001, 010, 100 free; 011, 110, 111 occupied.

    101 is decided by five: occupied if four of them say so or three that do not just alternate,
    which is noise of the sensor. Fewer votes than asked for decide nothing.
    """
    if count < 3:
        return UNDECIDED
    if votes & 7 != 0b101:
        return OCCUPIED_VOTE if (votes & 7).bit_count() >= 2 else FREE_VOTE
    if count < 5:
        return UNDECIDED
    five = votes & 31
    is_occupied = five.bit_count() >= 3 and five != 0b10101
    return OCCUPIED_VOTE if is_occupied else FREE_VOTE


VERDICTS = np.array(
    [[verdict(votes, count) for votes in range(256)] for count in range(MOST_VOTES + 1)], np.uint8
)
"""`VERDICTS[count, votes]` for all there are."""


@kernel
def close_slice(
    log_odds: NDArray[np.float32],
    window: NDArray[np.float32],
    votes: NDArray[np.uint8],
    counts: NDArray[np.uint8],
    limit: float,
) -> None:
    """Add a slice to the log-odds, let its cells vote, and empty it.

    All are (rows, cols) and changed in place; the log-odds stay within +-limit.
    """
    rows, cols = window.shape
    for row in range(rows):
        for col in range(cols):
            said = window[row, col]
            if said != 0.0:
                log_odds[row, col] = min(limit, max(-limit, log_odds[row, col] + said))
                window[row, col] = 0.0
                if abs(said) >= LEAST_SAID:
                    vote = 1 if said > 0.0 else 0
                    votes[row, col] = ((int(votes[row, col]) << 1) | vote) & 255
                    counts[row, col] = min(MOST_VOTES, int(counts[row, col]) + 1)


def warm_up() -> None:
    """Compile the kernel for the types met in service: windows of larger layers."""
    layer, bits = np.ones((2, 2), np.float32)[:1, :1], np.zeros((2, 2), np.uint8)[:1, :1]
    close_slice(layer, layer.copy()[:1, :1], bits, bits, 1.0)
