"""Passes over the belief: float32 (headings, rows, cols), one layer per heading.

States that are not admissible hold nothing after each measurement, and only runs of columns
with admissible ones among them are worked on. Each pass has a plain twin in
tests/naive/markov.py.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

Belief = NDArray[np.float32]

LOG_FIT_0, LOG_FIT_1, LOG_FIT_2 = np.float32(0.438073), np.float32(-0.236693), np.float32(0.080307)


class Admissible(NamedTuple):
    """Where the robot may stand.

    `mask`: (rows, cols) 1 or 0. `runs`: (n, 3) row, first and last + 1 column of the stretches
    that hold all ones of the mask, in order of rows and columns.
    """

    mask: NDArray[np.float32]
    runs: NDArray[np.int64]


class Prior(NamedTuple):
    """What a state weighs before the measurement: belief * `scale` + `floor`, times `heading`.

    `heading` (headings,) is the compass's likelihood of each layer. `floor` is the paper's P0
    times the recovery weight (eq. 8); 0 gives M1.
    """

    scale: float
    floor: float
    heading: NDArray[np.float32]


class Sight(NamedTuple):
    """Beams that must not go through walls.

    `directions`: (headings, n) layer of the range table that each points along; `allowed`: (n,)
    level that the expected range must have at least; `least`: states below do not matter.
    """

    directions: NDArray[np.int64]
    allowed: NDArray[np.uint8]
    least: np.float32


class Runs(NamedTuple):
    """Sum and maximum (headings, runs) of each run of the belief after a measurement."""

    mass: NDArray[np.float64]
    peak: NDArray[np.float32]


@kernel
def weigh_scan(
    belief: Belief,
    admissible: Admissible,
    beams: NDArray[np.int64],
    costs: NDArray[np.uint8],
    likelihood: NDArray[np.float32],
) -> None:
    """Multiply the belief by `likelihood[sum of the beams' costs]`, state by state.

    Args:
        belief: changed in place.
        admissible: where to look.
        beams: (headings, n, 3) class, row and col to add to a state's own to find the beam's
            end in `costs` (margin included).
        costs: (classes, rows + 2 margin, cols + 2 margin), see likelihood_field.
        likelihood: (255 n + 1,) by summed cost.
    """
    headings, _, cols = belief.shape
    total = np.zeros(cols, np.uint16)
    for k in range(headings):
        for row, first, last in admissible.runs:
            count = last - first
            total[:count] = 0
            add_costs(total[:count], beams[k], costs, row, first)
            apply_costs(belief[k, row, first:last], total[:count], likelihood)


@kernel
def add_costs(
    total: NDArray[np.uint16],
    beams: NDArray[np.int64],
    costs: NDArray[np.uint8],
    row: int,
    first: int,
) -> None:
    """Add the costs of all beams (n, 3) to `total` (m,) of the states from (row, first) on."""
    count = len(total)
    n = len(beams)
    for b in range(0, n - 3, 4):
        at0, at1 = row + beams[b, 1], first + beams[b, 2]
        at2, at3 = row + beams[b + 1, 1], first + beams[b + 1, 2]
        at4, at5 = row + beams[b + 2, 1], first + beams[b + 2, 2]
        at6, at7 = row + beams[b + 3, 1], first + beams[b + 3, 2]
        add_four(
            total,
            costs[beams[b, 0], at0, at1 : at1 + count],
            costs[beams[b + 1, 0], at2, at3 : at3 + count],
            costs[beams[b + 2, 0], at4, at5 : at5 + count],
            costs[beams[b + 3, 0], at6, at7 : at7 + count],
        )
    for b in range(n - n % 4, n):
        at0, at1 = row + beams[b, 1], first + beams[b, 2]
        add_one(total, costs[beams[b, 0], at0, at1 : at1 + count])


@kernel
def add_four(
    total: NDArray[np.uint16],
    one: NDArray[np.uint8],
    two: NDArray[np.uint8],
    three: NDArray[np.uint8],
    four: NDArray[np.uint8],
) -> None:
    """Add four rows of bytes; a function on slices, which LLVM turns into vector code."""
    for i in range(len(total)):
        total[i] += np.uint16(one[i]) + np.uint16(two[i]) + np.uint16(three[i]) + np.uint16(four[i])


@kernel
def add_one(total: NDArray[np.uint16], one: NDArray[np.uint8]) -> None:
    """Add one row of bytes."""
    for i in range(len(total)):
        total[i] += np.uint16(one[i])


@kernel
def apply_costs(
    belief: NDArray[np.float32], total: NDArray[np.uint16], likelihood: NDArray[np.float32]
) -> None:
    """Multiply a row of the belief by the likelihood of its costs."""
    for i in range(len(belief)):
        belief[i] *= likelihood[total[i]]


@kernel
def weigh_ranges(
    belief: Belief,
    admissible: Admissible,
    directions: NDArray[np.int64],
    levels: NDArray[np.uint8],
    likelihoods: NDArray[np.float32],
) -> None:
    """Multiply the belief by each beam's likelihood of the expected range (eq. 14).

    Args:
        belief: changed in place.
        admissible: where to look.
        directions: (headings, n) layer of `levels` that each beam points along.
        levels: (table headings, rows, cols), see range_model.
        likelihoods: (n, 256) by expected level.
    """
    for k in range(len(belief)):
        for row, first, last in admissible.runs:
            for b in range(directions.shape[1]):
                seen = levels[directions[k, b], row, first:last]
                apply_levels(belief[k, row, first:last], seen, likelihoods[b])


@kernel
def apply_levels(
    belief: NDArray[np.float32], seen: NDArray[np.uint8], likelihood: NDArray[np.float32]
) -> None:
    """Multiply a run of the belief by the likelihood of the expected levels."""
    for i in range(len(belief)):
        belief[i] *= likelihood[seen[i]]


@kernel
def weigh_visibility(
    belief: Belief,
    admissible: Admissible,
    sight: Sight,
    levels: NDArray[np.uint8],
    likelihood: NDArray[np.float32],
) -> None:
    """Multiply the belief by `likelihood[n]`, n being the beams that would go through a wall.

    Args:
        belief: changed in place; runs that hold no state above `sight.least` are left alone, so
            that what they could lose at the most is `least` a state.
        admissible: where to look.
        sight: the beams.
        levels: (table headings, rows, cols) optimistic expected ranges, see visibility.
        likelihood: (beams + 1,) by number of beams.
    """
    cols = belief.shape[2]
    through = np.zeros(cols, np.uint16)
    for k in range(len(belief)):
        for row, first, last in admissible.runs:
            run = belief[k, row, first:last]
            if not _any_above(run, sight.least):
                continue
            count = last - first
            through[:count] = 0
            for b in range(len(sight.allowed)):
                seen = levels[sight.directions[k, b], row, first:last]
                _count_below(through[:count], seen, sight.allowed[b])
            apply_costs(run, through[:count], likelihood)


@kernel
def _any_above(run: NDArray[np.float32], least: np.float32) -> bool:
    peak = np.float32(0.0)
    for value in run:
        peak = max(peak, value)
    return bool(peak > least)


@kernel
def _count_below(through: NDArray[np.uint16], seen: NDArray[np.uint8], allowed: np.uint8) -> None:
    for i in range(len(through)):
        through[i] += np.uint16(seen[i] < allowed)


@kernel
def add_floor(belief: Belief, admissible: Admissible, prior: Prior) -> None:
    """Turn the belief into the prior of a measurement (eq. 8), zero where not admissible."""
    headings, rows, cols = belief.shape
    for k in range(headings):
        gain = np.float32(prior.scale) * prior.heading[k]
        floor = np.float32(prior.floor) * prior.heading[k]
        layer = belief[k].reshape(rows * cols)
        mask = admissible.mask.reshape(rows * cols)
        done = 0
        for row, first, last in admissible.runs:
            start, end = row * cols + first, row * cols + last
            layer[done:start] = 0.0
            _add_floor_to_run(layer[start:end], mask[start:end], gain, floor)
            done = end
        layer[done:] = 0.0


@kernel
def _add_floor_to_run(
    belief: NDArray[np.float32], mask: NDArray[np.float32], gain: np.float32, floor: np.float32
) -> None:
    for i in range(len(belief)):
        belief[i] = (belief[i] * gain + floor) * mask[i]


@kernel
def sum_runs(belief: Belief, admissible: Admissible) -> Runs:
    """Return the sum and maximum of each run."""
    headings, count = len(belief), len(admissible.runs)
    mass = np.zeros((headings, count))
    peak = np.zeros((headings, count), np.float32)
    for k in range(headings):
        for i in range(count):
            row, first, last = admissible.runs[i]
            mass[k, i], peak[k, i] = _sum_and_peak(belief[k, row, first:last])
    return Runs(mass, peak)


@kernel
def _sum_and_peak(run: NDArray[np.float32]) -> tuple[float, np.float32]:
    mass, peak = 0.0, np.float32(0.0)
    for value in run:
        mass += value
        peak = max(peak, value)
    return mass, peak


@kernel
def sum_headings(
    belief: Belief, admissible: Admissible, mass: NDArray[np.float64], least: float
) -> NDArray[np.float32]:
    """Return the belief (rows, cols) summed over headings, runs lighter than `least` left out."""
    headings, rows, cols = belief.shape
    marginal = np.zeros((rows, cols), np.float32)
    for k in range(headings):
        for i in range(len(admissible.runs)):
            if mass[k, i] > least:
                row, first, last = admissible.runs[i]
                _add_row(marginal[row, first:last], belief[k, row, first:last], np.float32(1.0))
    return marginal


@kernel
def sum_logarithms(
    belief: Belief, bits: NDArray[np.int32], admissible: Admissible, mass: NDArray[np.float64]
) -> float:
    """Return the sum of b log2 b over the belief; runs without mass add nothing.

    `bits` is the same memory as `belief`, read as integers.
    """
    total = 0.0
    for k in range(len(belief)):
        for i in range(len(admissible.runs)):
            if mass[k, i] > 0.0:
                row, first, last = admissible.runs[i]
                total += _sum_run_logarithms(belief[k, row, first:last], bits[k, row, first:last])
    return total


@kernel
def _sum_run_logarithms(run: NDArray[np.float32], bits: NDArray[np.int32]) -> float:
    """Sum b log2 b with log2 from the float's own exponent and mantissa 1 + f.

    log2(1 + f) = f + f (1 - f) p(f), p being a least-squares parabola: good to 2e-4.
    """
    total = np.float32(0.0)
    for i in range(len(run)):
        exponent = np.float32((bits[i] >> 23) - 127)
        f = np.float32(bits[i] & 0x7FFFFF) * np.float32(2.0**-23)
        bend = LOG_FIT_0 + f * (LOG_FIT_1 + f * LOG_FIT_2)
        total += run[i] * (exponent + f + f * (np.float32(1.0) - f) * bend)
    return float(total)


@kernel
def shift_layer(layer: NDArray[np.float32], up: int, right: int) -> None:
    """Move a layer (rows, cols) by whole cells in place; what enters is 0, what leaves is lost."""
    rows, cols = layer.shape
    for i in range(rows):
        row = rows - 1 - i if up > 0 else i
        source = row - up
        if source < 0 or source >= rows or abs(right) >= cols:
            layer[row, :] = 0.0
        elif right >= 0:
            for col in range(cols - 1, right - 1, -1):
                layer[row, col] = layer[source, col - right]
            layer[row, :right] = 0.0
        else:
            for col in range(cols + right):
                layer[row, col] = layer[source, col - right]
            layer[row, cols + right :] = 0.0


@kernel
def spread_layer(layer: NDArray[np.float32], share: float) -> None:
    """Give `share` of each cell to each of its neighbours above, below, left and right.

    Per axis this is a step of diffusion of variance 2 * share cells^2. At the grid's edge the
    share that would leave stays.
    """
    rows, cols = layer.shape
    keep, give = np.float32(1.0 - 2.0 * share), np.float32(share)
    before = layer[0].copy()
    current = layer[0].copy()
    for row in range(rows):
        after = layer[min(row + 1, rows - 1)]
        _blend(layer[row], before, after, keep, give)
        before[:] = current
        current[:] = after
    edge = np.empty(cols + 2, np.float32)
    for row in range(rows):
        edge[1:-1] = layer[row]
        edge[0], edge[-1] = edge[1], edge[-2]
        _blend(layer[row], edge[:-2], edge[2:], keep, give)


@kernel
def _blend(
    row: NDArray[np.float32],
    before: NDArray[np.float32],
    after: NDArray[np.float32],
    keep: np.float32,
    give: np.float32,
) -> None:
    for i in range(len(row)):
        row[i] = keep * row[i] + give * (before[i] + after[i])


@kernel
def spread_headings(belief: Belief, share: float, shifts: NDArray[np.int64]) -> None:
    """Give `share` of each layer to the next and to the last one, all the way round.

    `shifts` (headings, 2) says by how many rows and cols the layer k + 1 lies farther than k
    (layers move apart by parts of a cell, see markov_grid).
    """
    headings, rows, cols = belief.shape
    keep, give = np.float32(1.0 - 2.0 * share), np.float32(share)
    first = belief[0].copy()
    before = belief[headings - 1].copy()
    current = np.empty((rows, cols), np.float32)
    for k in range(headings):
        current[:] = belief[k]
        after = first if k == headings - 1 else belief[k + 1]
        last = shifts[k - 1]
        belief[k] *= keep
        _add_shifted(belief[k], before, give, -last)
        _add_shifted(belief[k], after, give, shifts[k])
        before, current = current, before


@kernel
def _add_shifted(
    layer: NDArray[np.float32],
    other: NDArray[np.float32],
    give: np.float32,
    shift: NDArray[np.int64],
) -> None:
    """Add `give` times `other`, whose cells lie `shift` (rows, cols) farther than the layer's."""
    rows, cols = layer.shape
    for row in range(max(0, shift[0]), min(rows, rows + shift[0])):
        source = other[row - shift[0]]
        first, last = max(0, shift[1]), min(cols, cols + shift[1])
        target = layer[row, first:last]
        _add_row(target, source[first - shift[1] : last - shift[1]], give)


