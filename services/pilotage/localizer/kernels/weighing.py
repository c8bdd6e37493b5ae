"""Passes that weigh the belief by what was measured."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel, reduction
from pilotage.localizer.kernels.areas import Admissible

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""


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


@reduction
def _any_above(run: NDArray[np.float32], least: np.float32) -> bool:
    peak = np.float32(0.0)
    for value in run:
        peak = max(peak, value)
    return bool(peak > least)


@kernel
def _count_below(through: NDArray[np.uint16], seen: NDArray[np.uint8], allowed: np.uint8) -> None:
    for i in range(len(through)):
        through[i] += np.uint16(seen[i] < allowed)
