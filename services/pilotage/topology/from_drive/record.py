"""What a drive has shown so far: the trail, the features along it, and what each stop saw."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.features import Features


@dataclass(frozen=True)
class BindParams:
    """Which features are bound to a place; lengths in m."""

    around: float = 1.2
    """A place sees what is seen from so far around it."""
    reach: float = 5.0
    """Farther features are not bound: they say little about this place."""
    most: int = 24
    """Features of a place; the nearest are kept."""


@dataclass(frozen=True)
class Record:
    """Trail and features at one moment.

    `poses` (n, 3) and `lengths` (n,) of the stops; `features` (m) in map, of which some are
    `is_certain` (m,); `sightings` holds for each stop which features it saw.
    """

    poses: NDArray[np.float64]
    lengths: NDArray[np.float64]
    features: Features
    is_certain: NDArray[np.bool_]
    sightings: list[NDArray[np.int64]]
    params: BindParams = field(default_factory=BindParams)

    def seen_near(self, stop: int) -> NDArray[np.int64]:
        """Return the certain features that are seen from around a stop, the nearest first."""
        off = self.poses[:, :2] - self.poses[stop, :2]
        around = np.flatnonzero(np.hypot(off[:, 0], off[:, 1]) <= self.params.around)
        seen = np.unique(np.concatenate([self.sightings[one] for one in around]))
        seen = seen[self.is_certain[seen]]
        away = self.features.poses[seen, :2] - self.poses[stop, :2]
        distance = np.hypot(away[:, 0], away[:, 1])
        order = np.argsort(distance, kind="stable")
        order = order[distance[order] <= self.params.reach]
        nearest: NDArray[np.int64] = seen[order[: self.params.most]]
        return nearest
