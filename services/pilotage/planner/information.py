"""How much an observation may be expected to tell: Liu et al. 2008, eq. 5 to 8; pure.

The belief after an observation z is `Bel'(l) = a P(z | l) Bel(l)`. Which z will come depends on
where the robot is; so a few places are drawn from the belief, each says what would be seen from
it, and the entropy of the belief is averaged over these. (The paper weighs the belief by one
expected observation; where several places are likely, one observation stands for none of them.)
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.jit import kernel

LogLikelihoods = NDArray[np.float32]
"""(m, n): log P(what would be seen from place `drawn[i]` | the robot is at place j)."""


def entropy(weights: ArrayLike) -> float:
    """Return H = -sum w log2 w in bits of weights (n,) that sum to one (eq. 5)."""
    shares = np.asarray(weights, float)
    shares = shares[shares > 0.0]
    # From zero, that a sure belief has no bits rather than minus none.
    return float(0.0 - (shares * np.log2(shares)).sum())


def drawn(weights: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Return the indices (m,) of at most `count` places drawn by weight: low-variance, no luck.

    The same place may be drawn several times; it stands for as much of the belief.
    """
    positions = (np.arange(count) + 0.5) / count
    indices = np.searchsorted(np.cumsum(weights) / weights.sum(), positions)
    return np.minimum(indices, len(weights) - 1).astype(np.int64)


def expected_gain(log_likelihoods: LogLikelihoods, weights: NDArray[np.float64]) -> float:
    """Return by how many bits the entropy falls on average, once one sees what is there.

    Args:
        log_likelihoods: (m, n) of what would be seen from each of m drawn places.
        weights: (n,) the belief, summing to one.
    """
    left = _expected_entropy(log_likelihoods, weights)
    return entropy(weights) - left


@kernel
def _expected_entropy(log_likelihoods: LogLikelihoods, weights: NDArray[np.float64]) -> float:
    """Return the mean entropy in bits of the m beliefs after the observations (m, n)."""
    count, places = log_likelihoods.shape
    logs = np.log(np.maximum(weights, 1e-300))
    total = 0.0
    for i in range(count):
        row = log_likelihoods[i]
        peak = row.max()
        mass, weighted = 0.0, 0.0
        for j in range(places):
            less = row[j] - peak
            if less > -30.0 and weights[j] > 0.0:
                share = weights[j] * np.exp(less)
                mass += share
                weighted += share * (logs[j] + less)
        # H = -sum p/M log(p/M) with p = w exp(L), M = sum p.
        total += (np.log(mass) - weighted / mass) / np.log(2.0) if mass > 0.0 else 0.0
    return float(total / count)


def warm_up() -> None:
    """Compile the kernel."""
    expected_gain(np.zeros((1, 1), np.float32), np.ones(1))
