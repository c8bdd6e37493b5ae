import gzip
import math
from pathlib import Path

import numpy as np
import pytest

from pilotage.core.logs import (
    CommandRecord,
    HeadingRecord,
    Log,
    LogError,
    OdometryRecord,
    ScanRecord,
    SonarRecord,
    TruthRecord,
    read_log,
)

ODOM = "ODOM 1.0 2.0 4.0 0.5 -0.1 0 10.5 robot 0.25"
TAIL = "10.0 robot 0.2"


def flaser(ranges: list[float], laser: str = "1.0 0.0 0.0", robot: str = "1.0 0.0 0.0") -> str:
    return f"FLASER {len(ranges)} {' '.join(map(str, ranges))} {laser} {robot} {TAIL}"


def robotlaser(ranges: list[float], increment: float = 0.5) -> str:
    values = " ".join(map(str, ranges))
    head = f"ROBOTLASER1 0 -0.5 1.0 {increment} 20.0 0.01 0 {len(ranges)} {values}"
    return f"{head} 2 7 8 1.1 0.0 0.0 1.0 0.0 0.0 0.3 0.1 0.5 0.4 1e6 {TAIL}"


def read(folder: Path, *lines: str, log_format: str | None = None) -> Log:
    file = folder / "run.log"
    file.write_text("\n".join(lines) + "\n")
    return read_log(file, log_format)


def only_scan(log: Log) -> ScanRecord:
    (scan,) = log.scans
    return scan


def test_odometry_has_pose_speeds_and_the_stamp_of_the_measurement(tmp_path: Path) -> None:
    (record,) = read(tmp_path, ODOM).records
    assert isinstance(record, OdometryRecord)
    assert record.stamp == 10.5
    assert record.pose == pytest.approx((1.0, 2.0, 4.0 - 2.0 * math.pi))
    assert (record.linear, record.angular) == (0.5, -0.1)


@pytest.mark.parametrize(
    ("count", "degrees"), [(180, 1.0), (181, 1.0), (360, 0.5), (361, 0.5), (91, 2.0)]
)
def test_flaser_spans_half_a_circle_from_the_right(
    tmp_path: Path, count: int, degrees: float
) -> None:
    scan = only_scan(read(tmp_path, flaser([2.0] * count)))
    assert len(scan.ranges) == count
    assert scan.angle_min == pytest.approx(-math.pi / 2.0)
    assert scan.angle_increment == pytest.approx(math.radians(degrees))


def test_flaser_ranges_of_no_return_are_infinite(tmp_path: Path) -> None:
    scan = only_scan(read(tmp_path, flaser([1.0, 0.0, 49.4, 50.0, 81.83, 81.91])))
    assert scan.ranges.dtype == np.float32
    assert scan.ranges.tolist() == pytest.approx([1.0, np.inf, 49.4, np.inf, np.inf, np.inf])
    assert scan.range_max == 50.0


def test_flaser_says_where_the_robot_was_and_where_its_laser_sits(tmp_path: Path) -> None:
    half_pi = str(math.pi / 2.0)
    line = flaser([1.0, 2.0], laser=f"1.0 2.1 {half_pi}", robot=f"1.0 2.0 {half_pi}")
    scan = only_scan(read(tmp_path, line))
    assert scan.odom_pose == pytest.approx((1.0, 2.0, math.pi / 2.0))
    assert scan.laser_mount == pytest.approx((0.1, 0.0, 0.0))


def test_laser_poses_that_were_corrected_are_no_mount(tmp_path: Path) -> None:
    log = read(tmp_path, flaser([1.0, 2.0]), flaser([1.0, 2.0], laser="1.3 0.2 0.1"))
    assert [scan.laser_mount for scan in log.scans] == [(0.0, 0.0, 0.0)] * 2


def test_robotlaser_says_its_own_angles_and_range(tmp_path: Path) -> None:
    scan = only_scan(read(tmp_path, robotlaser([1.0, 19.9, 3.0])))
    assert (scan.angle_min, scan.angle_increment, scan.range_max) == (-0.5, 0.5, 20.0)
    assert scan.ranges.tolist() == pytest.approx([1.0, np.inf, 3.0])
    assert scan.odom_pose == (1.0, 0.0, 0.0)
    assert scan.laser_mount == pytest.approx((0.1, 0.0, 0.0))
    assert scan.stamp == 10.0


