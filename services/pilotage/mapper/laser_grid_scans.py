"""Scans as a grid draws them, kept so that it can be drawn again when poses of the past move."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.logs import ScanRecord
from pilotage.core.scans import bearings_of
from pilotage.mapper.laser_grid import DEFAULT_PARAMS, LaserGrid
from pilotage.mapper.laser_grid_params import LaserGridParams


@dataclass(frozen=True, eq=False)
class DrawnScan:
    """A scan in the robot's frame.

    `stamp` [s] or None as `LaserGrid.insert` takes it; `laser` (2,) where the beams start; `ends`
    (n, 2) in the order of their bearings; `is_hit` (n,).
    """

    stamp: float | None
    laser: NDArray[np.float64]
    ends: NDArray[np.float64]
    is_hit: NDArray[np.bool_]

    def moved(self, pose: ArrayLike) -> "DrawnScan":
        """Return the scan in the frame that sees the robot at `pose` (3,)."""
        points = se2.transform_points(pose, np.vstack([self.laser, self.ends]))
        return DrawnScan(self.stamp, points[0], points[1:], self.is_hit)


def drawn_scan(record: ScanRecord, clearing_range: float = 0.0) -> DrawnScan:
    """Return a scan of a log in the robot's frame.

    Args:
        record: of the log.
        clearing_range: m that a beam without a return is taken to be free; 0 leaves it out. What
            swallows beams (glass, black leather) is drawn as free so: keep it short.
    """
    is_hit = np.isfinite(record.ranges) & (record.ranges > 0.0)
    silent = np.isposinf(record.ranges) & (clearing_range > 0.0)
    lengths = np.where(silent, clearing_range, record.ranges.astype(np.float64))
    used = is_hit | silent
    bearings = bearings_of(len(lengths), record.angle_min, record.angle_increment)[used]
    along = np.stack([np.cos(bearings), np.sin(bearings)], axis=1) * lengths[used, None]
    ends = se2.transform_points(record.laser_mount, along)
    return DrawnScan(record.stamp, np.array(record.laser_mount[:2]), ends, is_hit[used])


def draw(grid: LaserGrid, map_from_base: ArrayLike, scan: DrawnScan) -> None:
    """Draw a scan taken at a pose (3,) of the robot."""
    points = se2.transform_points(map_from_base, np.vstack([scan.laser, scan.ends]))
    grid.insert(points[0], points[1:], scan.is_hit, scan.stamp)


def redraw(
    poses: ArrayLike, scans: Sequence[DrawnScan], params: LaserGridParams = DEFAULT_PARAMS
) -> LaserGrid:
    """Return a new grid of scans in the order of time, taken at poses (n, 3), map frame."""
    grid = LaserGrid(params)
    for pose, scan in zip(np.asarray(poses, float), scans, strict=True):
        draw(grid, pose, scan)
    return grid
