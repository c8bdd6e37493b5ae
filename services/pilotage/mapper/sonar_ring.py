"""Where the sonars of a robot sit, and which of their readings are used."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2

SonarReadings = NDArray[np.float64]
"""(k, 4): x [m], y [m] of the sonar and direction [rad] of its axis in the map, range [m]."""


@dataclass(frozen=True, eq=False)
class SonarRing:
    """Sonars in any places: `mounts` (n, 3) x, y [m] and direction [rad] in base_link.

    `cone` is the full opening angle in rad; ranges are true between `range_min` and `range_max` m.
    """

    mounts: NDArray[np.float64]
    cone: float
    range_max: float
    range_min: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what no ring is (ValueError)."""
        if self.mounts.ndim != 2 or self.mounts.shape[1] != 3 or not np.isfinite(self.mounts).all():
            raise ValueError(f"mounts must be finite (n, 3), not {self.mounts.shape}")
        if not 0.0 < self.cone <= np.pi:
            raise ValueError(f"cone must be between 0 and half a turn, not {self.cone} rad")
        if not 0.0 <= self.range_min < self.range_max < np.inf:
            raise ValueError(f"no range lies from {self.range_min} to {self.range_max} m")

    @property
    def half_cone(self) -> float:
        """The largest angle from the axis at which something is seen, rad."""
        return self.cone / 2.0

    def readings(self, map_from_base: ArrayLike, ranges: ArrayLike) -> SonarReadings:
        """Return all readings (n, 4) of ranges (n,), turned and moved to the map (4-3)."""
        measured = np.asarray(ranges, float)
        if measured.shape != (len(self.mounts),):
            raise ValueError(f"{measured.shape} ranges do not fit {len(self.mounts)} sonars")
        return np.column_stack([se2.compose(map_from_base, self.mounts), measured])
