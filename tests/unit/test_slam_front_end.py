"""Scan after scan, until a keyframe is due."""

from dataclasses import replace

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.mapper.front_end import FrontEnd, FrontEndParams, NewKeyframe
from pilotage.mapper.laser_grid_scans import DrawnScan
from pilotage.mapper.scan_tracker import TrackerParams, local_map
from slam_world import building, drawn_at

PARAMS = FrontEndParams()
START = np.array([1.5, 7.2, 0.1])
STAND = np.zeros(3)


def scan(pose: np.ndarray, stamp: float = 0.0) -> DrawnScan:
    return drawn_at(building(), pose, stamp)


def begun(params: FrontEndParams = PARAMS) -> FrontEnd:
    """A front end that has its first keyframe, at START."""
    front = FrontEnd(params)
    first = front.take(STAND, scan(START))
    assert first is not None
    front.begin_on(local_map(first.keyframe.points, TrackerParams()))
    return front


def driven(front: FrontEnd, step: tuple[float, float, float], most: int = 50) -> NewKeyframe:
    """Step on until a keyframe is due."""
    pose = START
    for k in range(1, most):
        pose = se2.compose(pose, step)
        new = front.take(np.array(step), scan(pose, float(k)))
        if new is not None:
            return new
    raise AssertionError("no keyframe")


def test_the_first_scan_is_a_keyframe() -> None:
    new = FrontEnd(PARAMS).take(np.array([5.0, 5.0, 1.0]), scan(START, 7.0))
    assert new is not None
    assert not new.relative.any()
    assert new.keyframe.stamp == 7.0
    assert len(new.keyframe.scans) == 1


def test_a_keyframe_is_due_after_some_way() -> None:
    new = driven(begun(), (0.07, 0.0, 0.0))
    assert new.keyframe.stamp == 5.0
    assert new.relative == pytest.approx([0.35, 0.0, 0.0], abs=0.01)


def test_a_keyframe_is_due_after_some_turn() -> None:
    new = driven(begun(), (0.0, 0.0, -0.1))
    assert new.keyframe.stamp == 3.0
    assert new.relative == pytest.approx([0.0, 0.0, -0.3], abs=0.01)


def test_who_stands_needs_no_keyframe() -> None:
    front = begun()
    assert all(front.take(STAND, scan(START, float(k))) is None for k in range(20))
    assert np.abs(front.tracked.pose).max() < 1e-3


def test_scans_between_are_kept_but_not_all() -> None:
    new = driven(begun(), (0.02, 0.0, 0.0))
    stamps = [kept.stamp or 0.0 for kept in new.keyframe.scans]
    assert 2 <= len(stamps) <= PARAMS.kept
    assert stamps == sorted(stamps)
    assert stamps[-1] == new.keyframe.stamp


def test_kept_scans_are_told_in_the_frame_of_the_keyframe() -> None:
    """The laser was behind where it is now, and saw the same walls."""
    new = driven(begun(), (0.07, 0.0, 0.0))
    lasers = np.array([kept.laser for kept in new.keyframe.scans])
    assert lasers[0] == pytest.approx([-0.28, 0.0], abs=0.01)
    assert lasers[-1] == pytest.approx([0.0, 0.0], abs=1e-9)
    here = se2.compose(START, (0.35, 0.0, 0.0))
    for kept in new.keyframe.scans:
        places = se2.transform_points(here, kept.ends)
        on_lines = np.abs(places / 0.6 - np.round(places / 0.6)).min(axis=1) * 0.6
        assert on_lines.max() < 0.02  # all walls lie on lines of the plan


def test_a_keyframe_starts_what_is_kept_anew() -> None:
    front = begun()
    new = driven(front, (0.07, 0.0, 0.0))
    front.begin_on(local_map(new.keyframe.points, TrackerParams()))
    assert not front.tracked.pose.any()
    nothing_between = replace(PARAMS, way=0.0)
    assert len(driven(begun(nothing_between), (0.1, 0.0, 0.0)).keyframe.scans) == 1


def test_points_are_thinned_and_near() -> None:
    points = driven(begun(), (0.07, 0.0, 0.0)).keyframe.points
    apart = np.linalg.norm(points[:, None] - points[None], axis=2) + np.eye(len(points))
    assert np.sort(apart.min(axis=1))[len(points) // 4] > 0.02
    short = driven(begun(replace(PARAMS, sight=1.5)), (0.07, 0.0, 0.0)).keyframe.points
    assert np.hypot(*short.T).max() < 1.5
    assert len(short) < len(points)


def test_a_keyframe_is_never_known_too_well() -> None:
    new = driven(begun(replace(PARAMS, error=(0.1, 0.05))), (0.07, 0.0, 0.0))
    assert (np.diag(new.covariance) >= [0.01, 0.01, 0.0025]).all()
    assert new.covariance == pytest.approx(new.covariance.T)


def test_a_scan_of_nothing_moves_the_pose_but_is_no_keyframe() -> None:
    front = begun()
    dark = DrawnScan(1.0, np.zeros(2), np.empty((0, 2)), np.empty(0, bool))
    for _ in range(20):
        assert front.take(np.array([0.1, 0.0, 0.0]), dark) is None
    assert front.tracked.pose == pytest.approx([2.0, 0.0, 0.0])
    assert not front.tracked.is_matched
    new = front.take(STAND, scan(se2.compose(START, (2.0, 0.0, 0.0)), 2.0))
    assert new is not None
    assert new.relative == pytest.approx([2.0, 0.0, 0.0], abs=0.03)


def test_beams_without_a_return_are_not_matched() -> None:
    seen = scan(START)
    silent = DrawnScan(0.0, seen.laser, seen.ends, np.zeros(len(seen.ends), bool))
    assert FrontEnd(PARAMS).take(STAND, silent) is None
