"""What was seen just now and over the last metre: one scan shows too little of a place.

Sightings are carried along by odometry. A collision shifts what was seen before against what is
seen after it, so nothing is remembered for longer than a metre or so.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.topology.features import Features
from pilotage.topology.from_drive.landmarks import LandmarkParams, Landmarks

OWN = LandmarkParams(least_sightings=2, least_passages=3, least_sigma=0.03)


@dataclass(frozen=True)
class MemoryParams:
    """For how long features are remembered."""

    metres: float = 1.5
    """Driven since a feature was last seen."""
    turn: float = 0.4
    """rad turned, to and fro, since a feature was last seen."""
    step: float = 0.05
    """m between scans that are taken in; from the same place they err alike."""
    step_turn: float = 0.1
    """rad between scans that are taken in."""
    drift: float = 0.04
    """m by which a place errs for each metre driven since it was seen."""
    turn_drift: float = 0.08
    """rad by which a bearing errs for each radian turned: wheels slip most in turns."""


class SeenMemory:
    """Features seen lately, in odom, and how far (m) and how much (rad) the robot went since."""

    def __init__(self, params: MemoryParams | None = None) -> None:
        self.params = params or MemoryParams()
        self._known = Landmarks(OWN)
        self._last_seen = np.empty((0, 2))
        self._way = np.zeros(2)
        self._odom: NDArray[np.float64] | None = None
        self._taken: NDArray[np.float64] | None = None

    def add(self, odom_from_base: NDArray[np.float64], seen: Features) -> Features:
        """Take in what one scan shows (base_link); return all that is remembered, in base_link."""
        self._drive(odom_from_base)
        if self._has_moved_on(odom_from_base):
            self._taken = odom_from_base.copy()
            which = self._known.add(seen.moved(odom_from_base))
            fresh = len(self._known) - len(self._last_seen)
            self._last_seen = np.concatenate([self._last_seen, np.zeros((fresh, 2))])
            self._last_seen[which] = self._way
            self._forget_old()
        return self._remembered(odom_from_base)

    def clear(self) -> None:
        """Forget everything, as after odometry was counted anew."""
        self._known, self._last_seen = Landmarks(OWN), np.empty((0, 2))
        self._odom = self._taken = None

    def _drive(self, odom: NDArray[np.float64]) -> None:
        if self._odom is not None:
            moved = odom - self._odom
            driven = float(np.hypot(moved[0], moved[1]))
            self._way += [driven, abs(wrap(float(moved[2])))]
        self._odom = odom.copy()

    def _has_moved_on(self, odom: NDArray[np.float64]) -> bool:
        if self._taken is None:
            return True
        moved = odom - self._taken
        is_far = float(np.hypot(moved[0], moved[1])) >= self.params.step
        return is_far or abs(wrap(float(moved[2]))) >= self.params.step_turn

    def _forget_old(self) -> None:
        age = self._way - self._last_seen
        recent = np.asarray((age <= [self.params.metres, self.params.turn]).all(axis=1))
        if not recent.all():
            self._known.keep(recent)
            self._last_seen = self._last_seen[recent]

    def _remembered(self, odom: NDArray[np.float64]) -> Features:
        """Return what was seen twice, or just now, less surely the longer ago that was."""
        features = self._known.features.moved(se2.inverse(odom))
        age = self._way - self._last_seen
        distance = np.hypot(features.poses[:, 0], features.poses[:, 1])
        drift = (self.params.drift * age[:, 0]) ** 2
        drift += (self.params.turn_drift * age[:, 1] * distance) ** 2
        covariances = features.covariances + drift[:, None, None] * np.eye(2)
        aged = Features(features.kinds, features.poses, features.widths, covariances)
        return aged.chosen(self._known.is_certain | (age == 0.0).all(axis=1))
