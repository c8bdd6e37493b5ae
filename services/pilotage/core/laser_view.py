"""What a laser tells whoever drives: how far it may go where, and where doors are; pure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap

Points = NDArray[np.float64]

ALONE = 0.15
"""m by which a range must be shorter than its neighbours to be taken for dust."""
EDGE = 0.4
"""rad at both ends of the laser's view in which no way is looked for."""
DOOR_DEPTH = 0.8
"""m by which a way must go on beyond the jambs of a door."""
DOOR_SIDE = 0.45
"""m to the sides of a way in which jambs are looked for."""


@dataclass(frozen=True)
class View:
    """What the laser sees, in base_link: `points` (n, 2) in m, and where it sees at all.

    `bearings` (m,) rad of directions that the laser covers.
    """

    points: Points
    bearings: NDArray[np.float64]

    @classmethod
    def of(cls, ranges: ArrayLike, bearings: ArrayLike, mount: ArrayLike) -> "View":
        """Return the view of a laser at `mount` (3,) from its ranges (n,) and bearings (n,)."""
        distances, angles = np.asarray(ranges, float), np.asarray(bearings, float)
        hit = np.isfinite(distances) & ~_stands_alone(distances)
        rays = distances[hit, None] * np.stack([np.cos(angles[hit]), np.sin(angles[hit])], axis=1)
        # A strip along the edge of the view would be seen by half.
        edge = EDGE if angles[-1] - angles[0] < 2.0 * np.pi - EDGE else 0.0
        candidates = np.linspace(angles[0] + edge, angles[-1] - edge, 61)
        return cls(
            se2.transform_points(mount, rays), wrap(candidates + float(np.asarray(mount)[2]))
        )

    def with_contact(self, bearing: float) -> "View":
        """Return the view with a point where the body touches what the laser does not see."""
        point = 0.1 * np.array([[np.cos(bearing), np.sin(bearing)]])
        return View(np.vstack([self.points, point]), self.bearings)

    def reach(self, bearings: ArrayLike, half_width: float) -> NDArray[np.float64]:
        """Return how far (m,) strips of this half width at `bearings` (m,) are free, m.

        Measured from the centre of the robot to the first point in the strip.
        """
        return self._first(bearings, -half_width, half_width)

    def is_door(self, bearings: ArrayLike, half_width: float) -> NDArray[np.bool_]:
        """Say at which `bearings` (m,) a way leads between two jambs abreast of each other."""
        left = self._first(bearings, half_width, half_width + DOOR_SIDE)
        right = self._first(bearings, -half_width - DOOR_SIDE, -half_width)
        beyond = self.reach(bearings, half_width) > np.maximum(left, right) + DOOR_DEPTH
        finite = np.isfinite(left) & np.isfinite(right)
        apart = np.abs(np.where(finite, left, 0.0) - np.where(finite, right, 0.0))
        between: NDArray[np.bool_] = finite & beyond & (apart < 0.3)
        return between

    def _first(self, bearings: ArrayLike, lowest: float, highest: float) -> NDArray[np.float64]:
        """Return how far along (m,) `bearings` the first point lies that is so far to the left."""
        angles = np.atleast_1d(np.asarray(bearings, float))
        x, y = self.points.T
        along = np.outer(np.cos(angles), x) + np.outer(np.sin(angles), y)
        across = np.outer(-np.sin(angles), x) + np.outer(np.cos(angles), y)
        lies_there = (across > lowest) & (across < highest) & (along > 0.0)
        first: NDArray[np.float64] = np.where(lies_there, along, np.inf).min(axis=1, initial=np.inf)
        return first

    @property
    def gap(self) -> float:
        """Distance in m from the robot's centre to the nearest point."""
        return float(np.hypot(self.points[:, 0], self.points[:, 1]).min(initial=np.inf))


def _stands_alone(ranges: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Find ranges (n,) much shorter than both neighbours: dust; what is near fills more beams."""
    before = np.concatenate([ranges[:1], ranges[:-1]])
    after = np.concatenate([ranges[1:], ranges[-1:]])
    alone: NDArray[np.bool_] = ranges < np.minimum(before, after) - ALONE
    return alone
