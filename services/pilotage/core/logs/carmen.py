"""Lines of CARMEN logs (the Carnegie Mellon navigation toolkit), and our lines COMPASS, COMMAND.

Every message of CARMEN ends with `timestamp host logger_timestamp`; the first is the
measurement's own and is the one used.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.logs.line_format import LineFormat, numbers, pose_of
from pilotage.core.logs.records import (
    CommandRecord,
    HeadingRecord,
    OdometryRecord,
    Pose,
    ScanRecord,
    SonarRecord,
    TruthRecord,
)

FLASER_RANGE_MAX = 50.0
"""FLASER does not say its maximum range, and logs mark no return by 50, 51.15, 81.83 or 81.91 m;
SICK's LMS 200 is specified to 50 m in the indoor settings that such logs were made with."""
NO_RETURN_FROM = 0.99
"""From this part of the maximum range on, nothing came back: sensors report a bit less than it."""
SONAR_RANGE_MAX = 4.0
"""Farthest echo of a sonar [m], which SONAR does not state (MORCS-2, Li 2008)."""
SONAR_CONE = math.radians(25.0)
"""Of logs that put something else than radians where the cone belongs (Li 2008)."""
FARTHEST_MOUNT = 100.0
"""No robot is larger [m], and no direction is given in so many turns."""
_TAIL = 3
"""Words after a message: timestamp, host, logger's timestamp."""


def _odometry(words: list[bytes]) -> OdometryRecord:
    """`ODOM x y theta tv rv acceleration` and the tail."""
    x, y, theta, linear, angular, _, stamp = numbers(words, 1, 7)
    _expect_tail(words, 7)
    return OdometryRecord(stamp, pose_of(x, y, theta), linear, angular)


def _flaser(words: list[bytes]) -> ScanRecord:
    """`FLASER n r1..rn laser_x y theta robot_x y theta` and the tail."""
    count = _count(words, 1)
    end = 2 + count
    values = numbers(words, 2, count + 7)
    _expect_tail(words, end + 6)
    laser, robot = pose_of(*values[count : count + 3]), pose_of(*values[count + 3 : count + 6])
    return ScanRecord(
        stamp=values[-1],
        ranges=_ranges(values[:count], FLASER_RANGE_MAX),
        angle_min=-math.pi / 2.0,
        angle_increment=_flaser_increment(count),
        range_max=FLASER_RANGE_MAX,
        odom_pose=robot,
        laser_mount=_mount(robot, laser),
    )


def _robot_laser(words: list[bytes]) -> ScanRecord:
    """`ROBOTLASER1`: as RAWLASER1, then laser pose, robot pose, five values, the tail."""
    scan, end = _laser_head(words)
    values = numbers(words, end, 12)
    _expect_tail(words, end + 11)
    laser, robot = pose_of(*values[0:3]), pose_of(*values[3:6])
    return ScanRecord(values[11], *scan, odom_pose=robot, laser_mount=_mount(robot, laser))


def _raw_laser(words: list[bytes]) -> ScanRecord:
    """`RAWLASER1`: type, start, field of view, resolution, maximum range, two, n, ranges, m, ..."""
    scan, end = _laser_head(words)
    (stamp,) = numbers(words, end, 1)
    _expect_tail(words, end)
    return ScanRecord(stamp, *scan, odom_pose=None, laser_mount=(0.0, 0.0, 0.0))


def _laser_head(
    words: list[bytes],
) -> tuple[tuple[NDArray[np.float32], float, float, float], int]:
    """Return ranges, start, increment and maximum of a laser that says them, and where it ends."""
    start, view, increment, range_max = numbers(words, 2, 4)
    count = _count(words, 8)
    ranges = _ranges(numbers(words, 9, count), range_max)
    remissions = _count(words, 9 + count, least=0)
    if range_max <= 0.0:
        raise ValueError(f"a maximum range of {range_max}")
    if increment <= 0.0:
        increment = view / (count - 1)
    return (ranges, start, increment, range_max), 10 + count + remissions


def _sonar(words: list[bytes]) -> SonarRecord:
    """`SONAR cone n r1..rn x1 y1 theta1 .. xn yn thetan` and the tail."""
    count = _count(words, 2, least=1)
    values = numbers(words, 3, 4 * count + 1)
    _expect_tail(words, 3 + 4 * count)
    (cone,) = numbers(words, 1, 1)
    mounts = np.array(values[count:-1]).reshape(count, 3)
    if np.abs(mounts).max() > FARTHEST_MOUNT:
        raise ValueError("a sonar that is impossibly far from its robot")
    return SonarRecord(
        stamp=values[-1],
        ranges=_ranges(values[:count], SONAR_RANGE_MAX / NO_RETURN_FROM),
        mounts=mounts,
        cone=cone if 0.0 < cone <= math.pi else SONAR_CONE,
        range_max=SONAR_RANGE_MAX,
    )


def _truth(words: list[bytes]) -> TruthRecord:
    """`TRUEPOS x y theta odom_x odom_y odom_theta` and the tail."""
    values = numbers(words, 1, 7)
    _expect_tail(words, 7)
    return TruthRecord(values[6], pose_of(*values[:3]))


def _compass(words: list[bytes]) -> HeadingRecord:
    """`COMPASS heading_rad sigma_rad stamp`, a line of ours."""
    heading, sigma, stamp = numbers(words, 1, 3)
    if sigma <= 0.0:
        raise ValueError(f"a standard deviation of {sigma}")
    return HeadingRecord(stamp, pose_of(0.0, 0.0, heading)[2], sigma)


def _command(words: list[bytes]) -> CommandRecord:
    """`COMMAND v w stamp`, a line of ours: the twist asked for from then on, m/s and rad/s."""
    linear, angular, stamp = numbers(words, 1, 3)
    return CommandRecord(stamp, linear, angular)


def _expect_tail(words: list[bytes], stamp_at: int) -> None:
    """Refuse a line that ends before its tail does: even its stamp may be cut."""
    if len(words) < stamp_at + _TAIL:
        raise ValueError("too few values")


def _count(words: list[bytes], at: int, least: int = 2) -> int:
    """Return the number of values that a line announces."""
    (value,) = numbers(words, at, 1)
    if not (least <= value <= 1e5 and value.is_integer()):
        raise ValueError(f"{value:g} values announced")
    return int(value)


def _ranges(values: list[float], range_max: float) -> NDArray[np.float32]:
    """Return ranges with infinity where the sensor says that nothing came back."""
    ranges = np.array(values)
    ranges[(ranges <= 0.0) | (ranges >= NO_RETURN_FROM * range_max)] = np.inf
    return ranges.astype(np.float32)


def _flaser_increment(count: int) -> float:
    """Return the angle between beams: half a circle, its last beam present or left out."""
    steps = count if count in {180, 360} else count - 1
    return math.pi / steps


def _mount(robot: Pose, laser: Pose) -> Pose:
    """Return the laser's pose in base_link."""
    x, y, theta = se2.between(robot, laser).tolist()
    return x, y, theta


CARMEN = LineFormat(
    name="carmen",
    parsers={
        b"ODOM": _odometry,
        b"FLASER": _flaser,
        b"ROBOTLASER1": _robot_laser,
        b"RAWLASER1": _raw_laser,
        b"SONAR": _sonar,
        b"TRUEPOS": _truth,
        b"COMPASS": _compass,
        b"COMMAND": _command,
    },
    # A log may hold the same scan in several of these; the most informative one comes first.
    alternatives=(b"ROBOTLASER1", b"FLASER", b"RAWLASER1"),
)
