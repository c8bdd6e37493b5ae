"""Rows of a LEGO EV3 robot that stops, sweeps one ultrasonic sensor over 13 bearings, drives on.

A row is `x_cm y_cm theta_rad` and 25 ranges in cm of each bearing, from the left to the right.
"""

import math

import numpy as np

from pilotage.core.logs.line_format import pose_of
from pilotage.core.logs.records import OdometryRecord, Record, SonarRecord
from pilotage.core.logs.text_log import TableFormat

BEARINGS, READINGS = 13, 25
NO_ECHO_CM = 255.0
CONE = math.radians(25.0)
"""The data set does not say it; LEGO's sensor opens about as far as the sonar of Li 2008."""

STOP, LISTENING, LEAVING = 10.0, 4.0, 8.0
"""The rows have no time. A stop is taken to come every 10 s, to listen after 4 and end after 8 [s]:
so the odometry around a measurement says, truly, that the robot stands."""

MOUNTS = np.zeros((BEARINGS, 3))
MOUNTS[:, 2] = np.deg2rad(90.0 - 15.0 * np.arange(BEARINGS))


def _stop(place: int, values: list[float]) -> list[Record]:
    """Return where the robot stands, and one range of each bearing: the median of its 25.

    Taken one after another while nothing moves, the 25 repeat one measurement: they share its cone
    and its reflections, and fed one by one would count as 25 witnesses. Of a median less than half
    may be echoes gone astray; where most found none, none there is.
    """
    x, y, theta = pose_of(values[0] / 100.0, values[1] / 100.0, values[2])
    swept = np.array(values[3:]).reshape(BEARINGS, READINGS)
    swept[(swept <= 0.0) | (swept >= NO_ECHO_CM)] = np.inf
    ranges = (np.median(swept, axis=1) / 100.0).astype(np.float32)
    arrival = place * STOP
    standing = [
        OdometryRecord(arrival + moment, (x, y, theta), 0.0, 0.0)
        for moment in (0.0, LISTENING, LEAVING)
    ]
    return [*standing, SonarRecord(arrival + LISTENING, ranges, MOUNTS, CONE, NO_ECHO_CM / 100.0)]


EV3 = TableFormat("ev3", 3 + BEARINGS * READINGS, _stop)