def test_missing_angular_resolution_follows_from_the_field_of_view(tmp_path: Path) -> None:
    assert only_scan(read(tmp_path, robotlaser([1.0] * 5, increment=0.0))).angle_increment == 0.25


def test_rawlaser_has_no_pose(tmp_path: Path) -> None:
    line = f"RAWLASER1 0 -1.5 3.0 1.5 8.0 0.01 0 3 1.0 2.0 8.0 0 {TAIL}"
    scan = only_scan(read(tmp_path, line))
    assert scan.odom_pose is None
    assert scan.ranges.tolist() == [1.0, 2.0, np.inf]


def test_scan_that_is_logged_in_several_shapes_is_read_once(tmp_path: Path) -> None:
    raw = f"RAWLASER1 0 -1.5 3.0 1.5 8.0 0.01 0 2 1.0 2.0 0 {TAIL}"
    assert len(read(tmp_path, raw, flaser([1.0, 2.0])).scans) == 1
    log = read(tmp_path, raw, flaser([1.0, 2.0]), robotlaser([5.0, 6.0, 7.0]))
    assert only_scan(log).ranges.tolist() == [5.0, 6.0, 7.0]
    assert log.skipped_lines == 0


def test_sonar_has_ranges_mounts_and_cone(tmp_path: Path) -> None:
    line = f"SONAR 0.26 2 1.5 2.5 0.1 0.1 1.57 0.1 -0.1 -1.57 {TAIL}"
    (record, _) = read(tmp_path, line, ODOM).records
    assert isinstance(record, SonarRecord)
    assert record.ranges.tolist() == [1.5, 2.5]
    assert record.mounts.tolist() == [[0.1, 0.1, 1.57], [0.1, -0.1, -1.57]]
    assert (record.cone, record.range_max) == (0.26, 4.0)


def test_sonar_without_an_echo_is_infinite(tmp_path: Path) -> None:
    line = f"SONAR 25 3 0.0 3.9 5.0 0 0 0 0 0 1 0 0 2 {TAIL}"
    (record, _) = read(tmp_path, line, ODOM).records
    assert isinstance(record, SonarRecord)
    assert record.ranges.tolist() == pytest.approx([np.inf, 3.9, np.inf])
    assert record.cone == pytest.approx(math.radians(25.0))


def test_command_says_the_twist_asked_for(tmp_path: Path) -> None:
    log = read(tmp_path, "COMMAND 0.2 -0.1 9.5", ODOM)
    assert log.records[0] == CommandRecord(9.5, 0.2, -0.1)


def test_true_poses_and_compass_are_read(tmp_path: Path) -> None:
    log = read(tmp_path, ODOM, f"TRUEPOS 1 2 0.5 0 0 0 {TAIL}", "COMPASS 3.5 0.1 9.0")
    heading, truth, _ = log.records
    assert isinstance(heading, HeadingRecord)
    assert heading.yaw == pytest.approx(3.5 - 2.0 * math.pi)
    assert heading.sigma == 0.1
    assert truth == TruthRecord(10.0, (1.0, 2.0, 0.5))


def test_records_come_in_order_of_time(tmp_path: Path) -> None:
    log = read(tmp_path, ODOM, flaser([1.0, 2.0]))
    assert [record.stamp for record in log.records] == [10.0, 10.5]
    assert log.duration == 0.5


def test_comments_parameters_and_other_messages_are_passed_over(tmp_path: Path) -> None:
    log = read(
        tmp_path, "# a comment", "PARAM robot_length 0.5", "", "RLASER 1 2", "NMEAGGA x", ODOM
    )
    assert len(log.records) == 1
    assert log.skipped_lines == 0


def test_packed_log_is_read_under_any_name(tmp_path: Path) -> None:
    for name in ("run.log.gz", "run"):
        (tmp_path / name).write_bytes(gzip.compress(ODOM.encode()))
        assert len(read_log(tmp_path / name).odometry) == 1


@pytest.mark.parametrize("cut", [7, 12, 60, 300])
def test_truncated_last_line_is_counted_and_left_out(tmp_path: Path, cut: int) -> None:
    log = read(tmp_path, ODOM, flaser([1.5] * 180)[:cut])
    assert len(log.records) == 1
    assert log.skipped_lines == 1


