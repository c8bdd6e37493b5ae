"""What a scan saw past."""

import numpy as np
import pytest

from pilotage.mapper.laser_grid_scans import DrawnScan
from pilotage.mapper.sight import SECTORS, seen_past, sight_of


def round_scan(distance: float, beams: int = 360, view: float = 2.0 * np.pi) -> DrawnScan:
    """A scan from the middle of a round room."""
    angles = np.linspace(-view / 2.0, view / 2.0, beams, endpoint=False)
    ends = distance * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return DrawnScan(0.0, np.zeros(2), ends, np.ones(beams, np.bool_))


def test_a_scan_sees_as_far_as_its_beams_go() -> None:
    np.testing.assert_allclose(sight_of(round_scan(4.0)), np.full(SECTORS, 4.0))


def test_nothing_is_seen_where_no_beam_goes() -> None:
    far = sight_of(round_scan(4.0, 180, np.pi))
    behind = far[SECTORS // 2 - 20 : SECTORS // 2 + 20]
    assert not behind.any()


def test_a_point_before_the_wall_was_seen_past_and_one_behind_it_was_not() -> None:
    points = np.array([[2.0, 0.0], [3.9, 0.0], [5.0, 0.0]])
    assert seen_past(points, [round_scan(4.0)], 0.3).tolist() == [True, False, False]


def test_one_near_beam_hides_what_lies_beside_it() -> None:
    scan = round_scan(4.0)
    scan.ends[180] = [1.0, 0.0]
    assert not seen_past(np.array([[2.0, 0.0]]), [scan], 0.3).any()


def test_beams_without_a_return_say_nothing() -> None:
    scan = round_scan(4.0)
    silent = DrawnScan(0.0, scan.laser, scan.ends, np.zeros(len(scan.ends), np.bool_))
    assert not seen_past(np.array([[2.0, 0.0]]), [silent], 0.3).any()


@pytest.mark.parametrize("turn", [0.3, 1.6, -2.9])
def test_a_turned_world_looks_the_same(turn: float) -> None:
    rng = np.random.default_rng(1)
    scan = round_scan(4.0, 720)
    points = rng.uniform(-6.0, 6.0, (200, 2))
    inner = np.abs(np.hypot(points[:, 0], points[:, 1]) - 3.7) > 0.05
    pose = np.array([0.0, 0.0, turn])
    cos, sin = np.cos(turn), np.sin(turn)
    turned = points @ np.array([[cos, sin], [-sin, cos]])
    before = seen_past(points[inner], [scan], 0.3)
    assert (seen_past(turned[inner], [scan.moved(pose)], 0.3) == before).all()


def test_any_of_several_scans_may_see_past() -> None:
    near, far = round_scan(1.0), round_scan(4.0)
    assert seen_past(np.array([[2.0, 0.0]]), [near, far], 0.3).all()
    assert not seen_past(np.array([[2.0, 0.0]]), [], 0.3).any()
