import math
from dataclasses import replace

import numpy as np
import pytest

from dead_reckoning import DeadReckoning
from pilotage.core.logs import (
    CommandRecord,
    HeadingRecord,
    Log,
    OdometryRecord,
    Pose,
    Record,
    ScanRecord,
    SonarRecord,
    TruthRecord,
)
from pilotage.mapper.log_run import (
    LogUse,
    UnusableLogError,
    as_scan,
    map_records,
    records_of,
    sensor_of,
    thinned,
)

LASER, SONAR = LogUse("laser"), LogUse("sonar")
DRONE = np.deg2rad([-90.0, 0.0, 90.0, 180.0])


def odometry(stamp: float, x: float) -> OdometryRecord:
    return OdometryRecord(stamp, (x, 0.0, 0.0))


def scan(stamp: float, odom_pose: Pose | None = None, beams: int = 5) -> ScanRecord:
    ranges = np.arange(1.0, beams + 1.0, dtype=np.float32)
    return ScanRecord(stamp, ranges, -1.0, 2.0 / max(beams - 1, 1), 10.0, odom_pose, (0.1, 0, 0))


def sonar(stamp: float, directions: np.ndarray = DRONE, cone: float = 0.1) -> SonarRecord:
    mounts = np.column_stack([np.zeros((len(directions), 2)), directions])
    return SonarRecord(stamp, np.ones(len(directions), np.float32), mounts, cone, 4.0)


def log_of(*records: Record) -> Log:
    return Log("test", tuple(sorted(records, key=lambda record: record.stamp)), 0)


def scans_of(log: Log, use: LogUse = LASER) -> list[ScanRecord]:
    return [record for record in records_of(log, use) if isinstance(record, ScanRecord)]


def test_odometry_comes_before_the_scan_of_the_same_time() -> None:
    log = log_of(scan(1.0, (0.0, 0.0, 0.0)), odometry(1.0, 0.0), odometry(2.0, 1.0))
    kinds = [type(record).__name__ for record in records_of(log, LASER)]
    assert kinds == ["OdometryRecord", "ScanRecord", "OdometryRecord"]


def test_scan_between_two_odometry_poses_lies_between_them() -> None:
    (placed,) = scans_of(log_of(odometry(1.0, 0.0), scan(1.25), odometry(2.0, 1.0)))
    assert placed.odom_pose == pytest.approx((0.25, 0.0, 0.0))


def test_scan_that_says_its_odometry_is_believed() -> None:
    pose = (3.0, 0.0, 0.0)
    (placed,) = scans_of(log_of(odometry(1.0, 0.0), scan(1.5, pose), odometry(2.0, 1.0)))
    assert placed.odom_pose == pose


def test_scans_outside_the_time_of_odometry_or_in_its_gaps_are_left_out() -> None:
    log = log_of(scan(0.5), odometry(1.0, 0.0), scan(1.0), scan(20.0), odometry(40.0, 9.0))
    assert [placed.stamp for placed in scans_of(log)] == [1.0]


def test_scans_with_odometry_give_it_to_a_log_without() -> None:
    log = log_of(scan(1.0, (0.0, 0.0, 0.0)), scan(2.0, (1.0, 0.0, 0.0)))
    poses = [r.pose for r in records_of(log, LASER) if isinstance(r, OdometryRecord)]
    assert poses == [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]


def test_what_comes_twice_is_fed_once() -> None:
    log = log_of(*(record for _ in range(2) for record in (odometry(1.0, 0.0), scan(1.0))))
    kinds = [type(record).__name__ for record in records_of(log, LASER)]
    assert kinds == ["OdometryRecord", "ScanRecord"]


def test_two_scans_of_one_coarse_stamp_are_both_fed() -> None:
    other = replace(scan(1.0), ranges=np.full(5, 7.0, np.float32))
    assert len(scans_of(log_of(odometry(1.0, 0.0), scan(1.0), other))) == 2


def test_compass_commands_and_the_chosen_sensor_are_fed() -> None:
    others = HeadingRecord(1.0, 0.1, 0.1), CommandRecord(1.0, 0.2, 0.0)
    truth = TruthRecord(1.0, (0.0, 0.0, 0.0))
    log = log_of(odometry(1.0, 0.0), *others, truth, scan(1.0), sonar(1.0))
    fed = records_of(log, SONAR)
    assert {type(record) for record in fed} >= {HeadingRecord, CommandRecord, SonarRecord}
    assert not any(isinstance(record, ScanRecord) for record in fed)
    assert not any(isinstance(record, SonarRecord) for record in records_of(log, LASER))


