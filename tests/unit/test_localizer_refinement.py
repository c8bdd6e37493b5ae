"""The pose beyond the cell."""

import math

import numpy as np
import pytest

from drawing import draw
from localizer_world import BEARINGS, CELL, ELSEWHERE, START, error, flat, scan_at
from pilotage.core import se2
from pilotage.localizer.refinement import CAP, matched_share, refine, wall_distance

POSES = [START, ELSEWHERE, (8.0, 5.6, -2.0), (6.0, 2.2, 1.3)]
OFF = [(0.08, -0.06, 0.05), (-0.1, 0.05, -0.06), (0.0, 0.0, 0.0)]


def ends_at(pose: tuple[float, float, float], origin: tuple[float, float, float]) -> np.ndarray:
    ranges = scan_at(flat(origin), pose).astype(float)
    hit = np.isfinite(ranges)
    directions = np.stack([np.cos(BEARINGS), np.sin(BEARINGS)], axis=1)
    return np.asarray(ranges[hit, None] * directions[hit])


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("off", OFF)
@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (3.0, -8.0, 2.2)], ids=["plain", "turned"])
def test_a_pose_some_way_off_is_drawn_to_the_truth(
    pose: tuple[float, float, float],
    off: tuple[float, float, float],
    origin: tuple[float, float, float],
) -> None:
    truth = tuple(float(value) for value in se2.compose(origin, pose))
    ends = ends_at((truth[0], truth[1], truth[2]), origin)
    refined = refine(se2.compose(truth, off), ends, wall_distance(flat(origin)))
    away, turn = error(refined, truth)
    assert away < 0.4 * CELL
    assert turn < 0.01
    assert -math.pi <= refined[2] < math.pi


def test_people_in_the_way_do_not_pull() -> None:
    ends = ends_at(START, (0.0, 0.0, 0.0))
    ends[10:25] *= 0.5
    refined = refine(se2.compose(START, OFF[0]), ends, wall_distance(flat()))
    assert error(refined, START)[0] < CELL


def test_a_long_wall_alone_does_not_let_the_pose_slide_along_it() -> None:
    world = draw("\n".join(["." * 60] * 20 + ["#" * 60]), 0.1)
    bearings = np.linspace(-2.2, -0.9, 30)
    pose = np.array([3.0, 1.1, 0.0])
    ends = np.stack([1.0 / np.tan(-bearings), np.full(30, -1.0)], axis=1)
    refined = refine(pose + np.array([0.0, 0.08, 0.02]), ends, wall_distance(world))
    assert refined[0] == pytest.approx(3.0, abs=0.05)
    assert refined[1] == pytest.approx(1.1, abs=0.06)


def test_ends_beyond_the_map_or_far_from_any_wall_neither_pull_nor_match() -> None:
    walls = wall_distance(flat())
    ends = np.array([[90.0, 0.0], [-50.0, 3.0]])
    distance, gradient = walls.sample(se2.transform_points(START, ends))
    assert distance == pytest.approx([CAP, CAP])
    assert not gradient.any()
    assert refine(np.array(START), ends, walls) == pytest.approx(START)
    assert matched_share(np.array(START), ends, walls) == 0.0


def test_gradient_is_the_slope_of_the_distance_in_the_map_frame() -> None:
    walls = wall_distance(flat((2.0, 1.0, 0.9)))
    points = se2.transform_points((2.0, 1.0, 0.9), [[1.23, 4.87], [6.61, 1.52], [8.37, 5.09]])
    _, gradient = walls.sample(points)
    for axis in (0, 1):
        step = np.eye(2)[axis] * 1e-5
        slope = (walls.sample(points + step)[0] - walls.sample(points - step)[0]) / 2e-5
        assert gradient[:, axis] == pytest.approx(slope, abs=1e-4)


def test_all_beams_match_at_the_truth_and_few_elsewhere() -> None:
    walls = wall_distance(flat())
    ends = ends_at(START, (0.0, 0.0, 0.0))
    assert matched_share(np.array(START), ends, walls) == 1.0
    assert matched_share(np.array(ELSEWHERE), ends, walls) < 0.7
    assert matched_share(np.array(START), np.empty((0, 2)), walls) == 0.0
