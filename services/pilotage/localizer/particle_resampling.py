"""How many particles to keep, and which (Fox 2003; Thrun et al. 2005, 4.4)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer import particle_kernels as kernels

GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class KldParams:
    """How many particles are enough.

    `least`, `most`: limits of the number. `epsilon`: bound of the Kullback-Leibler divergence
    between the belief and its particles (AMCL: pf_err); `quantile`: the normal quantile z that
    the bound holds with (pf_z, which AMCL too takes as z; 2.33 is 99 %). `bin_size` [m] and
    `bin_turn` [rad]: poses in the same bin need not be told apart.
    """

    least: int = 5_000
    most: int = 50_000
    epsilon: float = 0.05
    quantile: float = 0.99
    bin_size: float = 0.5
    bin_turn: float = math.radians(10.0)

    def __post_init__(self) -> None:
        """Refuse limits that cannot be kept (ValueError)."""
        if not 1 <= self.least <= self.most:
            raise ValueError(f"{self.least} to {self.most} is no range of particle numbers")
        if not (self.epsilon > 0.0 and self.bin_size > 0.0 and self.bin_turn > 0.0):
            raise ValueError("epsilon and the bins must be positive")


def effective_number(weights: NDArray[np.float64]) -> float:
    """Return 1 / sum w^2 of weights (n,) that sum to one: n when even, 1 when one has all."""
    return float(1.0 / np.square(weights).sum())


def draw(weights: NDArray[np.float64], count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Return `count` indices, each drawn weight * count times but for rounding."""
    drawn = np.empty(count, np.int64)
    kernels.draw_systematic(weights, rng.random(), drawn)
    return drawn


def needed_particles(
    poses: NDArray[np.float64],
    weights: NDArray[np.float64],
    params: KldParams,
    rng: np.random.Generator,
) -> int:
    """Return how many particles the belief of poses (n, 3) with weights (n,) needs.

    Fox draws until what was drawn suffices. Drawing is done here at once, evenly, and gone
    through in golden steps, whose every beginning spreads evenly over the whole.
    """
    sample = draw(weights, params.most, rng)
    stride = max(1, round(GOLDEN * params.most))
    while math.gcd(stride, params.most) != 1:
        stride += 1
    first = int(rng.integers(params.most))
    limits = params.least, params.most, params.epsilon, params.quantile
    bins = bins_of(poses, params.bin_size, params.bin_turn)[sample]
    return kernels.count_needed(bins, stride, first, limits)


def bins_of(poses: NDArray[np.float64], size: float, turn: float) -> NDArray[np.int64]:
    """Return a number (n,), not negative, that poses (n, 3) of the same bin share."""
    turns = round(2.0 * math.pi / turn)
    col, row = np.floor(poses[:, :2].T / size).astype(np.int64)
    layer = np.floor((poses[:, 2] + math.pi) / (2.0 * math.pi) * turns).astype(np.int64) % turns
    row, col = row - row.min(), col - col.min()
    bins: NDArray[np.int64] = (row * (col.max() + 1) + col) * turns + layer
    return bins
