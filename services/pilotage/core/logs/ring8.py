"""Eight sonars with poses in two files: `measurement.txt` t r1..r8 and `poses.txt` t x y theta.

Times are ms, lengths mm, headings tenths of a degree.
"""

import math

import numpy as np

from pilotage.core.logs.line_format import pose_of
from pilotage.core.logs.records import OdometryRecord, SonarRecord
from pilotage.core.logs.text_log import TableFormat

NO_ECHO_MM = 5110.0
CONE = math.radians(25.0)
"""The data set does not say it; so wide are common sonars (Li 2008)."""

MOUNTS = np.zeros((8, 3))
MOUNTS[:, 2] = np.deg2rad([-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0])
"""As the ring's maker has it; neither this nor the radius of the ring is documented."""


def _round(_place: int, values: list[float]) -> list[SonarRecord]:
    ranges = np.array(values[1:])
    ranges[(ranges <= 0.0) | (ranges >= NO_ECHO_MM)] = np.inf
    metres = (ranges / 1000.0).astype(np.float32)
    return [SonarRecord(values[0] / 1000.0, metres, MOUNTS, CONE, NO_ECHO_MM / 1000.0)]


def _pose(_place: int, values: list[float]) -> list[OdometryRecord]:
    stamp, x, y, theta = values
    pose = pose_of(x / 1000.0, y / 1000.0, math.radians(theta / 10.0))
    return [OdometryRecord(stamp / 1000.0, pose)]


RING8_MEASUREMENTS = TableFormat("ring8", 9, _round)
RING8_POSES = TableFormat("ring8", 4, _pose)
RING8_FILES = {"measurement.txt": RING8_MEASUREMENTS, "poses.txt": RING8_POSES}
