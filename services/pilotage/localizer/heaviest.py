"""The heaviest states of a belief, without looking at all of them: the runs' maxima tell where."""

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer import kernels
from pilotage.localizer.kernels import Area, Runs


def heaviest_states(
    belief: NDArray[np.float32], area: Area, runs: Runs, most: int
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return about the `most` heaviest states (n, 3), as heading, row, col, and weights (n,).

    The `most` heaviest lie in no more runs than that, and an even belief, where every state is
    above any threshold, must not be gathered as a whole.
    """
    threshold = _threshold(runs, most)
    chosen = np.flatnonzero(runs.peak > threshold)
    if len(chosen) > most:
        chosen = np.sort(chosen[np.argpartition(runs.peak[chosen], -most)[-most:]])
    states, weights = kernels.states_above(belief, area, chosen, threshold)
    if len(weights) > most:
        order = np.argpartition(weights, -most)[-most:]
        states, weights = states[order], weights[order]
    return states, weights


def _threshold(runs: Runs, most: int) -> float:
    """Return a weight that about `most` states at most exceed, judged by the runs' maxima."""
    peaks = runs.peak
    highest = float(peaks.max(initial=0.0))
    busiest = max(1, most // 8)
    usual = float(np.partition(peaks, -busiest)[-busiest]) if len(peaks) > busiest else 0.0
    return max(highest * 1e-4, min(usual, highest * 0.999))
