"""Kernel that tells the wall at a place from the points around it."""

import numpy as np

from pilotage.core.jit import kernel

LEAST_WEIGHT = 1.5
"""Of the points around, each weighing one where it is and zero at the reach."""
LEAST_SPREAD = 0.03
"""m; points that lie no farther apart show no direction."""

Wall = tuple[float, float, float, float]


@kernel
def wall_of(
    weight: float, first: tuple[float, float], second: tuple[float, float, float]
) -> tuple[int, Wall]:
    """Return what weighted points around a place show, and the wall.

    Args:
        weight: their sum of weights.
        first: weighted sums of x and y, seen from the place.
        second: weighted sums of xx, xy and yy.

    Returns:
        0 and nothing if there are too few; 1 if they are a lump and 2 if they are a wall; then its
        normal, how far the place is from it along the normal (of a lump: from its middle, and no
        normal), and the variance of the points across it.
    """
    if weight < LEAST_WEIGHT:
        return 0, (0.0, 0.0, 0.0, 0.0)
    x, y = first[0] / weight, first[1] / weight
    xx, xy = second[0] / weight - x * x, second[1] / weight - x * y
    yy = second[2] / weight - y * y
    half, root = 0.5 * (xx + yy), np.sqrt(0.25 * (xx - yy) ** 2 + xy * xy)
    if half + root < LEAST_SPREAD**2:
        return 1, (0.0, 0.0, np.sqrt(x * x + y * y), LEAST_SPREAD**2)
    along = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    nx, ny = -np.sin(along), np.cos(along)
    return 2, (nx, ny, -(nx * x + ny * y), max(half - root, 0.0))
