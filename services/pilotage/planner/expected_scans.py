"""What a laser would see from each place where the robot could be; pure.

Ranges come from a table over the whole map, so that a scan expected at a place costs as many
look-ups as it has beams. Two places are told apart by a scan as far as the ranges expected from
them differ: each beam by a Gaussian, bounded because unmapped things stand about, and all beams
tempered because neighbours tell the same (as the localizer weighs them).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.jit import kernel, reduction
from pilotage.core.range_table import expected_ranges
from pilotage.planner.information import LogLikelihoods

Scans = NDArray[np.float32]
"""Expected ranges (beams, n) [m]; all around, or those within a window."""

HEADINGS = 72
LEVELS = 255


@dataclass(frozen=True)
class SightParams:
    """How a laser is expected to see.

    `range_max` [m]; `beams`: directions all around that are compared; `resolution`: cells of the
    table, at least the map's [m]; `sigma` [m] and `sigma_per_metre`: how far a range may be off,
    the place's own width and heading included; `bound`: largest cost of one beam [nat];
    `tempering`: weight of a beam among its neighbours.
    """

    range_max: float = 12.0
    beams: int = 36
    resolution: float = 0.2
    sigma: float = 0.25
    sigma_per_metre: float = 0.05
    bound: float = 3.0
    tempering: float = 0.3


class ExpectedScans:
    """The table of a map."""

    def __init__(self, world: OccupancyMap, params: SightParams) -> None:
        self.params = params
        ratio = max(1, round(params.resolution / world.geometry.resolution))
        cell = ratio * world.geometry.resolution
        rows, cols = (-(-length // ratio) for length in world.geometry.shape)
        self.geometry = GridGeometry(rows, cols, cell, world.geometry.origin)
        ranges = expected_ranges(world, self.geometry, HEADINGS, params.range_max)
        levels = np.rint(ranges * (LEVELS / params.range_max)).astype(np.uint8)
        # (rows, cols, headings): all that is looked up for a place lies side by side.
        self._levels = np.ascontiguousarray(levels.transpose(1, 2, 0))

    def at(self, poses: NDArray[np.float64], window: tuple[float, float] = (0.0, np.pi)) -> Scans:
        """Return the scans (beams, n) expected from poses (n, 3) of the map frame [m].

        `window`: its middle, off the heading, and half of its width [rad].
        """
        turn = 2.0 * np.pi
        in_grid = self.geometry.grid_from_map(poses[:, :2]) / self.geometry.resolution
        states = np.column_stack([in_grid, poses[:, 2] * (HEADINGS / turn)])
        beams: NDArray[np.float64] = np.linspace(0.0, turn, self.params.beams, endpoint=False)
        seen = beams[np.abs(wrap(beams - window[0])) <= window[1] + 1e-9]
        offsets = seen * (HEADINGS / turn)
        step = self.params.range_max / LEVELS
        return _looked_up(self._levels, states, offsets, step)

    def log_likelihoods(self, scans: Scans, truths: NDArray[np.int64]) -> LogLikelihoods:
        """Return (m, n): how well the scan expected at place truths[i] fits each of n places."""
        params = self.params
        spread = params.sigma, params.sigma_per_metre
        return _compared(scans, truths, spread, params.bound, params.tempering)


@kernel
def _looked_up(
    levels: NDArray[np.uint8],
    states: NDArray[np.float64],
    offsets: NDArray[np.float64],
    step: float,
) -> Scans:
    """Return ranges (beams, n) at states (n, 3): x, y in cells, heading in bins.

    `offsets` (beams,): of each beam off the heading, in bins.
    """
    rows, cols, headings = levels.shape
    ranges = np.zeros((len(offsets), len(states)), np.float32)
    for j in range(len(states)):
        col, row = int(np.floor(states[j, 0])), int(np.floor(states[j, 1]))
        if 0 <= row < rows and 0 <= col < cols:
            for b in range(len(offsets)):
                heading = round(states[j, 2] + offsets[b]) % headings
                ranges[b, j] = levels[row, col, heading] * step
    return ranges


@kernel
def _compared(
    scans: Scans,
    truths: NDArray[np.int64],
    spread: tuple[float, float],
    bound: float,
    tempering: float,
) -> LogLikelihoods:
    """Return -tempering * sum over beams of min(bound, (difference / sigma)^2 / 2), (m, n)."""
    costs = np.zeros((len(truths), scans.shape[1]), np.float32)
    for i in range(len(truths)):
        for b in range(len(scans)):
            seen = scans[b, truths[i]]
            sigma = spread[0] + spread[1] * seen
            _add_costs(costs[i], scans[b], seen, np.float32(0.5 / sigma**2), np.float32(bound))
    for i in range(len(truths)):
        for j in range(costs.shape[1]):
            costs[i, j] *= -tempering
    return costs


@reduction
def _add_costs(
    costs: NDArray[np.float32],
    ranges: NDArray[np.float32],
    seen: np.float32,
    precision: np.float32,
    bound: np.float32,
) -> None:
    """Add a beam's bounded cost for each of the places (n,); on slices, so that it vectorises."""
    for j in range(len(costs)):
        off = ranges[j] - seen
        costs[j] += min(bound, off * off * precision)


def warm_up() -> None:
    """Compile the kernels."""
    scans = _looked_up(np.zeros((1, 1, 1), np.uint8), np.zeros((1, 3)), np.zeros(1), 1.0)
    _compared(scans, np.zeros(1, np.int64), (1.0, 0.0), 1.0, 1.0)
