"""ROS bags of both generations, written by the library that reads them."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pilotage.core.logs import LogError, read_log
from rosbag_files import UPSIDE_DOWN, BagMaker

HALF_TURN = (0.0, 0.0, 1.0, 0.0)
MOUNTED = ("base_link", "laser")


def drive(maker: BagMaker, *, child: str = "base_link") -> list[tuple[str, float, Any]]:
    """A laser 0.2 m ahead of a robot that drives for a second."""
    return [
        ("/tf_static", 99.0, maker.transform(99.0, MOUNTED, (0.2, 0.0))),
        ("/odom", 100.0, maker.odometry(100.0, 0.0, child)),
        ("/scan", 100.5, maker.scan(100.5, [1.0, 2.0, 3.0])),
        ("/odom", 101.0, maker.odometry(101.0, 0.5, child)),
    ]


@pytest.fixture(params=["ROS 1", "ROS 2", "ROS 2 MCAP"])
def bag(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    maker = BagMaker(ros1=request.param == "ROS 1")
    name = "run.bag" if maker.ros1 else "run"
    return maker.write(tmp_path / name, drive(maker), mcap=request.param.endswith("MCAP"))


def test_bag_holds_odometry_scans_and_the_mount_of_the_laser(bag: Path) -> None:
    log = read_log(bag)
    assert (log.format, log.skipped_lines) == ("rosbag", 0)
    assert [(r.stamp, r.pose, r.linear) for r in log.odometry] == [
        (100.0, (0.0, 0.0, 0.0), 0.5),
        (101.0, (0.5, 0.0, 0.0), 0.5),
    ]
    (scan,) = log.scans
    assert scan.stamp == 100.5
    assert scan.ranges.tolist() == [1.0, 2.0, 3.0]
    assert (scan.angle_min, scan.angle_increment) == (-0.5, 0.5)
    assert scan.laser_mount == pytest.approx((0.2, 0.0, 0.0))


def test_single_files_of_a_ros_2_bag_are_read_too(tmp_path: Path) -> None:
    maker = BagMaker()
    for mcap, ending in ((False, ".db3"), (True, ".mcap")):
        folder = maker.write(tmp_path / f"run{ending[1:]}", drive(maker), mcap=mcap)
        (file,) = folder.glob(f"*{ending}")
        assert len(read_log(file).records) == 3
        assert len(read_log(file, "rosbag").records) == 3


def test_ranges_outside_the_limits_of_the_laser_are_no_return(tmp_path: Path) -> None:
    maker = BagMaker()
    ranges = [0.05, math.nan, 10.0, math.inf, -1.0, 9.0]
    messages = [("/scan", 1.0, maker.scan(1.0, ranges)), ("/odom", 1.0, maker.odometry(1.0, 0.0))]
    (scan,) = read_log(maker.write(tmp_path / "b", messages)).scans
    assert scan.ranges.tolist() == [np.inf] * 5 + [9.0]


def test_laser_that_hangs_upside_down_is_turned_over(tmp_path: Path) -> None:
    maker = BagMaker()
    messages = [
        ("/tf_static", 0.5, maker.transform(0.5, MOUNTED, (0.2, 0.1), UPSIDE_DOWN)),
        ("/scan", 1.0, maker.scan(1.0, [1.0, 2.0, 3.0], low=-0.25)),
    ]
    (scan,) = read_log(maker.write(tmp_path / "b", messages)).scans
    assert scan.ranges.tolist() == [3.0, 2.0, 1.0]
    assert (scan.angle_min, scan.angle_increment) == (-0.75, 0.5)
    assert scan.laser_mount == pytest.approx((0.2, 0.1, 0.0))


def test_laser_that_counts_clockwise_is_turned_round(tmp_path: Path) -> None:
    maker = BagMaker()
    messages = [("/scan", 1.0, maker.scan(1.0, [1.0, 2.0, 3.0], step=-0.5, low=0.5))]
    (scan,) = read_log(maker.write(tmp_path / "b", messages)).scans
    assert scan.ranges.tolist() == [3.0, 2.0, 1.0]
    assert (scan.angle_min, scan.angle_increment) == (-0.5, 0.5)


def test_mount_is_followed_over_several_frames(tmp_path: Path) -> None:
    maker = BagMaker()
    messages = [
        ("/tf", 0.5, maker.transform(0.5, ("mast", "laser"), (0.1, 0.0), HALF_TURN)),
        ("/tf", 0.5, maker.transform(0.5, ("base_footprint", "mast"), (0.3, 0.0), HALF_TURN)),
        *drive(maker, child="base_footprint")[1:],
    ]
    (scan,) = read_log(maker.write(tmp_path / "b", messages)).scans
    assert scan.laser_mount == pytest.approx((0.2, 0.0, 0.0))


def test_odometry_may_be_a_transform_only(tmp_path: Path) -> None:
    maker = BagMaker()
    messages = [
        ("/tf", 1.0 + k, maker.transform(1.0 + k, ("odom", "base_link"), (0.5 * k, 0.0)))
        for k in range(3)
    ]
    log = read_log(maker.write(tmp_path / "b", messages))
    assert [(r.stamp, r.pose[0]) for r in log.odometry] == [(1.0, 0.0), (2.0, 0.5), (3.0, 1.0)]


def test_laser_with_most_scans_is_taken(tmp_path: Path) -> None:
    maker = BagMaker()
    messages = [("/rear", 1.0, maker.scan(1.0, [5.0, 5.0]))]
    messages += [("/front", 1.0 + k, maker.scan(1.0 + k, [2.0, 2.0])) for k in range(2)]
    log = read_log(maker.write(tmp_path / "b", messages))
    assert [scan.ranges.tolist() for scan in log.scans] == [[2.0, 2.0]] * 2


def test_bag_without_scans_or_odometry_is_refused(tmp_path: Path) -> None:
    maker = BagMaker()
    messages = [("/tf", 1.0, maker.transform(1.0, ("map", "odom"), (0.0, 0.0)))]
    with pytest.raises(LogError, match="neither scans nor odometry"):
        read_log(maker.write(tmp_path / "b", messages))


def test_recordings_of_our_own_are_told_to_be_unread(tmp_path: Path) -> None:
    maker = BagMaker()
    messages = [("/tf", 1.0, maker.transform(1.0, ("map", "odom"), (0.0, 0.0)))]
    (file,) = maker.write(tmp_path / "b", messages, mcap=True).glob("*.mcap")
    with pytest.raises(LogError, match="recordings of Pilotage itself are not read yet"):
        read_log(file)


@pytest.mark.parametrize("keep", [9, 20, 200, 2000, -20])
def test_cut_bag_is_refused(bag: Path, keep: int) -> None:
    file = bag if bag.is_file() else next(f for f in bag.iterdir() if f.suffix != ".yaml")
    file.write_bytes(file.read_bytes()[:keep])
    with pytest.raises(LogError) as refusal:
        read_log(bag)
    assert "\n" not in str(refusal.value)
    assert str(bag) in str(refusal.value)


@pytest.mark.parametrize("text", ["", "- 1", "rosbag2_bagfile_information: {version: 99}", "\x00"])
def test_folder_with_a_damaged_description_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "metadata.yaml").write_text(text)
    with pytest.raises(LogError, match="cannot be read"):
        read_log(tmp_path)


def test_text_is_no_bag(tmp_path: Path) -> None:
    (tmp_path / "run.bag").write_text("ODOM 0 0 0 0 0 0 1 host 1\n")
    assert read_log(tmp_path / "run.bag").format == "carmen"
    with pytest.raises(LogError, match="cannot be read"):
        read_log(tmp_path / "run.bag", "rosbag")
