"""The walls that the filter compares: lines and the corners that they form, seen or of the map."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core.corners import Corners, find_corners
from pilotage.core.lines import Lines

Array = NDArray[np.float64]

BEHIND = 1.0
"""m by which an expected pose may lie behind a wall that is seen all the same."""


@dataclass(frozen=True)
class Walls:
    """Lines and corners in one frame.

    `newness`: how much of a new sight they are, above 0 and at most 1; walls seen again from the
    same place repeat the errors of laser and map.
    """

    lines: Lines
    corners: Corners
    newness: float = 1.0

    @classmethod
    def of(cls, lines: Lines) -> "Walls":
        """Return lines with the corners that they form."""
        return cls(lines, find_corners(lines))

    def as_new_as(self, newness: float) -> "Walls":
        """Return the same walls, so much of a new sight."""
        return replace(self, newness=newness)

    def near(self, pose: Array, reach: float) -> "Walls":
        """Return those that a robot at a pose (3,) could see within `reach` [m]."""
        begin, along = self.lines.ends[:, 0], self.lines.ends[:, 1] - self.lines.ends[:, 0]
        away = pose[:2] - begin
        share = np.sum(away * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-12)
        nearest = np.clip(share, 0.0, 1.0)[:, None] * along
        alpha, rho = self.lines.polar.T
        ahead = pose[0] * np.cos(alpha) + pose[1] * np.sin(alpha) - rho
        is_near = (np.hypot(*(away - nearest).T) <= reach) & (ahead > -BEHIND)
        tips = self.corners.poses[:, :2] - pose[:2]
        corners = _chosen(self.corners, np.hypot(tips[:, 0], tips[:, 1]) <= reach)
        return Walls(self.lines.chosen(is_near), corners)


def _chosen(corners: Corners, which: NDArray[np.bool_]) -> Corners:
    return Corners(
        corners.poses[which],
        corners.covariances[which],
        corners.convex[which],
        corners.lines[which],
    )
