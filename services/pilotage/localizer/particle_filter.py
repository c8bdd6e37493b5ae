"""Monte Carlo localization: the belief as weighed poses (Thrun et al. 2005, chapters 4 and 8).

Pure: the random generator is an argument of whatever draws.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.localizer.particle_motion import MotionModel, predict
from pilotage.localizer.particle_resampling import (
    KldParams,
    draw,
    effective_number,
    needed_particles,
)
from pilotage.localizer.particle_search import Finds
from pilotage.localizer.particle_start import FreeSpace

RESAMPLED_BELOW = 0.5
"""Share of effective particles; while more count, resampling would only lose variety."""


class ParticleFilter:
    """Particles: `poses` (n, 3) in the map frame with `weights` (n,) that sum to one."""

    def __init__(self, free: FreeSpace, motion: MotionModel, kld: KldParams) -> None:
        self._free = free
        self._motion = motion
        self._kld = kld
        self.poses: NDArray[np.float64] = np.zeros((1, 3))
        self.weights: NDArray[np.float64] = np.ones(1)

    def set_uniform(self, count: int, rng: np.random.Generator) -> None:
        """Believe in every free place alike."""
        self._hold(self._free.draw(count, rng))

    def set_gaussian(
        self, map_from_base: ArrayLike, covariance: NDArray[np.float64], rng: np.random.Generator
    ) -> None:
        """Believe in the surroundings of a pose (3,); ValueError if none of them is free."""
        count = min(10 * self._kld.least, self._kld.most)
        self._hold(self._free.draw_around(map_from_base, covariance, count, rng))

    def set_states(
        self, poses: NDArray[np.float64], weights: NDArray[np.float64], rng: np.random.Generator
    ) -> None:
        """Believe in poses (k, 3) with weights (k,), and in any place with what they lack to 1."""
        count = min(10 * self._kld.least, self._kld.most)
        known = round(count * min(1.0, float(weights.sum())))
        elsewhere = self._free.draw(count - known, rng)
        if known:
            drawn = poses[draw(weights, known, rng)]
            elsewhere = np.concatenate([drawn[self._free.holds(drawn)], elsewhere])
        self._hold(elsewhere if len(elsewhere) else self._free.draw(count, rng))

    def take(self, finds: Finds) -> None:
        """Believe in what a search has found."""
        self.poses, self.weights = finds.poses, finds.weights

    def predict(self, increment: NDArray[np.float64], rng: np.random.Generator) -> None:
        """Move every particle by odometry's increment (3,), as it may have been in truth."""
        self.poses = predict(self.poses, increment, self._motion, rng)

    def weigh(self, log_likelihoods: NDArray[np.float64]) -> float:
        """Multiply the weights by likelihoods given as finite logarithms (n,), and normalise.

        Returns:
            The logarithm of the mean likelihood: how well the belief foretold the measurement.
        """
        best = float(log_likelihoods.max())
        weights = self.weights * np.exp(log_likelihoods - best)
        total = float(weights.sum())
        # Nothing is left when all weight lay where the likelihood is e^-745 times the best.
        self.weights = weights / total if total > 0.0 else np.full(len(weights), 1 / len(weights))
        return best + float(np.log(max(total, np.finfo(float).tiny)))

    @property
    def is_depleted(self) -> bool:
        """Say whether so few particles count that they should be drawn anew."""
        effective = effective_number(self.weights)
        return effective < RESAMPLED_BELOW * len(self.weights) or len(self.poses) > self._kld.most

    def resample(self, rng: np.random.Generator) -> None:
        """Draw as many particles as the belief needs.

        They are drawn by the roots of their weights and keep the roots: the belief is the same,
        but a place with 1 % of it gets some 10 % of the particles and does not die out by chance,
        as one of many like rooms would.
        """
        roots = np.sqrt(self.weights)
        count = needed_particles(self.poses, roots, self._kld, rng)
        drawn = draw(roots, count, rng)
        self.poses, kept = self.poses[drawn], roots[drawn]
        self.weights = kept / kept.sum()

    def admit(self, newcomers: NDArray[np.float64], share: float) -> None:
        """Give poses (k, 3) a share of the belief, evenly."""
        if len(newcomers):
            self.poses = np.concatenate([self.poses, newcomers])
            each = np.full(len(newcomers), share / len(newcomers))
            self.weights = np.concatenate([self.weights * (1.0 - share), each])

    def _hold(self, poses: NDArray[np.float64]) -> None:
        self.poses = poses
        self.weights = np.full(len(poses), 1.0 / len(poses))
