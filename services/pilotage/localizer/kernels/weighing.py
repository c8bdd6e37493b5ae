"""Passes that weigh the belief by what was measured.

Each reads and writes the belief once: prior, likelihood and the sums of the result in one pass.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel, reduction
from pilotage.localizer.kernels.areas import Area, Prior, Runs
from pilotage.localizer.kernels.costs import Scan, padded, sum_costs

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""

Levels = NDArray[np.uint8]
Four = tuple[Levels, Levels, Levels, Levels]

PIECE = 64
"""Columns that are looked at or passed over together."""


class Echoes(NamedTuple):
    """Single ranges, ready to be looked up.

    `directions`: (headings, n) layer of `levels` that each beam points along. `levels`: (table
    headings, rows, cols), see range_model. `likelihoods`: (n, 256) by expected level.
    """

    directions: NDArray[np.int64]
    levels: NDArray[np.uint8]
    likelihoods: NDArray[np.float32]


class Sight(NamedTuple):
    """Beams that must not go through walls.

    `directions`: (headings, n) layer of `levels` that each points along; `levels`: (table
    headings, rows, cols) optimistic expected ranges; `allowed`: (n,) level that the expected
    range must have at least; `likelihood`: (n + 1,) by number of beams that go through a wall;
    `least`: states below do not matter.
    """

    directions: NDArray[np.int64]
    levels: NDArray[np.uint8]
    allowed: NDArray[np.uint8]
    likelihood: NDArray[np.float32]
    least: np.float32


@kernel
def weigh_prior(belief: Belief, area: Area, prior: Prior) -> Runs:
    """Turn the belief into the prior of a measurement (eq. 8), zero where not admissible."""
    none = np.ones(belief.shape[2], np.float32)
    runs = _no_runs(len(area.runs))
    for k in range(len(belief)):
        _clear(belief[k], area.gaps)
        gain_floor = _prior_of(prior, k)
        for i in range(area.starts[k], area.starts[k + 1]):
            row, first, last = area.runs[i]
            run, mask = belief[k, row, first:last], area.mask[row, first:last]
            runs.mass[i], runs.peak[i] = _apply(run, mask, none, gain_floor)
    return runs


@kernel
def weigh_scan(belief: Belief, area: Area, prior: Prior, scan: Scan) -> Runs:
    """Multiply the prior by the likelihood of a scan, state by state."""
    runs = _no_runs(len(area.runs))
    total = np.empty(padded(belief.shape[2]), np.uint16)
    for k in range(len(belief)):
        _clear(belief[k], area.gaps)
        gain_floor = _prior_of(prior, k)
        for i in range(area.starts[k], area.starts[k + 1]):
            row, first, last = area.runs[i]
            run, mask = belief[k, row, first:last], area.mask[row, first:last]
            costs = total[: padded(last - first)]
            sum_costs(costs, scan.starts[k], scan.costs, row * scan.width + first)
            runs.mass[i], runs.peak[i] = _apply_costs(run, mask, costs, scan.likelihood, gain_floor)
    return runs


@kernel
def weigh_ranges(belief: Belief, area: Area, prior: Prior, echoes: Echoes) -> Runs:
    """Multiply the prior by each beam's likelihood of the expected range (eq. 14)."""
    runs = _no_runs(len(area.runs))
    factors = np.empty(belief.shape[2], np.float32)
    for k in range(len(belief)):
        _clear(belief[k], area.gaps)
        gain_floor = _prior_of(prior, k)
        for i in range(area.starts[k], area.starts[k + 1]):
            row, first, last = area.runs[i]
            run, mask = belief[k, row, first:last], area.mask[row, first:last]
            fit = factors[: last - first]
            _fit_of(fit, echoes, k, row, first)
            runs.mass[i], runs.peak[i] = _apply(run, mask, fit, gain_floor)
    return runs


@kernel
def weigh_visibility(belief: Belief, area: Area, runs: Runs, sight: Sight) -> None:
    """Multiply the belief by the likelihood of the number of beams that go through a wall.

    PIECEs of runs that hold no state above `sight.least` are left alone: what they could lose
    at the most is `least` a state. `runs`, as of before, is brought up to date.
    """
    through = np.empty(PIECE, np.uint8)
    for k in range(len(belief)):
        for i in range(area.starts[k], area.starts[k + 1]):
            if runs.peak[i] > sight.least:
                row, first, last = area.runs[i]
                mass, peak = 0.0, np.float32(0.0)
                for start in range(first, last, PIECE):
                    piece = belief[k, row, start : min(start + PIECE, last)]
                    part, highest = _sum_and_peak(piece)
                    if highest > sight.least:
                        count = through[: len(piece)]
                        _count_through(count, sight, k, row, start)
                        part, highest = _apply_count(piece, count, sight.likelihood)
                    mass, peak = mass + part, max(peak, highest)
                runs.mass[i], runs.peak[i] = mass, peak


