"""What scans saw past: a place that beams went through holds nothing."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.laser_grid_scans import DrawnScan

SECTORS = 240
"""Of the horizon; 1.5 degrees each, so that a beam per degree leaves none empty."""


def sight_of(scan: DrawnScan) -> NDArray[np.float64]:
    """Return how far (SECTORS,) a scan saw in each direction and its neighbours, in m.

    The least of the sector's beams and its two neighbours', 0 where there are none: nearer than
    that surely nothing stood.
    """
    rays = scan.ends[scan.is_hit] - scan.laser
    far = np.full(SECTORS, np.inf)
    np.minimum.at(far, _sectors(rays), np.hypot(rays[:, 0], rays[:, 1]))
    far[np.isinf(far)] = 0.0
    least: NDArray[np.float64] = np.minimum(np.minimum(far, np.roll(far, 1)), np.roll(far, -1))
    return least


def seen_past(
    points: NDArray[np.float64], scans: Sequence[DrawnScan], margin: float
) -> NDArray[np.bool_]:
    """Say for points (n, 2) whether any of the scans saw more than `margin` m past them."""
    past = np.zeros(len(points), np.bool_)
    for scan in scans:
        rays = points - scan.laser
        past |= np.hypot(rays[:, 0], rays[:, 1]) + margin < sight_of(scan)[_sectors(rays)]
    return past


def _sectors(rays: NDArray[np.float64]) -> NDArray[np.int64]:
    share = np.arctan2(rays[:, 1], rays[:, 0]) / (2.0 * np.pi)
    return np.floor(share * SECTORS).astype(np.int64) % SECTORS
