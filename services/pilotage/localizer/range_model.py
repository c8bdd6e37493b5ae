"""Few beams, each against its expected range (Wu & Bell 2003, eq. 5), by table look-up.

The paper's P(s | l) = N(s; o_l, delta^2) is completed by what real rangers do: an outlier
anywhere in the range, and no echo at all, likeliest where nothing is within reach. Expected
ranges are kept in one byte a state, in steps that grow with the range; each measured range turns
into a table of 256 likelihoods, so that a beam costs one look-up per state.

Even steps of 25 m / 255 would round each range by up to half a cell of 0.10 m, and a robot that
drives along a wall meets the same error of its distance all the way.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.range_table import expected_ranges

LEVELS = 255

FINEST = 0.25
"""The step near a robot, relative to an even one; the step at the end is 2 - FINEST of these.

Far walls may be rounded more: a heading bin moves them by more than that.
"""


@dataclass(frozen=True)
class RangeModelParams:
    """Parameters of the range model.

    `delta`: standard deviation of a range [m] (the paper's delta).
    `outlier`: likelihood of any reading, relative to the best [-].
    `no_echo`: probability that a wall within reach gives no echo [-].
    """

    delta: float = 0.15
    outlier: float = 0.05
    no_echo: float = 0.2


@dataclass(frozen=True)
class RangeTable:
    """Expected ranges (headings, rows, cols) uint8, see `ranges_of_levels`."""

    levels: NDArray[np.uint8]
    range_max: float


def ranges_of_levels(range_max: float) -> NDArray[np.float64]:
    """Return the range (256,) [m] that each level stands for."""
    share = np.arange(LEVELS + 1) / LEVELS
    ranges: NDArray[np.float64] = range_max * share * (FINEST + (1.0 - FINEST) * share)
    return ranges


def levels_of(ranges: NDArray[np.floating], range_max: float) -> NDArray[np.uint8]:
    """Return the level of each range [m]; LEVELS for all from `range_max` on."""
    share = np.clip(ranges / range_max, 0.0, 1.0)
    root = np.sqrt(FINEST**2 + 4.0 * (1.0 - FINEST) * share)
    levels: NDArray[np.float64] = (root - FINEST) / (2.0 * (1.0 - FINEST)) * LEVELS
    return np.rint(levels).astype(np.uint8)


def range_table(
    world: OccupancyMap, geometry: GridGeometry, headings: int, range_max: float
) -> RangeTable:
    """Return the expected range from each cell of `geometry` in each of `headings` directions.

    Direction k points along k * 2 pi / headings in the map frame; LEVELS means
    nothing within `range_max` [m].
    """
    turned = expected_ranges(world, geometry, headings, range_max)
    return RangeTable(levels_of(turned, range_max), range_max)


def range_likelihoods(
    ranges: NDArray[np.float64], range_max: float, params: RangeModelParams
) -> NDArray[np.float32]:
    """Return the likelihood (n, 256) of each measured range (n,) for each expected level.

    A range that is infinite or just `range_max` is "no echo"; a longer one, as of a sensor that
    sits ahead of the robot's centre, tells of a wall at `range_max` or beyond. Relative to the
    best, so that many beams stay in float32.
    """
    expected = ranges_of_levels(range_max)
    error = np.minimum(ranges, range_max)[:, None] - expected[None, :]
    hit = np.exp(-0.5 * (error / params.delta) ** 2)
    likelihood = (1.0 - params.outlier) * hit + params.outlier
    silent = np.where(expected >= range_max, 1.0, params.no_echo)
    is_heard = np.isfinite(ranges) & (ranges != range_max)
    return np.where(is_heard[:, None], likelihood, silent[None, :]).astype(np.float32)
