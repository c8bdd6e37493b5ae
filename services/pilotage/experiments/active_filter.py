"""The base filter of Liu et al. 2008: Monte Carlo localization with a fixed number of particles."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.experiments.active_robot import MOTION_ERROR
from pilotage.experiments.landmark_field import CARPET
from pilotage.localizer.particle_resampling import draw, effective_number
from pilotage.planner.hypotheses import likely
from pilotage.planner.landmark_localization import Move, predicted
from pilotage.planner.landmark_views import Camera, sighting_log_likelihoods
from pilotage.planner.potential_field import Sources
from pilotage.planner.sample_spacing import sample_spacing
from pilotage.planner.situation import Hypotheses

Array = NDArray[np.float64]
Sightings = tuple[NDArray[np.int64], Array]
"""Kinds (s,), and values (s, 2): range [m] and bearing off the heading [rad]."""
RESAMPLED_BELOW = 0.5
"""Share of effective particles."""
RESET = 0.1
"""Share of the belief that what is seen may put elsewhere, if it fits nowhere.

The mixing ratio of mixture MCL (Thrun et al. 2001, the paper's reference 6).
"""
FITTING = 0.1
"""Likelihood of a sighting, relative to the best, from which on it is taken to fit the belief.

Where it does not, the place may have died out: sensor resetting (Lenser & Veloso 2000).
"""
FORGETTING = 0.3
"""Weight of the last sightings in the mean fit: one that is off by chance resets nothing."""


class LandmarkFilter:
    """Particles anywhere on the carpet at first."""

    def __init__(self, sources: Sources, camera: Camera, count: int, seed: list[int]) -> None:
        self._sources = sources
        self._camera = camera
        self._seed = seed
        self._count = count
        self._fit = 0.0
        rng = np.random.default_rng(seed)
        half = np.array([CARPET[0] / 2.0, CARPET[1] / 2.0, np.pi])
        self.belief = Hypotheses(rng.uniform(-half, half, (count, 3)), np.full(count, 1.0 / count))
        self.estimate = mean_place(self.belief)

    def update(self, move: Move, gaze: float, sightings: Sightings, step: int) -> None:
        """Take in a move, where the camera pointed then, and what it recognised.

        `step` chooses the random numbers: the same for all policies.
        """
        rng = np.random.default_rng([*self._seed, step])
        errors = MOTION_ERROR * rng.standard_normal((self._count, 2))
        moved = predicted(self.belief, move, errors)
        weighed, fit = self._weighed(moved, gaze, sightings)
        self.estimate = mean_place(weighed)
        drawn = self._resampled(weighed, rng)
        replaced = rng.choice(self._count, round(RESET * self._count), replace=False)
        chances = rng.random((len(replaced), 3))
        if len(sightings[0]):
            self._fit += FORGETTING * (fit - self._fit)
        share = RESET * max(0.0, 1.0 - self._fit / FITTING)
        self.belief = self._reset(drawn, sightings, (replaced, chances), share)

    def _resampled(self, belief: Hypotheses, rng: np.random.Generator) -> Hypotheses:
        """Return the belief drawn anew, if few particles count, and its copies parted.

        A few particles per square metre lie farther apart than a camera measures, and a step of
        0.10 m parts copies by 0.01 m only; so they are parted by the spacing of the samples.
        Particles are drawn by the roots of their weights, which they keep: a place that holds a
        hundredth of the belief does not die out by chance (as in localizer/particle_filter.py).
        """
        if effective_number(belief.weights) >= RESAMPLED_BELOW * self._count:
            return belief
        roots = np.sqrt(belief.weights)
        chosen = draw(roots / roots.sum(), self._count, rng)
        shaken = roughening(belief) * rng.standard_normal((self._count, 3))
        return Hypotheses(belief.poses[chosen] + shaken, roots[chosen] / roots[chosen].sum())

    def _reset(
        self,
        belief: Hypotheses,
        sightings: Sightings,
        chances: tuple[NDArray[np.int64], Array],
        share: float,
    ) -> Hypotheses:
        """Return the belief, some of its particles put to where the sightings could be made from.

        Each sees one of the landmarks that one sighting may be of; together they hold `share`.
        `chances`: the particles (k,), and numbers in [0, 1) for each (k, 3).
        """
        kinds, values = sightings
        replaced, (picks, turns, spots) = chances[0], chances[1].T
        if not len(kinds) or share == 0.0:
            return belief
        sighting = (picks * len(kinds)).astype(int)
        firsts = self._sources.firsts
        first, end = firsts[kinds[sighting]], firsts[kinds[sighting] + 1]
        landmark = self._sources.positions[first + (spots * (end - first)).astype(int)]
        direction = 2.0 * np.pi * turns
        toward = np.column_stack([np.cos(direction), np.sin(direction)])
        places = landmark - values[sighting, :1] * toward
        poses, weights = belief.poses.copy(), belief.weights.copy()
        poses[replaced] = np.column_stack([places, wrap(direction - values[sighting, 1])])
        weights[replaced] = share / len(replaced)
        return Hypotheses(poses, weights / weights.sum())

    def _weighed(
        self, belief: Hypotheses, gaze: float, sightings: Sightings
    ) -> tuple[Hypotheses, float]:
        """Return the belief times the likelihood of what was seen, and its mean per sighting."""
        log_p = sighting_log_likelihoods(
            self._sources, belief.poses, sightings,
            (gaze, self._camera.half_view), self._camera.sharpness,
        )  # fmt: skip
        best = float(log_p.max())
        weights = belief.weights * np.exp(log_p - best)
        mean = float(weights.sum())
        fit = np.exp((best + np.log(mean)) / max(1, len(sightings[0])))
        return Hypotheses(belief.poses, weights / mean), float(fit)


def roughening(belief: Hypotheses) -> Array:
    """Return by how much copies part [m, m, rad]: as far as those lie apart that count."""
    order = np.argsort(-belief.weights, kind="stable")
    return sample_spacing(likely(Hypotheses(belief.poses[order], belief.weights[order])))


def mean_place(belief: Hypotheses) -> Array:
    """Return the mean position (2,) of a belief [m]."""
    mean: Array = belief.weights @ belief.poses[:, :2]
    return mean
