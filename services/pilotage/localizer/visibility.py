"""What a beam may not see through (methods E): the evidence that a likelihood field leaves out.

The field asks only whether a beam ends near a wall. A wrong pose in a furnished building often
ends its beams near some wall; what it cannot hide is a beam that goes through a wall of the map,
for what the map lacks makes readings shorter, and hardly anything makes them longer.

The expected range of every state is kept as the largest among its neighbours in x, y and
heading, so that neither the rounding to cells nor a grazing beam nor a door frame is punished.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.range_table import expected_ranges
from pilotage.localizer.range_model import LEVELS, RangeTable


@dataclass(frozen=True)
class VisibilityParams:
    """Parameters of the visibility term.

    `reach`: how far walls are looked for [m]. `margin`: by how much a beam must be too long [m].
    `penalty`: -log of the factor for each such beam.
    """

    reach: float = 16.0
    margin: float = 0.3
    penalty: float = 0.2


def optimistic_ranges(
    world: OccupancyMap, geometry: GridGeometry, headings: int, params: VisibilityParams
) -> RangeTable:
    """Return the largest expected range in the 3 x 3 x 3 neighbourhood of each state.

    Its levels are even steps of `reach` / 255: the margin is the same near and far.
    """
    levels = even_levels(expected_ranges(world, geometry, headings, params.reach), params.reach)
    levels = np.maximum(levels, np.maximum(np.roll(levels, 1, 0), np.roll(levels, -1, 0)))
    for axis in (1, 2):
        levels = _largest_of_three(levels, axis)
    return RangeTable(levels, params.reach)


def even_levels(ranges: NDArray[np.floating], reach: float) -> NDArray[np.uint8]:
    """Return each range [m] in steps of `reach` / 255; LEVELS for all from `reach` on."""
    levels: NDArray[np.float64] = np.floor(ranges * (LEVELS / reach) + 0.5)
    return np.clip(levels, 0, LEVELS).astype(np.uint8)


def levels_allowed(ranges: NDArray[np.float64], params: VisibilityParams) -> NDArray[np.uint8]:
    """Return the least expected level (n,) at which a beam of each range (n,) is not too long."""
    least = (np.minimum(ranges, params.reach) - params.margin) * (LEVELS / params.reach)
    return np.clip(np.floor(least), 0, LEVELS).astype(np.uint8)


def _largest_of_three(levels: NDArray[np.uint8], axis: int) -> NDArray[np.uint8]:
    """Return each value's maximum with its two neighbours along an axis (none beyond the ends)."""
    largest = levels.copy()
    ahead, behind = [slice(None)] * 3, [slice(None)] * 3
    ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
    np.maximum(largest[tuple(ahead)], levels[tuple(behind)], out=largest[tuple(ahead)])
    np.maximum(largest[tuple(behind)], levels[tuple(ahead)], out=largest[tuple(behind)])
    return largest
