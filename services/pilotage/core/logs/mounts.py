"""Where the laser sits on the robot, settled once for a whole log."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from pilotage.core.logs.records import Pose, Record, ScanRecord

NO_MOUNT: Pose = (0.0, 0.0, 0.0)
LARGEST_SPREAD = 0.02
"""A bolted laser moves no more than its poses are rounded, m and rad."""


def settle_mounts(records: Iterable[Record]) -> tuple[Record, ...]:
    """Give all scans the same laser mount.

    Some logs put a corrected pose where the laser's belongs; what then looks like the mount
    wanders, and the laser is taken to sit at the robot's centre.
    """
    kept = tuple(records)
    mounts = np.array([r.laser_mount for r in kept if isinstance(r, ScanRecord)])
    mount = _settled(mounts) if len(mounts) else NO_MOUNT
    return tuple(
        replace(record, laser_mount=mount) if isinstance(record, ScanRecord) else record
        for record in kept
    )


def _settled(mounts: np.ndarray) -> Pose:
    """Return the median of the mounts (n, 3) if they agree."""
    middle = np.median(mounts, axis=0)
    if np.abs(mounts - middle).max() > LARGEST_SPREAD:
        return NO_MOUNT
    x, y, theta = middle.tolist()
    return x, y, theta
