"""Lines of the CMU Wean Hall logs: `O` odometry and `L` laser, in cm, rad and s."""

import math

import numpy as np

from pilotage.core import se2
from pilotage.core.logs.line_format import LineFormat, numbers, pose_of
from pilotage.core.logs.records import OdometryRecord, Pose, ScanRecord

BEAMS = 180
"""From -90 degrees (right) to +90 (left), both ends included in the count of the data set."""
NO_RETURN_CM = 8183.0
"""This and more means that nothing came back."""


def _odometry(words: list[bytes]) -> OdometryRecord:
    """`O x y theta t`."""
    _expect_words(words, 5)
    values = numbers(words, 1, 4)
    return OdometryRecord(values[3], _pose(values[:3]))


def _scan(words: list[bytes]) -> ScanRecord:
    """`L x y theta laser_x laser_y laser_theta r1..r180 t`."""
    _expect_words(words, 8 + BEAMS)
    values = numbers(words, 1, 7 + BEAMS)
    robot, laser = _pose(values[0:3]), _pose(values[3:6])
    ranges = np.array(values[6:-1])
    ranges[(ranges <= 0.0) | (ranges >= NO_RETURN_CM)] = np.inf
    x, y, theta = se2.between(robot, laser).tolist()
    return ScanRecord(
        stamp=values[-1],
        ranges=(ranges / 100.0).astype(np.float32),
        angle_min=-math.pi / 2.0,
        angle_increment=math.radians(1.0),
        range_max=NO_RETURN_CM / 100.0,
        odom_pose=robot,
        laser_mount=(x, y, theta),
    )


def _expect_words(words: list[bytes], count: int) -> None:
    """Refuse a cut line: were a word missing, a range would be taken for the stamp."""
    if len(words) != count:
        raise ValueError(f"{len(words)} values instead of {count}")


def _pose(values: list[float]) -> Pose:
    """Return a pose in m from one in cm."""
    return pose_of(values[0] / 100.0, values[1] / 100.0, values[2])


WEAN = LineFormat(name="wean", parsers={b"O": _odometry, b"L": _scan})
