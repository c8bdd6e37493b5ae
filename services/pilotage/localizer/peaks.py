"""The summits of a belief: heavy states with no heavier one beside them."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

BESIDE_WAY, BESIDE_TURN = 0.4, 0.2
"""States nearer than this [m, rad] to a heavier summit are its slopes."""


def find_peaks(
    poses: NDArray[np.float64], weights: NDArray[np.float64], most: int
) -> NDArray[np.float64]:
    """Return the `most` highest summits (m, 3) of states (n, 3) with weights (n,)."""
    order = np.argsort(-weights, kind="stable")
    chosen = summits(np.ascontiguousarray(poses[order]), most, BESIDE_WAY, BESIDE_TURN)
    return poses[order][chosen]


@kernel
def summits(
    poses: NDArray[np.float64], most: int, beside_way: float, beside_turn: float
) -> NDArray[np.int64]:
    """Return which of the poses (n, 3), by falling weight, lie beside no earlier summit."""
    chosen = np.empty(most, np.int64)
    count = 0
    for i in range(len(poses)):
        is_summit = True
        for j in range(count):
            other = poses[chosen[j]]
            away = (poses[i, 0] - other[0]) ** 2 + (poses[i, 1] - other[1]) ** 2
            if away <= beside_way**2:
                turn = abs(poses[i, 2] - other[2]) % (2.0 * np.pi)
                if min(turn, 2.0 * np.pi - turn) <= beside_turn:
                    is_summit = False
                    break
        if is_summit:
            chosen[count] = i
            count += 1
            if count == most:
                break
    return chosen[:count]


def warm_up() -> None:
    """Compile the kernel for the types it meets in service."""
    find_peaks(np.zeros((1, 3)), np.ones(1), 1)
