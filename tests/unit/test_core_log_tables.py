"""Logs that are rows of numbers: ev3, ring8, nanodrone."""

import gzip
import math
from pathlib import Path

import numpy as np
import pytest

from pilotage.core.logs import Log, LogError, SonarRecord, read_log

DRONE_HEAD = "t_s,x_m,y_m,z_m,yaw_rad,r0_m,r1_m,r2_m,r3_m,r4_m(up)"


def read(folder: Path, *lines: str, name: str = "run.log", log_format: str | None = None) -> Log:
    (folder / name).write_text("\n".join(lines) + "\n")
    return read_log(folder / name, log_format)


def sonars(log: Log) -> list[SonarRecord]:
    return [record for record in log.records if isinstance(record, SonarRecord)]


def stop(pose: str, ranges: dict[int, list[float]] | None = None) -> str:
    """A row of ev3: 1 m everywhere but for the bearings given."""
    swept = [(ranges or {}).get(bearing, [100.0] * 25) for bearing in range(13)]
    return f"{pose} " + " ".join(str(value) for bearing in swept for value in bearing)


def test_ev3_row_is_a_stop_with_thirteen_bearings_from_left_to_right(tmp_path: Path) -> None:
    log = read(tmp_path, stop("0 0 0"), stop("50 -10 7.0"))
    assert log.format == "ev3"
    sonar = sonars(log)[1]
    assert np.rad2deg(sonar.mounts[:, 2]) == pytest.approx(np.arange(90.0, -91.0, -15.0))
    assert sonar.ranges == pytest.approx(np.ones(13))
    assert log.odometry[-1].pose == pytest.approx((0.5, -0.1, 7.0 - 2.0 * math.pi))


def test_ev3_robot_stands_while_it_listens(tmp_path: Path) -> None:
    log = read(tmp_path, stop("0 0 0"), stop("50 0 0"))
    heard = sonars(log)[1].stamp
    around = [r for r in log.odometry if abs(r.stamp - heard) <= 4.0]
    assert [record.stamp - heard for record in around] == [-4.0, 0.0, 4.0]
    assert {record.pose for record in around} == {(0.5, 0.0, 0.0)}
    assert {(record.linear, record.angular) for record in around} == {(0.0, 0.0)}


def test_ev3_readings_of_one_bearing_count_as_one(tmp_path: Path) -> None:
    strays = [50.0] * 12 + [99.0] * 13
    mostly_silent = [100.0] * 12 + [255.0] * 13
    (sonar,) = sonars(read(tmp_path, stop("0 0 0", {0: strays, 5: mostly_silent})))
    assert sonar.ranges[0] == pytest.approx(0.99)
    assert math.isinf(sonar.ranges[5])


def test_ev3_row_that_is_cut_is_counted_and_left_out(tmp_path: Path) -> None:
    log = read(tmp_path, stop("0 0 0"), stop("1 0 0")[:-3].rsplit(" ", 1)[0], stop("2 0 0"))
    assert log.skipped_lines == 1
    assert [sonar.stamp for sonar in sonars(log)] == [4.0, 24.0]


RING = ("1000 5110 1000 2000 3000 4000 5000 400 5110", "1200 5110 1 2 3 4 5 6 7")
POSES = ("1000 0 0 0", "1200 -50 20 900")


@pytest.mark.parametrize("given", ["", "measurement.txt", "poses.txt"])
def test_ring8_is_read_from_its_folder_or_either_of_its_files(tmp_path: Path, given: str) -> None:
    (tmp_path / "measurement.txt").write_text("\n".join(RING))
    (tmp_path / "poses.txt").write_text("\n".join(POSES))
    log = read_log(tmp_path / given)
    assert log.format == "ring8"
    assert log.duration == pytest.approx(0.2)
    sonar = sonars(log)[0]
    assert sonar.ranges.tolist() == pytest.approx([np.inf, 1, 2, 3, 4, 5, 0.4, np.inf])
    assert np.rad2deg(sonar.mounts[[0, -1], 2]) == pytest.approx([-90.0, 90.0])
    assert log.odometry[-1].pose == pytest.approx((-0.05, 0.02, math.pi / 2.0))


def test_packed_ring8_is_read(tmp_path: Path) -> None:
    (tmp_path / "measurement.txt.gz").write_bytes(gzip.compress("\n".join(RING).encode()))
    (tmp_path / "poses.txt.gz").write_bytes(gzip.compress("\n".join(POSES).encode()))
    assert len(read_log(tmp_path).records) == 4


def test_ring8_without_its_other_file_says_which_is_missing(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"poses\.txt is not beside it"):
        read(tmp_path, *RING, name="measurement.txt")


def test_ring8_with_its_other_file_cut_loses_only_that_line(tmp_path: Path) -> None:
    (tmp_path / "poses.txt").write_text("\n".join((*POSES, "1300 4")))
    log = read(tmp_path, *RING, name="measurement.txt")
    assert (len(log.records), log.skipped_lines) == (4, 1)


@pytest.mark.parametrize("head", ["# " + DRONE_HEAD, DRONE_HEAD, ""])
def test_nanodrone_row_is_a_pose_and_four_narrow_beams(tmp_path: Path, head: str) -> None:
    rows = ("0.0,1.0,2.0,0.3,0.5,0.5,1.5,4.2,3.9,2.8", "0.1, 1.0,2.0,0.3,0.5,0.5,1.5,4.2,3.9,2.8")
    log = read(tmp_path, *filter(None, (head, *rows)))
    assert (log.format, log.skipped_lines, len(log.records)) == ("nanodrone", 0, 4)
    sonar = sonars(log)[0]
    assert sonar.ranges.tolist() == pytest.approx([0.5, 1.5, np.inf, 3.9])
    assert np.rad2deg(sonar.mounts[:, 2]) == pytest.approx([-90.0, 0.0, 90.0, 180.0])
    assert sonar.cone < math.radians(10.0)
    assert log.odometry[0].pose == (1.0, 2.0, 0.5)


def test_nanodrone_may_do_without_the_beam_that_looks_up(tmp_path: Path) -> None:
    log = read(tmp_path, "0,1,2,0.3,0.5,0.5,1.5,2,3", "1,1,2,0.3,0.5,0.5,1.5,2,3")
    assert (log.format, len(log.records)) == ("nanodrone", 4)


def test_damaged_rows_are_counted(tmp_path: Path) -> None:
    good = "0,1,2,0.3,0.5,0.5,1.5,2,3,1"
    log = read(tmp_path, good, "0,1,2", good.replace("0.3", "nan"), good.replace("1.5", "1;5"))
    assert (log.skipped_lines, len(log.records)) == (3, 2)


def test_forced_format_reads_no_other(tmp_path: Path) -> None:
    assert read(tmp_path, stop("0 0 0"), log_format="ev3").format == "ev3"
    with pytest.raises(LogError, match="no line of a nanodrone log"):
        read(tmp_path, stop("0 0 0"), log_format="nanodrone")


def test_rows_of_nothing_known_are_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no line of a known format"):
        read(tmp_path, "1 2 3", "4 5 6")


def test_rows_that_are_mostly_damaged_are_refused(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="line 2: 3 values instead of 10"):
        read(tmp_path, "0,1,2,0.3,0.5,0.5,1.5,2,3,1", *["1,2,3"] * 11)
