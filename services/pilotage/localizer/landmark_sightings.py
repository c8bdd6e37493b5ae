"""Landmarks that a sensor recognised, as they are seen from the robot."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2


@dataclass(frozen=True)
class Sightings:
    """Landmarks seen at one moment, from base_link.

    `ranges` (n,) [m] and `bearings` (n,) [rad] with their standard deviations; `kinds` are
    classes; `identities` None where a landmark looks like others.
    """

    ranges: NDArray[np.float64]
    bearings: NDArray[np.float64]
    range_sigmas: NDArray[np.float64]
    bearing_sigmas: NDArray[np.float64]
    kinds: Sequence[str]
    identities: Sequence[str | None]

    def from_mount(self, base_from_sensor: ArrayLike) -> "Sightings":
        """Return the same sightings, seen from the sensor's mount (3,), as from base_link."""
        cos, sin = np.cos(self.bearings), np.sin(self.bearings)
        seen = np.column_stack([self.ranges * cos, self.ranges * sin])
        x, y = se2.transform_points(base_from_sensor, seen).T
        return replace(self, ranges=np.hypot(x, y), bearings=np.arctan2(y, x))
