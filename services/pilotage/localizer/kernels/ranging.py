"""The pass that weighs the belief by single ranges, four at a time."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.localizer.kernels.areas import Area, Prior, Runs
from pilotage.localizer.kernels.priors import clear, no_runs, prior_of
from pilotage.localizer.kernels.summing import sum_and_peak

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""

Levels = NDArray[np.uint8]
Four = tuple[Levels, Levels, Levels, Levels]


class Echoes(NamedTuple):
    """Single ranges, ready to be looked up four at a time (see `echoes_of`).

    `directions`: (headings, n) layer of `levels` that each beam points along. `levels`: (table
    headings, rows, cols), see range_model. `likelihoods`: (headings, n, 256) by expected level.
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
    silent = np.ones((headings, added, likelihoods.shape[2]), np.float32)
    nowhere = np.zeros((headings, added), np.int64)
    return Echoes(
        np.concatenate([directions, nowhere], axis=1),
        levels,
        np.concatenate([likelihoods, silent], axis=1),
    )


@kernel
def shift_levels(
    likelihoods: NDArray[np.float32], ranges: NDArray[np.float64], ahead: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return likelihoods (headings, n, levels) of states that lie ahead of their cells' centres.

    Args:
        likelihoods: (n, levels) by the level of the expected range.
        ranges: (levels,) that each level stands for, rising [m].
        ahead: (headings, n) [m] along each beam.

    A state expects its cell's range less what it lies ahead; between levels likelihoods are
    interpolated. The last level stays: what is out of reach is so by any distance.
    """
    headings, n = ahead.shape
    last = len(ranges) - 1
    shifted = np.empty((headings, n, last + 1), np.float32)
    for k in range(headings):
        for b in range(n):
            below = 0
            for level in range(last):
                expected = min(max(ranges[level] - ahead[k, b], ranges[0]), ranges[last])
                while below < last - 1 and ranges[below + 1] <= expected:
                    below += 1
                part = (expected - ranges[below]) / (ranges[below + 1] - ranges[below])
                one, other = likelihoods[b, below], likelihoods[b, below + 1]
                shifted[k, b, level] = one + np.float32(part) * (other - one)
            shifted[k, b, last] = likelihoods[b, last]
    return shifted


@kernel
def weigh_ranges(belief: Belief, area: Area, prior: Prior, echoes: Echoes) -> Runs:
    """Multiply the prior by each beam's likelihood of the expected range (eq. 14)."""
    runs = no_runs(len(area.runs))
    factors = np.empty(belief.shape[2], np.float32)
    n = echoes.directions.shape[1]
    for k in range(len(belief)):
        clear(belief[k], area.gaps)
        gain_floor, of_beams = prior_of(prior, k), echoes.likelihoods[k]
        for i in range(area.starts[k], area.starts[k + 1]):
            row, first, last = area.runs[i]
            run, fit = belief[k, row, first:last], area.mask[row, first:last]
            if n > 4:
                factors[: last - first] = fit
                fit = factors[: last - first]
            for b in range(0, n - 4, 4):
                seen = _levels(echoes, echoes.directions[k, b : b + 4], row, first, last)
                _fit_four(fit, seen, of_beams[b : b + 4])
            seen = _levels(echoes, echoes.directions[k, n - 4 :], row, first, last)
            _apply_four(run, fit, seen, of_beams[n - 4 :], gain_floor)
            runs.mass[i], runs.peak[i] = sum_and_peak(run)
    return runs


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


@kernel
def _apply_four(
    run: NDArray[np.float32],
    fit: NDArray[np.float32],
    seen: Four,
    likelihoods: NDArray[np.float32],
    gain_floor: tuple[np.float32, np.float32],
) -> None:
    gain, floor = gain_floor
    one, two, three, four = seen
    of_one, of_two = likelihoods[0], likelihoods[1]
    of_three, of_four = likelihoods[2], likelihoods[3]
    for i in range(len(run)):
        value = (run[i] * gain + floor) * fit[i]
        run[i] = value * of_one[one[i]] * of_two[two[i]] * (of_three[three[i]] * of_four[four[i]])
