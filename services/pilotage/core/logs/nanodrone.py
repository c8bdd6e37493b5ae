"""Rows of a nano drone: t, x, y, z, yaw, and four or five ranges, separated by commas; s, m, rad.

The ranges look right, ahead, left and back, a fifth looks up.
"""

import math

import numpy as np

from pilotage.core.logs.line_format import pose_of
from pilotage.core.logs.records import OdometryRecord, Record, SonarRecord
from pilotage.core.logs.text_log import TableFormat

RANGE_MAX = 4.0
"""Of the time-of-flight sensor; some farther readings occur, and 32.766 for none."""

CONE = math.radians(5.0)
"""Narrow: such a sensor answers for the nearest surface in 27 degrees that reflects well, and along
walls this is the one straight ahead within a few degrees."""

MOUNTS = np.zeros((4, 3))
MOUNTS[:, 2] = np.deg2rad([-90.0, 0.0, 90.0, 180.0])


def _row(_place: int, values: list[float]) -> list[Record]:
    stamp, x, y, _, yaw = values[:5]
    ranges = np.array(values[5:9])
    ranges[(ranges <= 0.0) | (ranges >= RANGE_MAX)] = np.inf
    return [
        OdometryRecord(stamp, pose_of(x, y, yaw)),
        SonarRecord(stamp, ranges.astype(np.float32), MOUNTS, CONE, RANGE_MAX),
    ]


NANODRONE = TableFormat("nanodrone", 10, _row, b",")
NANODRONE_FLAT = TableFormat("nanodrone", 9, _row, b",")
"""Without the range that looks up."""
