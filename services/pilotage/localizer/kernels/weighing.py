"""Passes that turn the belief into a prior, and weigh it by a laser scan.

Each reads and writes the belief once: prior, likelihood and the sums of the result, run by run.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel, reduction
from pilotage.localizer.kernels.areas import Area, Prior, Runs
from pilotage.localizer.kernels.costs import Scan, padded, sum_costs
from pilotage.localizer.kernels.priors import clear, no_runs, prior_of
from pilotage.localizer.kernels.summing import sum_and_peak

Belief = NDArray[np.float32]
"""(headings, rows, cols), one layer per heading."""


@kernel
def weigh_prior(belief: Belief, area: Area, prior: Prior) -> Runs:
    """Turn the belief into the prior of a measurement (eq. 8), zero where not admissible."""
    runs = no_runs(len(area.runs))
    for k in range(len(belief)):
        clear(belief[k], area.gaps)
        gain_floor = prior_of(prior, k)
        for i in range(area.starts[k], area.starts[k + 1]):
            row, first, last = area.runs[i]
            run, mask = belief[k, row, first:last], area.mask[row, first:last]
            _apply(run, mask, gain_floor)
            runs.mass[i], runs.peak[i] = sum_and_peak(run)
    return runs


@kernel
def weigh_scan(belief: Belief, area: Area, prior: Prior, scan: Scan) -> Runs:
    """Multiply the prior by the likelihood of a scan, state by state."""
    runs = no_runs(len(area.runs))
    total = np.empty(padded(belief.shape[2]), np.uint16)
    for k in range(len(belief)):
        clear(belief[k], area.gaps)
        gain_floor = prior_of(prior, k)
        for i in range(area.starts[k], area.starts[k + 1]):
            row, first, last = area.runs[i]
            run, mask = belief[k, row, first:last], area.mask[row, first:last]
            costs = total[: padded(last - first)]
            sum_costs(costs, scan.starts[k], scan.costs, row * scan.width + first)
            runs.mass[i], runs.peak[i] = _apply_costs(run, mask, costs, scan.likelihood, gain_floor)
    return runs


@kernel
def _apply(
    run: NDArray[np.float32],
    mask: NDArray[np.float32],
    gain_floor: tuple[np.float32, np.float32],
) -> None:
    gain, floor = gain_floor
    for i in range(len(run)):
        run[i] = (run[i] * gain + floor) * mask[i]


@reduction
def _apply_costs(
    run: NDArray[np.float32],
    mask: NDArray[np.float32],
    costs: NDArray[np.uint16],
    likelihood: NDArray[np.float32],
    gain_floor: tuple[np.float32, np.float32],
) -> tuple[float, np.float32]:
    """Weigh a run, and sum it up at once: where every state looks something up, that is faster."""
    gain, floor = gain_floor
    mass, peak = np.float32(0.0), np.float32(0.0)
    for i in range(len(run)):
        value = (run[i] * gain + floor) * mask[i] * likelihood[costs[i]]
        run[i] = value
        mass += value
        peak = max(peak, value)
    return float(mass), peak