def test_log_is_mapped_by_the_laser_if_it_has_one() -> None:
    assert sensor_of(log_of(odometry(1.0, 0.0), scan(1.0), sonar(1.0))) == "laser"
    assert sensor_of(log_of(odometry(1.0, 0.0), sonar(1.0))) == "sonar"


@pytest.mark.parametrize(
    ("log", "use", "reason"),
    [
        (log_of(odometry(1.0, 0.0)), LASER, "no laser measurements"),
        (log_of(odometry(1.0, 0.0), scan(1.0)), SONAR, "no sonar measurements"),
        (log_of(scan(1.0)), LASER, "no odometry"),
        (log_of(sonar(1.0)), SONAR, "no odometry"),
        (log_of(odometry(1.0, 0.0), scan(2.0)), LASER, "within the time of the odometry"),
    ],
)
def test_log_that_lacks_what_is_needed_says_what(log: Log, use: LogUse, reason: str) -> None:
    with pytest.raises(UnusableLogError, match=reason):
        records_of(log, use)


@pytest.mark.parametrize(("count", "beams"), [(180, 11), (360, 11), (181, 2), (5, 3), (7, 6)])
def test_few_beams_are_spread_evenly_about_the_middle(count: int, beams: int) -> None:
    whole = scan(1.0, beams=count)
    few = thinned(whole, beams)
    bearings = whole.angle_min + whole.angle_increment * (few.ranges - 1.0)
    assert len(few.ranges) == beams
    expected = few.angle_min + few.angle_increment * np.arange(beams)
    assert bearings == pytest.approx(expected, abs=1e-6)
    assert abs(expected.mean()) <= whole.angle_increment
    assert np.ptp(expected) > 0.5 * np.ptp(whole.angle_increment * np.arange(count))


def test_thinning_leaves_a_scan_of_fewer_beams_alone() -> None:
    whole = scan(1.0)
    assert thinned(whole, 5) is whole
    assert thinned(whole, None) is whole
    assert thinned(whole, 1).ranges.tolist() == [3.0]


def test_four_narrow_beams_are_a_laser_of_four_beams() -> None:
    found = as_scan(sonar(1.0))
    assert found is not None
    assert (found.angle_min, found.angle_increment) == pytest.approx((-math.pi / 2, math.pi / 2))
    assert found.ranges.tolist() == [1.0] * 4
    assert len(scans_of(log_of(odometry(1.0, 0.0), sonar(1.0)))) == 1


def test_narrow_beams_from_the_rim_are_counted_from_the_centre() -> None:
    mounts = np.column_stack([0.05 * np.cos(DRONE), 0.05 * np.sin(DRONE), DRONE])
    found = as_scan(SonarRecord(1.0, np.ones(4, np.float32), mounts, 0.1, 4.0))
    assert found is not None
    assert found.ranges == pytest.approx(np.full(4, 1.05))


def test_wide_or_uneven_rings_are_no_laser() -> None:
    assert as_scan(sonar(1.0, cone=0.4)) is None
    assert as_scan(sonar(1.0, np.array([0.0, 1.0, 1.5]))) is None
    assert as_scan(sonar(1.0, np.array([0.0]))) is None


def test_a_stamp_comes_out_for_each_scan_that_went_in() -> None:
    method = DeadReckoning()
    records = records_of(log_of(odometry(1.0, 0.0), scan(1.5), odometry(2.0, 1.0)), LASER)
    assert list(map_records(records, method)) == [1.5]
    assert method.records == records


def test_log_of_only_odometry_lacks_both_sensors() -> None:
    with pytest.raises(UnusableLogError, match="neither laser scans nor sonar rounds"):
        sensor_of(log_of(odometry(1.0, 0.0)))


def test_jump_of_odometry_is_not_driven() -> None:
    log = log_of(odometry(1.0, 0.0), scan(1.1, (0.1, 0.0, 0.0)), odometry(1.2, 1e6))
    xs = [r.pose[0] for r in records_of(log, LASER) if isinstance(r, OdometryRecord)]
    np.testing.assert_allclose(xs, [0.0, 0.1])
