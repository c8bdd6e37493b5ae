"""Passes that sum the belief up."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel, reduction
from pilotage.localizer.kernels.areas import Area, Runs

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""

LOG_FIT_0, LOG_FIT_1, LOG_FIT_2 = np.float32(0.438073), np.float32(-0.236693), np.float32(0.080307)


@kernel
def sum_runs(belief: Belief, area: Area) -> Runs:
    """Return the sum and maximum of each run."""
    count = len(area.runs)
    mass, peak = np.zeros(count), np.zeros(count, np.float32)
    for k in range(len(belief)):
        for i in range(area.starts[k], area.starts[k + 1]):
            row, first, last = area.runs[i]
            mass[i], peak[i] = sum_and_peak(belief[k, row, first:last])
    return Runs(mass, peak)


@reduction
def sum_and_peak(run: NDArray[np.float32]) -> tuple[float, np.float32]:
    """Return the sum and the maximum of a run (n,)."""
    # A belief is never negative, and such floats rise as their bits do, which the compiler can
    # compare many at a time; of floats it will not (three times slower, as is `for value in run`).
    bits, mass, most = run.view(np.int32), np.float32(0.0), np.int32(0)
    for i in range(len(run)):
        mass += run[i]
        most = max(most, bits[i])
    peak = np.int32(most)
    return float(mass), peak.view(np.float32)


@kernel
def states_above(
    belief: Belief, area: Area, chosen: NDArray[np.int64], threshold: float
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the states (n, 3) above a threshold in chosen runs (m,), rising, and weights (n,)."""
    count = 0
    for i in chosen:
        count += area.runs[i, 2] - area.runs[i, 1]
    states, weights = np.empty((count, 3), np.int64), np.empty(count, np.float32)
    count, k = 0, 0
    for i in chosen:
        while i >= area.starts[k + 1]:
            k += 1
        row, first, last = area.runs[i]
        for col in range(first, last):
            if belief[k, row, col] > threshold:
                states[count, 0], states[count, 1], states[count, 2] = k, row, col
                weights[count] = belief[k, row, col]
                count += 1
    return states[:count].copy(), weights[:count].copy()


@kernel
def sum_headings(
    belief: Belief, area: Area, mass: NDArray[np.float64], least: float
) -> NDArray[np.float32]:
    """Return the belief (rows, cols) summed over headings, runs lighter than `least` left out."""
    headings, rows, cols = belief.shape
    marginal = np.zeros((rows, cols), np.float32)
    for k in range(headings):
        for i in range(area.starts[k], area.starts[k + 1]):
            if mass[i] > least:
                row, first, last = area.runs[i]
                _add_row(marginal[row, first:last], belief[k, row, first:last], np.float32(1.0))
    return marginal


@kernel
def _add_row(target: NDArray[np.float32], source: NDArray[np.float32], give: np.float32) -> None:
    for i in range(len(target)):
        target[i] += give * source[i]


@kernel
def sum_logarithms(
    belief: Belief, bits: NDArray[np.int32], area: Area, mass: NDArray[np.float64]
) -> float:
    """Return the sum of b log2 b over the belief; runs without mass add nothing.

    `bits` is the same memory as `belief`, read as integers.
    """
    total = 0.0
    for k in range(len(belief)):
        for i in range(area.starts[k], area.starts[k + 1]):
            if mass[i] > 0.0:
                row, first, last = area.runs[i]
                total += _sum_run_logarithms(belief[k, row, first:last], bits[k, row, first:last])
    return total


@reduction
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
