"""Particles anywhere that a measurement speaks for: from coarse to fine.

Poses drawn over a whole building lie tenths of a metre and degrees apart. A sharp likelihood
would pick among alike places whichever happens to have a pose nearest to its peak. So the first
look is at a blurred field; what it leaves is shaken by about the spacing of the poses, and weighed
by a sharper likelihood over the blurred one (importance sampling), and so on to the true one.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.localizer.last_measurement import Novelty
from pilotage.localizer.measurement import Measurement
from pilotage.localizer.particle_evidence import ParticleEvidence
from pilotage.localizer.particle_resampling import draw
from pilotage.localizer.particle_start import FreeSpace


@dataclass(frozen=True)
class SearchParams:
    """Parameters of the search.

    `candidates`: poses drawn over all free space; half a million lie 0.4 m and 10 degrees apart
    in 2,000 m2. `kept`: drawn among them for each closer look. `shaken` [m] and `turned` [rad]:
    standard deviations of the shaking before the second and the third look.
    """

    candidates: int = 500_000
    kept: int = 100_000
    shaken: tuple[float, float] = (0.15, 0.05)
    turned: tuple[float, float] = (0.07, 0.025)


@dataclass(frozen=True)
class Finds:
    """Poses (n, 3), and weights (n,) that sum to one.

    `log_mean`: logarithm of the mean likelihood of all poses in free space.
    """

    poses: NDArray[np.float64]
    weights: NDArray[np.float64]
    log_mean: float

    def drawn(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return `count` poses, by weight."""
        poses: NDArray[np.float64] = self.poses[draw(self.weights, count, rng)]
        return poses


@dataclass(frozen=True)
class ParticleSearch:
    """Searches the free space of a map by the evidence of its sensors."""

    free: FreeSpace
    evidence: ParticleEvidence
    params: SearchParams

    def anywhere(
        self, seen: Measurement, novelty: Novelty, rng: np.random.Generator, share: float = 1.0
    ) -> Finds:
        """Return poses as likely as a measurement says, by a share of the usual effort."""
        poses = self.free.draw(max(1, round(share * self.params.candidates)), rng)
        kept = max(1, round(share * self.params.kept))
        weights, log_mean = _normalised(self.evidence.weigh_coarsely(poses, seen, novelty, 0))
        for look in (0, 1):
            poses = self._shaken(poses[draw(weights, kept, rng)], look, rng)
            sharper = self._sharper(poses, seen, novelty, look)
            weights, log_ratio = _normalised(
                sharper - self.evidence.weigh_coarsely(poses, seen, novelty, look)
            )
            log_mean += log_ratio
        return Finds(poses, weights, log_mean)

    def _sharper(
        self, poses: NDArray[np.float64], seen: Measurement, novelty: Novelty, look: int
    ) -> NDArray[np.float64]:
        """Return log likelihoods (n,) by the next blur, in the end without any."""
        if look == 0:
            return self.evidence.weigh_coarsely(poses, seen, novelty, 1)
        return self.evidence.weigh(poses, seen, novelty).logs

    def _shaken(
        self, poses: NDArray[np.float64], look: int, rng: np.random.Generator
    ) -> NDArray[np.float64]:
        """Return poses (n, 3) moved at random, but never out of free space."""
        shaken, turned = self.params.shaken[look], self.params.turned[look]
        scale = np.array([shaken, shaken, turned])
        moved = se2.compose(poses + scale * rng.standard_normal(poses.shape), np.zeros(3))
        return np.where(self.free.holds(moved)[:, None], moved, poses)


def _normalised(logs: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return weights (n,) that sum to one, and the logarithm of their mean before."""
    best = float(logs.max())
    weights = np.exp(logs - best)
    mean = float(weights.mean())
    return weights / (mean * len(weights)), best + float(np.log(mean))
