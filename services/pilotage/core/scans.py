"""Laser scans as points, and a few beams picked from many."""

import numpy as np
from numpy.typing import NDArray

Ranges = NDArray[np.float32] | NDArray[np.float64]


def bearings_of(count: int, angle_min: float, angle_increment: float) -> NDArray[np.float64]:
    """Return the directions (count,) in rad of the beams of a scan."""
    return angle_min + angle_increment * np.arange(count, dtype=np.float64)


def scan_points(ranges: Ranges, angle_min: float, angle_increment: float) -> NDArray[np.float64]:
    """Return the end points (k, 2) in the laser frame of the beams (n,) that hit something."""
    hit = np.isfinite(ranges)
    distances = ranges[hit].astype(np.float64)
    angles = bearings_of(len(ranges), angle_min, angle_increment)[hit]
    return np.stack([distances * np.cos(angles), distances * np.sin(angles)], axis=1)


def pick_beams(
    ranges: Ranges, angle_min: float, angle_increment: float, count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return bearings and ranges (k,), k <= count, of beams evenly spread over the scan.

    The first and the last beam are among them; beams without a return stay infinite.
    """
    wanted = min(count, len(ranges))
    chosen = np.round(np.linspace(0, len(ranges) - 1, wanted)).astype(np.int64)
    bearings = bearings_of(len(ranges), angle_min, angle_increment)
    return bearings[chosen], ranges[chosen].astype(np.float64)
