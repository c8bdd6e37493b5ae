"""The pass that weighs the belief by single ranges, four at a time."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel, reduction
from pilotage.localizer.kernels.areas import Area, Prior, Runs
from pilotage.localizer.kernels.priors import clear, no_runs, prior_of

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""

Levels = NDArray[np.uint8]
Four = tuple[Levels, Levels, Levels, Levels]


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


@kernel
def weigh_ranges(belief: Belief, area: Area, prior: Prior, echoes: Echoes) -> Runs:
    """Multiply the prior by each beam's likelihood of the expected range (eq. 14)."""
    runs = no_runs(len(area.runs))
    factors = np.ones(belief.shape[2], np.float32)
    n = echoes.directions.shape[1]
    for k in range(len(belief)):
        clear(belief[k], area.gaps)
        gain_floor = prior_of(prior, k)
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