@kernel
def _add_row(target: NDArray[np.float32], source: NDArray[np.float32], give: np.float32) -> None:
    for i in range(len(target)):
        target[i] += give * source[i]


def warm_up() -> None:
    """Compile every kernel for the types it meets in service."""
    belief = np.ones((2, 3, 3), np.float32)
    area = Admissible(np.ones((3, 3), np.float32), np.array([[0, 0, 3], [2, 0, 3]]))
    tables = np.zeros((2, 3, 3), np.uint8)
    pair = np.zeros((2, 5, 3), np.int64)
    ones = np.ones(5 * 255 + 1, np.float32)
    add_floor(belief, area, Prior(1.0, 0.0, np.ones(2, np.float32)))
    weigh_scan(belief, area, pair, tables, ones)
    sight = Sight(np.zeros((2, 1), np.int64), np.zeros(1, np.uint8), np.float32(0.0))
    weigh_visibility(belief, area, sight, tables, ones)
    weigh_ranges(belief, area, np.zeros((2, 1), np.int64), tables, np.ones((1, 256), np.float32))
    runs = sum_runs(belief, area)
    sum_headings(belief, area, runs.mass, 0.0)
    sum_logarithms(belief, belief.view(np.int32), area, runs.mass)
    shift_layer(belief[0], 1, 1)
    spread_layer(belief[0], 0.1)
    spread_headings(belief, 0.1, np.zeros((2, 2), np.int64))
