"""The way that the robot drove: places close to each other, with what was seen from each."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.topology.features import Features


@dataclass(frozen=True)
class TrailParams:
    """How far apart the places of a trail are."""

    step: float = 0.15
    """m from one place to the next."""
    turn: float = 0.2
    """rad after which a place is kept although the robot has not moved on."""


@dataclass(frozen=True)
class Stop:
    """A place of the trail: what was `seen` there in base_link at a time `stamp` [s]."""

    stamp: float
    seen: Features


class Trail:
    """Places (n) along the way, in the order in which they were passed."""

    def __init__(self, params: TrailParams | None = None) -> None:
        self.params = params or TrailParams()
        self.stops: list[Stop] = []
        self._poses: list[NDArray[np.float64]] = []
        self._lengths: list[float] = []

    def __len__(self) -> int:
        return len(self.stops)

    @property
    def poses(self) -> NDArray[np.float64]:
        """Poses (n, 3) of base_link in map."""
        return np.array(self._poses).reshape(-1, 3)

    @property
    def lengths(self) -> NDArray[np.float64]:
        """Distances (n,) driven up to each place, m."""
        return np.array(self._lengths)

    def add(self, stamp: float, pose: ArrayLike, seen: Features) -> bool:
        """Keep a place if the robot has moved on since the last one, and say so."""
        here = np.array(pose, float)
        driven = 0.0
        if self._poses:
            moved = here - self._poses[-1]
            driven = float(np.hypot(moved[0], moved[1]))
            if driven < self.params.step and abs(wrap(float(moved[2]))) < self.params.turn:
                return False
            driven += self._lengths[-1]
        self.stops.append(Stop(stamp, seen))
        self._poses.append(here)
        self._lengths.append(driven)
        return True

    def corrected(self, stamps: NDArray[np.float64], poses: NDArray[np.float64]) -> "Trail":
        """Return the trail carried along by corrected poses (k, 3) at stamps (k,), rising.

        Each place keeps its pose relative to the last corrected one before it.
        """
        if len(self) == 0 or len(stamps) == 0:
            return self
        own = np.array([stop.stamp for stop in self.stops])
        before = np.clip(np.searchsorted(stamps, own, side="right") - 1, 0, len(stamps) - 1)
        anchors = np.array([self._pose_at(float(stamps[k])) for k in before])
        moved = se2.compose(poses[before], se2.between(anchors, self.poses))
        trail = Trail(self.params)
        trail.stops = self.stops
        trail._poses = list(moved)
        steps = np.hypot(*np.diff(moved[:, :2], axis=0).T)
        trail._lengths = [0.0, *np.cumsum(steps).tolist()]
        return trail

    def _pose_at(self, stamp: float) -> NDArray[np.float64]:
        """Return the pose (3,) at a time, between its neighbours."""
        own = np.array([stop.stamp for stop in self.stops])
        after = int(np.clip(np.searchsorted(own, stamp), 1, max(len(own) - 1, 1)))
        if len(own) == 1 or own[after] == own[after - 1]:
            return self._poses[0]
        share = np.clip((stamp - own[after - 1]) / (own[after] - own[after - 1]), 0.0, 1.0)
        return se2.interpolate(self._poses[after - 1], self._poses[after], float(share))
