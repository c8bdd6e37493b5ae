"""Localization over a recorded log, without a bus: the same mathematics as the service."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.logs import HeadingRecord, Log, OdometryRecord, ScanRecord, SonarRecord
from pilotage.core.odometry_buffer import OdometryBuffer
from pilotage.localizer.compass_memory import CompassMemory
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.measurement import (
    Measurement,
    ranges_measurement,
    scan_measurement,
)
from pilotage.localizer.method import LocalizationMethod

EXTRAPOLATION_NS = 500_000_000
"""Logs that state odometry rarely: the last motion is taken to go on for so long."""


@dataclass(frozen=True)
class LogEstimate:
    """The estimate after one scan: pose (3,) of base_link in map; `updated` if it was weighed."""

    stamp: float
    pose: NDArray[np.float64]
    estimate: Estimate
    updated: bool


@dataclass(frozen=True)
class LogSensors:
    """Which records of a log are used: laser scans or sonar rounds, and the compass."""

    sensor: str = "laser"
    compass: bool = True


def localize_log(log: Log, localizer: LocalizationMethod, use: LogSensors) -> Iterator[LogEstimate]:
    """Yield an estimate for each scan (or sonar round) of the log.

    A scan that odometry cannot place, as those before its first record, changes nothing.
    """
    odometry, compass = OdometryBuffer(), CompassMemory()
    for record in _odometry_first(log):
        stamp_ns = round(record.stamp * 1e9)
        match record:
            case OdometryRecord():
                odometry.append(stamp_ns, record.pose)
            case HeadingRecord() if use.compass:
                odom = odometry.pose_at(stamp_ns, EXTRAPOLATION_NS)
                if odom is not None:
                    compass.keep(stamp_ns, (record.yaw, record.sigma), float(odom[2]))
            case ScanRecord() | SonarRecord() if _is_used(record, use):
                odom = _odom_pose(record, odometry)
                if odom is None:
                    now = localizer.estimate
                    yield LogEstimate(record.stamp, now.pose, now, updated=False)
                else:
                    word = compass.at(stamp_ns, float(odom[2]))
                    measurement = _measurement(record, localizer).with_compass(word)
                    yield _estimate(localizer, stamp_ns, odom, measurement)


def _odometry_first(log: Log) -> list[OdometryRecord | ScanRecord | HeadingRecord | SonarRecord]:
    """Return the records in order of time; at the same time odometry comes before what needs it."""
    used = [
        r
        for r in log.records
        if isinstance(r, OdometryRecord | ScanRecord | HeadingRecord | SonarRecord)
    ]
    return sorted(used, key=lambda r: (r.stamp, not isinstance(r, OdometryRecord)))


def _is_used(record: ScanRecord | SonarRecord, use: LogSensors) -> bool:
    return isinstance(record, ScanRecord) == (use.sensor == "laser")


def _odom_pose(
    record: ScanRecord | SonarRecord, odometry: OdometryBuffer
) -> NDArray[np.float64] | None:
    if isinstance(record, ScanRecord) and record.odom_pose is not None:
        return np.array(record.odom_pose)
    return odometry.pose_at(round(record.stamp * 1e9), EXTRAPOLATION_NS)


def _measurement(record: ScanRecord | SonarRecord, localizer: LocalizationMethod) -> Measurement:
    if isinstance(record, ScanRecord):
        angles = record.angle_min, record.angle_increment
        beams = localizer.params.beams
        return scan_measurement(record.ranges, angles, record.laser_mount, beams, record.range_max)
    mounts = record.mounts.astype(np.float32)
    return ranges_measurement(record.ranges, mounts, record.range_max)


def _estimate(
    localizer: LocalizationMethod,
    stamp_ns: int,
    odom: NDArray[np.float64],
    measurement: Measurement,
) -> LogEstimate:
    updates = localizer.wants(stamp_ns, odom, measurement)
    if updates:
        localizer.update(stamp_ns, odom, measurement)
    return LogEstimate(stamp_ns / 1e9, localizer.pose_at(odom), localizer.estimate, updates)
