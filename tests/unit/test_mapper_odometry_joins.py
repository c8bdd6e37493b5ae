from typing import cast

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.logs import HeadingRecord, OdometryRecord, Pose, Record, ScanRecord
from pilotage.mapper.odometry_joins import without_jumps

STEP = 0.1
"""s between two records; the robot drives 0.05 m in it."""


def drive(count: int, start: Pose = (0.0, 0.0, 0.0), first: int = 0) -> list[Record]:
    """Odometry and scans in turns along a curve, beginning at `start`."""
    poses = [np.array(start)]
    for _ in range(count - 1):
        poses.append(se2.compose(poses[-1], np.array([0.05, 0.0, 0.01])))
    return [record((first + i) * STEP, pose) for i, pose in enumerate(poses)]


def record(stamp: float, pose: np.ndarray) -> Record:
    x, y, theta = pose.tolist()
    if round(stamp / STEP) % 2:
        return scan(stamp, (x, y, theta))
    return OdometryRecord(stamp, (x, y, theta))


def scan(stamp: float, pose: Pose | None) -> ScanRecord:
    return ScanRecord(stamp, np.ones(3, np.float32), -1.0, 1.0, 10.0, pose, (0.0, 0.0, 0.0))


def poses_of(records: list[Record]) -> np.ndarray:
    return np.array(
        [
            r.pose if isinstance(r, OdometryRecord) else cast("ScanRecord", r).odom_pose
            for r in records
        ]
    )


def steps_of(records: list[Record]) -> np.ndarray:
    poses = poses_of(records)
    return se2.between(poses[:-1], poses[1:])


def test_odometry_that_goes_on_is_left_as_it_is() -> None:
    records = drive(40)
    assert without_jumps(records) is records


def test_an_empty_log_has_no_jumps() -> None:
    assert without_jumps([]) == []


@pytest.mark.parametrize("start", [(50.0, 0.0, 0.0), (1e6, -1e6, 2.0)])
def test_odometry_counted_anew_goes_on_where_the_old_one_ended(start: Pose) -> None:
    records = drive(20) + drive(20, start, first=20)
    steps = steps_of(without_jumps(records))
    np.testing.assert_allclose(steps[19], 0.0, atol=1e-6)
    others = np.delete(steps, 19, axis=0)
    np.testing.assert_allclose(others, np.tile([0.05, 0.0, 0.01], (38, 1)), atol=1e-6)


def test_one_wrong_pose_moves_nothing() -> None:
    records = drive(40)
    wrong = [*records[:20], OdometryRecord(20 * STEP, (1e6, 3.0, 1.0)), *records[21:]]
    poses = poses_of(without_jumps(wrong))
    assert np.hypot(*np.diff(poses[:, :2], axis=0).T).max() < 0.051
    np.testing.assert_allclose(poses[:20], poses_of(records)[:20])


def test_what_was_driven_in_a_long_gap_is_no_jump() -> None:
    records = drive(20) + drive(20, (50.0, 0.0, 0.0), first=200)
    assert without_jumps(records) is records


def test_key_frames_with_coarse_stamps_are_no_jumps() -> None:
    records: list[Record] = [scan(0.0, (2.0 * i, 0.0, 0.0)) for i in range(20)]
    assert without_jumps(records) is records


def test_scans_in_a_frame_of_their_own_are_no_jumps() -> None:
    records = drive(40)
    apart: list[Record] = [
        scan(r.stamp, (100.0 + r.stamp, 0.0, 0.0)) if isinstance(r, ScanRecord) else r
        for r in records
    ]
    assert without_jumps(apart) is apart


def test_what_says_no_odometry_stays_as_it_is() -> None:
    compass, unplaced = HeadingRecord(1.95, 0.3, 0.1), scan(1.95, None)
    records = [*drive(20), compass, unplaced, *drive(20, (50.0, 0.0, 0.0), first=20)]
    assert without_jumps(records)[20:22] == [compass, unplaced]
