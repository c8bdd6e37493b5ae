"""The way that the robot drove: places close to each other, with what was seen from each."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.topology.features import Features

FINE = (0.01, 0.01)
"""m and rad to which the way between places is kept, for corrections at times between them."""


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
        self._way: list[NDArray[np.float64]] = []

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
        self._follow(stamp, here)
        if self._poses and _is_near(self._poses[-1], here, (self.params.step, self.params.turn)):
            return False
        driven = float(np.hypot(*(here - self._poses[-1])[:2])) if self._poses else 0.0
        self.stops.append(Stop(stamp, seen))
        self._lengths.append(driven + (self._lengths[-1] if self._lengths else 0.0))
        self._poses.append(here)
        return True

    def _follow(self, stamp: float, here: NDArray[np.float64]) -> None:
        """Keep the way between places; of a robot that stands only when it began and ended."""
        if len(self._way) > 1 and all(_is_near(one[1:], here, FINE) for one in self._way[-2:]):
            self._way.pop()
        self._way.append(np.array([stamp, *here]))

    def corrected(self, stamps: NDArray[np.float64], poses: NDArray[np.float64]) -> "Trail":
        """Return the trail carried along by corrected poses (k, 3) at stamps (k,), rising.

        Each place keeps its pose relative to the last corrected one before it.
        """
        if len(self) == 0 or len(stamps) == 0:
            return self
        way = np.array(self._way)
        anchors = _poses_at(way, np.asarray(stamps, float))
        trail = Trail(self.params)
        trail.stops = self.stops
        own = np.array([stop.stamp for stop in self.stops])
        trail._poses = list(_carried(own, self.poses, stamps, (anchors, poses)))
        steps = np.hypot(*np.diff(trail.poses[:, :2], axis=0).T)
        trail._lengths = [0.0, *np.cumsum(steps).tolist()]
        moved = _carried(way[:, 0], way[:, 1:], stamps, (anchors, poses))
        trail._way = list(np.column_stack([way[:, 0], moved]))
        return trail


def _is_near(
    one: NDArray[np.float64], other: NDArray[np.float64], apart: tuple[float, float]
) -> bool:
    """Say whether two poses (3,) differ by less than so many m and rad."""
    off = one - other
    return float(np.hypot(off[0], off[1])) < apart[0] and abs(wrap(float(off[2]))) < apart[1]


def _carried(
    own: NDArray[np.float64],
    poses: NDArray[np.float64],
    stamps: NDArray[np.float64],
    anchors: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> NDArray[np.float64]:
    """Return poses (n, 3) at times `own` (n,) moved as the anchors (k, 3) before them were."""
    before = np.clip(np.searchsorted(stamps, own, side="right") - 1, 0, len(stamps) - 1)
    return se2.compose(anchors[1][before], se2.between(anchors[0][before], poses))


def _poses_at(way: NDArray[np.float64], stamps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the poses (k, 3) at times on a way (n, 4) of stamps and poses, between neighbours."""
    unwound = np.column_stack([way[:, 1:3], np.unwrap(way[:, 3])])
    return np.column_stack([np.interp(stamps, way[:, 0], column) for column in unwound.T])
