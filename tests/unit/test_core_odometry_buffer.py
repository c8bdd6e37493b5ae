import math

import numpy as np
import pytest

from pilotage.core.odometry_buffer import OdometryBuffer

MS = 1_000_000


def filled(*samples: tuple[int, tuple[float, float, float]]) -> OdometryBuffer:
    buffer = OdometryBuffer()
    for stamp_ms, pose in samples:
        assert buffer.append(stamp_ms * MS, pose)
    return buffer


STRAIGHT = filled((100, (0.0, 0.0, 0.0)), (200, (1.0, 0.0, 0.0)), (300, (1.0, 2.0, 0.0)))


def test_pose_between_two_samples_is_interpolated() -> None:
    assert STRAIGHT.pose_at(150 * MS) == pytest.approx([0.5, 0.0, 0.0])
    assert STRAIGHT.pose_at(275 * MS) == pytest.approx([1.0, 1.5, 0.0])


def test_pose_at_a_sample_is_the_sample() -> None:
    for stamp_ms, pose in ((100, [0.0, 0.0, 0.0]), (200, [1.0, 0.0, 0.0]), (300, [1.0, 2.0, 0.0])):
        assert STRAIGHT.pose_at(stamp_ms * MS) == pytest.approx(pose)


def test_heading_is_interpolated_the_short_way_round() -> None:
    buffer = filled((0, (0.0, 0.0, 3.1)), (10, (0.0, 0.0, -3.1)))
    pose = buffer.pose_at(5 * MS)
    assert pose is not None
    assert abs(pose[2]) == pytest.approx(math.pi)


def test_outside_the_buffer_nothing_is_known() -> None:
    assert STRAIGHT.pose_at(99 * MS) is None
    assert STRAIGHT.pose_at(301 * MS) is None
    assert OdometryBuffer().pose_at(0) is None


def test_last_motion_goes_on_for_a_limited_time() -> None:
    assert STRAIGHT.pose_at(350 * MS, extrapolation_ns=50 * MS) == pytest.approx([1.0, 3.0, 0.0])
    assert STRAIGHT.pose_at(351 * MS, extrapolation_ns=50 * MS) is None
    assert STRAIGHT.pose_at(99 * MS, extrapolation_ns=50 * MS) is None


def test_a_single_sample_is_held_for_the_limited_time() -> None:
    buffer = filled((100, (1.0, 2.0, 0.5)))
    assert buffer.pose_at(110 * MS, extrapolation_ns=20 * MS) == pytest.approx([1.0, 2.0, 0.5])


def test_sample_that_is_not_newer_is_refused() -> None:
    buffer = filled((100, (0.0, 0.0, 0.0)))
    assert not buffer.append(100 * MS, (9.0, 9.0, 9.0))
    assert not buffer.append(99 * MS, (9.0, 9.0, 9.0))
    assert buffer.pose_at(100 * MS) == pytest.approx([0.0, 0.0, 0.0])


def test_oldest_samples_make_room() -> None:
    buffer = OdometryBuffer(capacity=2)
    for stamp in (1, 2, 3):
        buffer.append(stamp, (float(stamp), 0.0, 0.0))
    assert len(buffer) == 2
    assert buffer.pose_at(1) is None
    assert buffer.pose_at(2) == pytest.approx([2.0, 0.0, 0.0])


def test_cleared_buffer_accepts_an_odometry_that_starts_anew() -> None:
    buffer = filled((100, (5.0, 5.0, 0.0)))
    buffer.clear()
    assert buffer.append(1, (0.0, 0.0, 0.0))


def test_returned_and_given_poses_are_copies() -> None:
    buffer = OdometryBuffer()
    given = np.zeros(3)
    buffer.append(1, given)
    given[0] = 9.0
    returned = buffer.pose_at(1)
    assert returned is not None
    returned[1] = 9.0
    assert buffer.pose_at(1) == pytest.approx([0.0, 0.0, 0.0])
