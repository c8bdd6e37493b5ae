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

PIECE = 128
"""Columns that are looked at or passed over together."""


class Echoes(NamedTuple):
    """Single ranges, ready to be looked up four at a time (see `echoes_of`).

    `directions`: (headings, n) layer of `levels` that each beam points along. `levels`: (table
    headings, rows, cols), see range_model. `likelihoods`: (n, 256) by expected level.
    """

    directions: NDArray[np.int64]
    levels: NDArray[np.uint8]
    likelihoods: NDArray[np.float32]


def echoes_of(
    directions: NDArray[np.int64], levels: NDArray[np.uint8], likelihoods: NDArray[np.float32]
) -> Echoes:
    """Return single ranges with so many added that say nothing that there are whole fours."""
    headings, n = directions.shape
    added = max(4, n + -n % 4) - n
    silent = np.ones((added, likelihoods.shape[1]), np.float32)
    nowhere = np.zeros((headings, added), np.int64)
    return Echoes(
        np.concatenate([directions, nowhere], axis=1), levels, np.concatenate([likelihoods, silent])
    )


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
    factors = np.ones(belief.shape[2], np.float32)
    n = echoes.directions.shape[1]
    for k in range(len(belief)):
        _clear(belief[k], area.gaps)
        gain_floor = _prior_of(prior, k)
        for i in range(area.starts[k], area.starts[k + 1]):
            row, first, last = area.runs[i]
            run, mask = belief[k, row, first:last], area.mask[row, first:last]
            fit = factors[: last - first]
            if n > 4:
                fit[:] = np.float32(1.0)
            for b in range(0, n - 4, 4):
                seen = _levels(echoes, echoes.directions[k, b : b + 4], row, first, last)
                _fit_four(fit, seen, echoes.likelihoods[b : b + 4])
            seen = _levels(echoes, echoes.directions[k, n - 4 :], row, first, last)
            runs.mass[i], runs.peak[i] = _apply_four(
                run, (mask, fit), seen, echoes.likelihoods[n - 4 :], gain_floor
            )
    return runs


@kernel
def weigh_visibility(belief: Belief, area: Area, runs: Runs, sight: Sight) -> None:
    """Multiply the belief by the likelihood of the number of beams that go through a wall.

    PIECEs of runs that hold no state above `sight.least` are left alone: what they could lose
    at the most is `least` a state. `runs`, as of before, is brought up to date.
    """
    through = np.empty(PIECE, np.uint8)
    following = area.starts[:-1].copy()
    # Row by row, whatever the heading: all directions of a row of the table fit the cache.
    for row in range(belief.shape[1]):
        for k in range(len(belief)):
            i = following[k]
            while i < area.starts[k + 1] and area.runs[i, 0] == row:
                if runs.peak[i] > sight.least:
                    runs.mass[i], runs.peak[i] = _weigh_sight(
                        belief[k, row], area.runs[i], k, sight, through
                    )
                i += 1
            following[k] = i


@kernel
def _weigh_sight(
    line: NDArray[np.float32],
    run: NDArray[np.int64],
    k: int,
    sight: Sight,
    through: NDArray[np.uint8],
) -> tuple[float, np.float32]:
    """Weigh the PIECEs of a run of a row; return its new sum and maximum."""
    mass, peak = 0.0, np.float32(0.0)
    row, first, last = run
    for start in range(first, last, PIECE):
        piece = line[start : min(start + PIECE, last)]
        part, highest = _sum_and_peak(piece)
        if highest > sight.least:
            count = through[: len(piece)]
            _count_through(count, sight, k, row, start)
            part, highest = _apply_count(piece, count, sight.likelihood)
        mass, peak = mass + part, max(peak, highest)
    return mass, peak


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
def _levels(echoes: Echoes, ahead: NDArray[np.int64], row: int, first: int, last: int) -> Four:
    """Return the expected levels of four beams from a run of states."""
    levels = echoes.levels
    return (
        levels[ahead[0], row, first:last],
        levels[ahead[1], row, first:last],
        levels[ahead[2], row, first:last],
        levels[ahead[3], row, first:last],
    )


@kernel
def _fit_four(fit: NDArray[np.float32], seen: Four, likelihoods: NDArray[np.float32]) -> None:
    one, two, three, four = seen
    of_one, of_two = likelihoods[0], likelihoods[1]
    of_three, of_four = likelihoods[2], likelihoods[3]
    for i in range(len(fit)):
        fit[i] *= of_one[one[i]] * of_two[two[i]] * (of_three[three[i]] * of_four[four[i]])


@reduction
def _apply_four(
    run: NDArray[np.float32],
    mask_fit: tuple[NDArray[np.float32], NDArray[np.float32]],
    seen: Four,
    likelihoods: NDArray[np.float32],
    gain_floor: tuple[np.float32, np.float32],
) -> tuple[float, np.float32]:
    gain, floor = gain_floor
    mask, fit = mask_fit
    one, two, three, four = seen
    of_one, of_two = likelihoods[0], likelihoods[1]
    of_three, of_four = likelihoods[2], likelihoods[3]
    mass, peak = np.float32(0.0), np.float32(0.0)
    for i in range(len(run)):
        value = (run[i] * gain + floor) * (mask[i] * fit[i])
        value *= of_one[one[i]] * of_two[two[i]] * (of_three[three[i]] * of_four[four[i]])
        run[i] = value
        mass += value
        peak = max(peak, value)
    return float(mass), peak


@kernel
def _count_through(count: NDArray[np.uint8], sight: Sight, k: int, row: int, first: int) -> None:
    """Set `count` (m,) to the number of beams through walls from the states (row, first) on."""
    count[:] = np.uint8(0)
    layers, rows, cols = sight.levels.shape
    levels = sight.levels.reshape(layers * rows * cols)
    n, at = len(sight.allowed), row * cols + first
    for b in range(0, n - 3, 4):
        ahead, allowed = sight.directions[k, b : b + 4], sight.allowed[b : b + 4]
        _count_four(count, levels, rows * cols, at, (ahead, allowed))
    for b in range(n - n % 4, n):
        start = sight.directions[k, b] * rows * cols + at
        _count_below(count, levels[start : start + len(count)], sight.allowed[b])


@kernel
def _count_four(
    count: NDArray[np.uint8],
    levels: NDArray[np.uint8],
    layer: int,
    at: int,
    beams: tuple[NDArray[np.int64], NDArray[np.uint8]],
) -> None:
    """Count four beams in layers of so many `levels`, from the state `at` on."""
    ahead, allowed = beams
    a0, a1 = np.uint64(ahead[0] * layer + at), np.uint64(ahead[1] * layer + at)
    a2, a3 = np.uint64(ahead[2] * layer + at), np.uint64(ahead[3] * layer + at)
    of_one, of_two, of_three, of_four = allowed[0], allowed[1], allowed[2], allowed[3]
    for i in range(len(count)):
        j = np.uint64(i)
        first = np.uint8(levels[a0 + j] < of_one) + np.uint8(levels[a1 + j] < of_two)
        second = np.uint8(levels[a2 + j] < of_three) + np.uint8(levels[a3 + j] < of_four)
        count[i] += np.uint8(first + second)


@kernel
def _count_below(count: NDArray[np.uint8], seen: NDArray[np.uint8], allowed: np.uint8) -> None:
    for i in range(len(count)):
        count[i] += np.uint8(seen[i] < allowed)