@kernel
def _no_runs(count: int) -> Runs:
    return Runs(np.zeros(count), np.zeros(count, np.float32))


@kernel
def _prior_of(prior: Prior, k: int) -> tuple[np.float32, np.float32]:
    heading = prior.heading[k]
    return np.float32(prior.scale) * heading, np.float32(prior.floor) * heading


@kernel
def _clear(layer: NDArray[np.float32], gaps: NDArray[np.int64]) -> None:
    for row, first, last in gaps:
        layer[row, first:last] = np.float32(0.0)


@reduction
def _apply(
    run: NDArray[np.float32],
    mask: NDArray[np.float32],
    fit: NDArray[np.float32],
    gain_floor: tuple[np.float32, np.float32],
) -> tuple[float, np.float32]:
    gain, floor = gain_floor
    mass, peak = np.float32(0.0), np.float32(0.0)
    for i in range(len(run)):
        value = (run[i] * gain + floor) * mask[i] * fit[i]
        run[i] = value
        mass += value
        peak = max(peak, value)
    return float(mass), peak


@reduction
def _apply_costs(
    run: NDArray[np.float32],
    mask: NDArray[np.float32],
    costs: NDArray[np.uint16],
    likelihood: NDArray[np.float32],
    gain_floor: tuple[np.float32, np.float32],
) -> tuple[float, np.float32]:
    gain, floor = gain_floor
    mass, peak = np.float32(0.0), np.float32(0.0)
    for i in range(len(run)):
        value = (run[i] * gain + floor) * mask[i] * likelihood[costs[i]]
        run[i] = value
        mass += value
        peak = max(peak, value)
    return float(mass), peak


@reduction
def _apply_count(
    run: NDArray[np.float32], count: NDArray[np.uint8], likelihood: NDArray[np.float32]
) -> tuple[float, np.float32]:
    mass, peak = np.float32(0.0), np.float32(0.0)
    for i in range(len(run)):
        value = run[i] * likelihood[count[i]]
        run[i] = value
        mass += value
        peak = max(peak, value)
    return float(mass), peak


@reduction
def _sum_and_peak(run: NDArray[np.float32]) -> tuple[float, np.float32]:
    mass, peak = np.float32(0.0), np.float32(0.0)
    for value in run:
        mass += value
        peak = max(peak, value)
    return float(mass), peak


@kernel
def _fit_of(fit: NDArray[np.float32], echoes: Echoes, k: int, row: int, first: int) -> None:
    """Set `fit` (m,) to the likelihood of all ranges from the states (row, first) on."""
    n, end = echoes.directions.shape[1], first + len(fit)
    ahead, levels, likelihoods = echoes.directions[k], echoes.levels, echoes.likelihoods
    fit[:] = np.float32(1.0)
    for b in range(0, n - 3, 4):
        one, two = levels[ahead[b], row, first:end], levels[ahead[b + 1], row, first:end]
        three, four = levels[ahead[b + 2], row, first:end], levels[ahead[b + 3], row, first:end]
        _fit_four(fit, (one, two, three, four), likelihoods[b : b + 4])
    for b in range(n - n % 4, n):
        _fit_one(fit, levels[ahead[b], row, first:end], likelihoods[b])


@kernel
def _fit_four(fit: NDArray[np.float32], seen: Four, likelihoods: NDArray[np.float32]) -> None:
    one, two, three, four = seen
    of_one, of_two = likelihoods[0], likelihoods[1]
    of_three, of_four = likelihoods[2], likelihoods[3]
    for i in range(len(fit)):
        fit[i] *= of_one[one[i]] * of_two[two[i]] * of_three[three[i]] * of_four[four[i]]


@kernel
def _fit_one(
    fit: NDArray[np.float32], seen: NDArray[np.uint8], likelihood: NDArray[np.float32]
) -> None:
    for i in range(len(fit)):
        fit[i] *= likelihood[seen[i]]


@kernel
def _count_through(count: NDArray[np.uint8], sight: Sight, k: int, row: int, first: int) -> None:
    """Set `count` (m,) to the number of beams through walls from the states (row, first) on."""
    count[:] = np.uint8(0)
    end = first + len(count)
    for b in range(len(sight.allowed)):
        seen = sight.levels[sight.directions[k, b], row, first:end]
        _count_below(count, seen, sight.allowed[b])


@kernel
def _count_below(count: NDArray[np.uint8], seen: NDArray[np.uint8], allowed: np.uint8) -> None:
    for i in range(len(count)):
        count[i] += np.uint8(seen[i] < allowed)
