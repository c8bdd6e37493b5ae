import math

import numpy as np
import pytest

from pilotage.core import se2


def test_composition_takes_the_inner_pose_along_the_outer_axes() -> None:
    moved = se2.compose([1.0, 2.0, math.pi / 2.0], [3.0, 1.0, 0.5])
    assert moved == pytest.approx([0.0, 5.0, math.pi / 2.0 + 0.5])


def test_headings_are_wrapped() -> None:
    assert se2.compose([0, 0, 3.0], [0, 0, 3.0])[2] == pytest.approx(6.0 - 2.0 * math.pi)
    assert se2.inverse([0, 0, -math.pi])[2] == -math.pi


def test_one_pose_is_composed_with_many() -> None:
    inner = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.1]])
    assert se2.compose([1.0, 1.0, 0.0], inner) == pytest.approx(
        np.array([[2.0, 1.0, 0.0], [1.0, 2.0, 0.1]])
    )


def test_between_is_what_the_robot_drove_seen_from_its_start() -> None:
    assert se2.between([1.0, 1.0, math.pi / 2.0], [1.0, 3.0, math.pi]) == pytest.approx(
        [2.0, 0.0, math.pi / 2.0]
    )


def test_points_are_turned_and_then_moved() -> None:
    points = se2.transform_points([1.0, 0.0, math.pi / 2.0], [[1.0, 0.0], [0.0, 2.0]])
    assert points == pytest.approx(np.array([[1.0, 1.0], [-1.0, 0.0]]))


def test_interpolation_turns_the_short_way_round() -> None:
    middle = se2.interpolate([0.0, 0.0, 3.0], [2.0, 4.0, -3.0], 0.5)
    assert middle[:2] == pytest.approx([1.0, 2.0])
    assert abs(middle[2]) == pytest.approx(math.pi)


def test_inputs_are_left_alone() -> None:
    pose = np.array([1.0, 2.0, 3.0])
    se2.interpolate(pose, pose + 1.0, 0.3)
    se2.compose(pose, pose)
    assert pose.tolist() == [1.0, 2.0, 3.0]
