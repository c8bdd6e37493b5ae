import math
from pathlib import Path

import numpy as np
import pytest

from pilotage.core import se2
from slam_metrics import (
    Relations,
    Trajectory,
    alignment,
    distances_to_reference,
    poses_at,
    read_reference,
    read_relations,
    read_tum,
    relation_errors,
    relations_of,
)

CIRCLE = np.linspace(0.0, 2.0 * math.pi, 41)


def circle() -> Trajectory:
    poses = np.column_stack([np.cos(CIRCLE), np.sin(CIRCLE), CIRCLE + math.pi / 2.0])
    poses[:, 2] = np.arctan2(np.sin(poses[:, 2]), np.cos(poses[:, 2]))
    return 10.0 * CIRCLE, poses


def moved(trajectory: Trajectory, by: tuple[float, float, float]) -> Trajectory:
    stamps, poses = trajectory
    return stamps, se2.compose(by, poses)


def test_a_trajectory_fits_its_own_relations() -> None:
    errors = relation_errors(circle(), relations_of(circle(), 5))
    assert len(errors.translation) == 36
    assert errors.translation.max() == pytest.approx(0.0, abs=1e-12)
    assert errors.rotation.max() == pytest.approx(0.0, abs=1e-12)


def test_relations_do_not_care_where_the_map_lies() -> None:
    errors = relation_errors(moved(circle(), (30.0, -4.0, 2.0)), relations_of(circle(), 5))
    assert errors.translation.max() == pytest.approx(0.0, abs=1e-9)


def test_a_relation_that_is_off_is_told_in_metres_and_radians() -> None:
    stamps = np.array([0.0, 1.0])
    trajectory = stamps, np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    relation = Relations(stamps[:1], stamps[1:], np.array([[1.0, 0.3, 0.1]]))
    errors = relation_errors(trajectory, relation)
    assert errors.translation == pytest.approx([0.3])
    assert errors.rotation == pytest.approx([0.1])


def test_relations_outside_the_trajectory_are_missing_not_right() -> None:
    trajectory = np.array([0.0, 1.0, 9.0]), np.zeros((3, 3))
    first, second = np.array([-1.0, 0.0, 0.0, 0.5]), np.array([1.0, 5.0, 9.0, 1.0])
    errors = relation_errors(trajectory, Relations(first, second, np.zeros((4, 3))))
    assert len(errors.translation) == 2
    assert errors.missing == 2


def test_poses_between_two_are_interpolated_the_short_way_round() -> None:
    trajectory = np.array([0.0, 1.0]), np.array([[0.0, 0.0, 3.0], [1.0, 2.0, -3.0]])
    (pose,) = poses_at(trajectory, np.array([0.5]))
    assert pose[:2] == pytest.approx([0.5, 1.0])
    assert abs(pose[2]) == pytest.approx(math.pi)


def test_alignment_undoes_a_rigid_motion() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 3.0]])
    motion = (2.0, -1.0, 2.5)
    found = alignment(points, se2.transform_points(motion, points))
    assert found == pytest.approx(motion)


def test_only_the_shape_counts_against_a_reference() -> None:
    assert distances_to_reference(moved(circle(), (5.0, 1.0, -2.0)), circle()).max() < 1e-9
    stamps, poses = circle()
    bent = poses.copy()
    bent[20, 0] += 0.5
    distances = distances_to_reference((stamps, bent), circle())
    assert int(np.argmax(distances)) == 20
    assert distances[20] == pytest.approx(0.5, abs=0.05)


def test_files_are_read_as_they_are_written(tmp_path: Path) -> None:
    half = math.sin(0.25), math.cos(0.25)
    (tmp_path / "t.tum").write_text(f"# stamp\n1.5 2 3 0 0 0 {half[0]} {half[1]}\n")
    stamps, poses = read_tum(tmp_path / "t.tum")
    assert stamps.tolist() == [1.5]
    assert poses[0] == pytest.approx([2.0, 3.0, 0.5])
    (tmp_path / "relations").write_text("1 2 0.5 0.1 0 0 0 -0.2\n")
    assert read_relations(tmp_path / "relations").poses.tolist() == [[0.5, 0.1, -0.2]]
    (tmp_path / "reference").write_text("# text\n1 2 3 0.5\n")
    assert read_reference(tmp_path / "reference")[1].tolist() == [[2.0, 3.0, 0.5]]