def test_damaged_line_in_the_middle_is_counted_and_left_out(tmp_path: Path) -> None:
    log = read(tmp_path, ODOM, "ODOM 1.0 nan 0 0 0 0 11 robot 1", "FLASER x", "\x00\xff", ODOM)
    assert len(log.records) == 2
    assert log.skipped_lines == 3


def test_log_with_more_damaged_lines_than_a_few_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"line 2: .*\(30 lines are damaged"):
        read(tmp_path, ODOM, *["ODOM 1.0 2.0"] * 30)


REFUSED = {
    "empty": ("", "the log is empty"),
    "comments only": ("# nothing", "the log is empty"),
    "no known line": ("once upon a time", "no line of a known format"),
    "too few values": ("ODOM 1 2 3", "line 1: too few values"),
    "cut in its tail": ("ODOM 1 2 3 0 0 0 12", "line 1: too few values"),
    "not finite": ("ODOM 1 inf 3 0 0 0 12 robot 1", "line 1: values that are not finite"),
    "not numbers": ("ODOM 1 x 3 0 0 0 12 robot 1", "line 1: could not convert"),
    "no count": ("FLASER 1.5 3", "line 1: 1.5 values announced"),
    "hopeless count": ("FLASER 1e9 3", "line 1: 1e.09 values announced"),
    "far away": ("ODOM 1e30 2 3 0 0 0 12 robot 1", "line 1: a pose that is impossibly far"),
    "no certainty": ("COMPASS 1 0 3", "line 1: a standard deviation of 0"),
    "compass only": ("COMPASS 1 0.1 3", "neither a laser scan nor odometry"),
    "wean cut": ("O 1.0 2.0 3.0", "line 1: 4 values instead of 5"),
}


@pytest.mark.parametrize(("text", "reason"), REFUSED.values(), ids=REFUSED.keys())
def test_useless_log_is_refused_with_its_reason(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(LogError, match=reason) as refusal:
        read(tmp_path, text)
    assert "run.log" in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_missing_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"no\.log: the log does not exist"):
        read_log(tmp_path / "no.log")


def test_folder_without_a_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="a folder that is no log"):
        read_log(tmp_path)


def test_log_named_gz_that_is_not_packed_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.log.gz").write_text(ODOM)
    with pytest.raises(LogError, match=r"named \.gz but is not gzip"):
        read_log(tmp_path / "run.log.gz")


def test_cut_gzip_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.log.gz").write_bytes(gzip.compress(ODOM.encode())[:-9])
    with pytest.raises(LogError, match="damaged or cut off"):
        read_log(tmp_path / "run.log.gz")


def test_unknown_format_is_refused_with_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="unknown format 'ros9', known are carmen, wean"):
        read(tmp_path, ODOM, log_format="ros9")


def test_forced_format_does_not_read_the_lines_of_another(tmp_path: Path) -> None:
    assert read(tmp_path, ODOM, log_format="carmen").format == "carmen"
    with pytest.raises(LogError, match="neither a laser scan nor odometry in the format wean"):
        read(tmp_path, ODOM, log_format="wean")


WEAN_SCAN = "L 100 200 0 125 200 0 " + " ".join(["250"] * 179) + " 8183 7.5"


def test_wean_lines_are_in_centimetres(tmp_path: Path) -> None:
    log = read(tmp_path, "O 100.0 200.0 0.5 7.25", WEAN_SCAN)
    assert log.format == "wean"
    (odometry,) = log.odometry
    assert odometry == OdometryRecord(7.25, (1.0, 2.0, 0.5))
    scan = only_scan(log)
    assert scan.ranges[:179].tolist() == [2.5] * 179
    assert scan.ranges[179] == np.inf
    assert scan.stamp == 7.5


def test_wean_laser_sits_ahead_and_looks_from_right_to_left(tmp_path: Path) -> None:
    scan = only_scan(read(tmp_path, WEAN_SCAN))
    assert scan.laser_mount == pytest.approx((0.25, 0.0, 0.0))
    assert scan.odom_pose == (1.0, 2.0, 0.0)
    assert scan.angle_min == pytest.approx(-math.pi / 2.0)
    assert scan.angle_increment == pytest.approx(math.radians(1.0))
