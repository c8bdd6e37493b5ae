"""Mapping over a recorded log, without a bus: the same mathematics as the service."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import compress, pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.logs import Log, OdometryRecord, Pose, Record, ScanRecord, SonarRecord
from pilotage.mapper.method import MappingMethod
from pilotage.mapper.odometry_joins import without_jumps

Stamped = TypeVar("Stamped", OdometryRecord, ScanRecord)

NARROW_CONE = math.radians(10.0)
"""Rangers with a cone up to this are as good as the beams of a laser."""

LONGEST_GAP = 5.0
"""Between two odometry poses [s]: where the robot was in a longer one, nobody knows."""


class UnusableLogError(ValueError):
    """The log lacks what a map needs; the text says what."""


@dataclass(frozen=True)
class LogUse:
    """Which sensor draws the map, and of a laser how many beams, evenly spread; None is all."""

    sensor: str = "laser"
    beams: int | None = None


def sensor_of(log: Log) -> str:
    """Return the sensor that a log is best mapped with; UnusableLogError if it has none."""
    if log.scans:
        return "laser"
    if any(isinstance(record, SonarRecord) for record in log.records):
        return "sonar"
    raise UnusableLogError("the log has neither laser scans nor sonar rounds")


def records_of(log: Log, use: LogUse) -> list[Record]:
    """Return what a method is fed with, in order of time, each scan with its odometry.

    Sonar rounds are left out for the laser and scans for the sonar, and what comes twice. Scans
    that say their odometry where the log has no line for it give the method one. Odometry that
    jumped goes on as if it had not. Narrow rangers
    count as a laser of few beams where there is no laser.

    Raises:
        UnusableLogError: no measurement of this sensor, or no odometry.
    """
    measured = _measured(log, use)
    if not measured:
        raise UnusableLogError(f"the log has no {use.sensor} measurements")
    odometry = _without_repeats(log.odometry or _odometry_of_scans(measured))
    if not odometry:
        raise UnusableLogError("the log has no odometry, without which nothing is mapped")
    others = [
        r for r in log.records if not isinstance(r, ScanRecord | SonarRecord | OdometryRecord)
    ]
    placed = _placed(measured, odometry)
    if not placed:
        raise UnusableLogError(f"no {use.sensor} measurement lies within the time of the odometry")
    # At the same time odometry comes before what needs it.
    order: list[Record] = [*odometry, *others, *placed]
    order.sort(key=lambda r: (r.stamp, not isinstance(r, OdometryRecord)))
    return without_jumps(order)


def map_records(records: list[Record], method: MappingMethod) -> Iterator[float]:
    """Feed a method; yield the stamp [s] of each scan or sonar round once it is taken in."""
    for record in records:
        method.process(record)
        if isinstance(record, ScanRecord | SonarRecord):
            yield record.stamp


def thinned(scan: ScanRecord, beams: int | None) -> ScanRecord:
    """Return a scan with only so many of its beams, at equal angles and about its middle."""
    count = len(scan.ranges)
    if beams is None or beams >= count:
        return scan
    every = (count - 1) // (beams - 1) if beams > 1 else 1
    first = (count - 1 - every * (beams - 1)) // 2
    return replace(
        scan,
        ranges=scan.ranges[first : first + every * (beams - 1) + 1 : every].copy(),
        angle_min=scan.angle_min + first * scan.angle_increment,
        angle_increment=every * scan.angle_increment,
    )


def as_scan(sonar: SonarRecord) -> ScanRecord | None:
    """Return narrow rangers that look outward at equal angles as a scan; None if they do not."""
    directions = np.unwrap(sonar.mounts[:, 2])
    steps = np.diff(directions)
    ahead = np.stack([np.cos(sonar.mounts[:, 2]), np.sin(sonar.mounts[:, 2])], axis=1)
    aside = np.abs(ahead[:, 0] * sonar.mounts[:, 1] - ahead[:, 1] * sonar.mounts[:, 0])
    is_even = len(steps) > 0 and np.ptp(steps) < 1e-3 and steps[0] > 0.0
    if sonar.cone > NARROW_CONE or not is_even or aside.max() > 0.01:
        return None
    from_centre = np.sum(ahead * sonar.mounts[:, :2], axis=1)
    return ScanRecord(
        stamp=sonar.stamp,
        ranges=(sonar.ranges + from_centre).astype(np.float32),
        angle_min=wrap(float(directions[0])),
        angle_increment=float(steps.mean()),
        range_max=sonar.range_max + float(from_centre.max()),
        odom_pose=None,
        laser_mount=(0.0, 0.0, 0.0),
    )


def _measured(log: Log, use: LogUse) -> list[ScanRecord | SonarRecord]:
    rounds = [record for record in log.records if isinstance(record, SonarRecord)]
    if use.sensor == "sonar":
        return list(rounds)
    scans = log.scans or tuple(scan for r in rounds if (scan := as_scan(r)) is not None)
    return [thinned(scan, use.beams) for scan in _without_repeats(scans)]


def _repeats(record: OdometryRecord | ScanRecord, last: OdometryRecord | ScanRecord) -> bool:
    """Say whether a record is the last one again; coarse stamps may give two scans the same."""
    if record.stamp > last.stamp:
        return False
    if isinstance(record, ScanRecord) and isinstance(last, ScanRecord):
        return np.array_equal(record.ranges, last.ranges)
    return True


def _without_repeats(records: tuple[Stamped, ...]) -> tuple[Stamped, ...]:
    """Return the records that are not the one before again: that is no news."""
    is_new = [True, *(not _repeats(record, last) for last, record in pairwise(records))]
    return tuple(compress(records, is_new))


def _odometry_of_scans(measured: list[ScanRecord | SonarRecord]) -> tuple[OdometryRecord, ...]:
    return tuple(
        OdometryRecord(r.stamp, r.odom_pose)
        for r in measured
        if isinstance(r, ScanRecord) and r.odom_pose is not None
    )


def _placed(
    measured: list[ScanRecord | SonarRecord], odometry: tuple[OdometryRecord, ...]
) -> list[ScanRecord | SonarRecord]:
    """Return the measurements that odometry covers, scans with their pose in odom."""
    stamps = np.array([record.stamp for record in odometry])
    poses = np.array([record.pose for record in odometry])
    placed: list[ScanRecord | SonarRecord] = []
    for record in measured:
        match record, _pose_at(record.stamp, stamps, poses):
            case ScanRecord(odom_pose=None), None:
                continue
            case ScanRecord(odom_pose=None), pose:
                placed.append(replace(record, odom_pose=pose))
            case (ScanRecord(), _) | (SonarRecord(), tuple()):
                placed.append(record)
    return placed


def _pose_at(stamp: float, stamps: NDArray[np.float64], poses: NDArray[np.float64]) -> Pose | None:
    """Return the pose at a time, between its neighbours; None where these are missing or far."""
    after = int(np.searchsorted(stamps, stamp))
    if after < len(stamps) and stamps[after] == stamp:
        x, y, theta = poses[after].tolist()
        return x, y, theta
    if after in {0, len(stamps)} or stamps[after] - stamps[after - 1] > LONGEST_GAP:
        return None
    share = (stamp - stamps[after - 1]) / (stamps[after] - stamps[after - 1])
    x, y, theta = se2.interpolate(poses[after - 1], poses[after], float(share)).tolist()
    return x, y, theta
