"""What one scan shows: corners, doors and passages."""

import numpy as np
import pytest

from feature_scenes import door
from pilotage.core import se2
from pilotage.topology.features import KINDS, Features
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.seeing.seen_features import seen_features, without_same_place
from pilotage.topology.seeing.seen_features_mouths import MouthParams, seen_mouths
from topology_world import BEARINGS, floor, look

ROOM = """
    ########################
    #......................#
    #......................#
    #......................#
    #......................#
    #......................#
    #......................#
    #......................#
    #......................#
    ########################
    """

HALL = """
    ########################################
    ###################....................#
    ###################....................#
    ###################....................#
    ###################....................#
    ###################....................#
    ###################....................#
    #......................................#
    #......................................#
    #......................................#
    #......................................#
    #......................................#
    #......................................#
    ###################....................#
    ###################....................#
    ###################....................#
    ###################....................#
    ###################....................#
    ########################################
    """
"""A corridor of 1.5 m that ends in a hall."""

CROSSING = """
    ########################################
    #........#............#................#
    #........#............#................#
    #........#............#................#
    #........#............#................#
    #........#............#................#
    #####........####........#####....######
    #......................................#
    #......................................#
    #......................................#
    #......................................#
    #......................................#
    #......................................#
    #......................................#
    #......................................#
    #####........####........#####....######
    #........#............#................#
    #........#............#................#
    #........#............#................#
    #........#............#................#
    #........#............#................#
    ########################################
    """
"""A corridor of 2 m; walls of the rooms at both sides of it are in line with each other."""


def seen_in(picture: str, pose: tuple[float, float, float]) -> Features:
    """Return what is seen from a pose, in map."""
    view = look(floor(picture), np.array(pose), np.random.default_rng(0))
    return seen_features(view).moved(pose)


def of_kind(features: Features, kind: str) -> Features:
    return features.chosen(features.kinds == [str(k) for k in KINDS].index(kind))


def test_the_corners_of_a_room_open_into_it() -> None:
    corners = of_kind(seen_in(ROOM, (1.5, 1.3, 0.0)), "corner")
    order = np.argsort(corners.poses[:, 1])
    np.testing.assert_allclose(
        corners.poses[order],
        [(5.75, 0.25, 0.75 * np.pi), (5.75, 2.25, -0.75 * np.pi)],
        atol=0.03,
    )


def test_corners_have_no_width() -> None:
    assert np.isnan(of_kind(seen_in(ROOM, (1.5, 1.3, 0.0)), "corner").widths).all()


def test_an_empty_room_has_neither_doors_nor_passages() -> None:
    assert (seen_in(ROOM, (1.5, 1.3, 0.0)).kinds == 0).all()


def test_a_scan_without_returns_shows_nothing() -> None:
    view = ScanView.of(np.full(361, np.inf), (-np.pi / 2.0, np.pi / 360.0))
    assert len(seen_features(view)) == 0


@pytest.mark.parametrize(("x", "middle"), [(3.0, (4.25, 2.25)), (4.8, (5.75, 4.25))])
def test_a_robot_in_a_corridor_sees_the_next_door(x: float, middle: tuple[float, float]) -> None:
    view = look(floor(), np.array([x, 3.3, 0.0]), np.random.default_rng(0))
    doors = of_kind(seen_features(view).moved([x, 3.3, 0.0]), "door")
    assert np.hypot(*(doors.poses[:, :2] - middle).T).min() < 0.15


def test_where_the_laser_sits_does_not_matter() -> None:
    world, mount = floor(), np.array([0.3, -0.1, 0.4])
    base = np.array([3.0, 3.3, 0.1])
    laser = look(world, se2.compose(base, mount), np.random.default_rng(0))
    mounted = ScanView(laser.ranges, laser.angles, mount, laser.lines)
    corners = of_kind(seen_features(mounted).moved(base), "corner")
    assert len(corners)
    right = np.array([(13.75, 4.25), (13.75, 2.25), (3.5, 7.0), (6.75, 4.25), (6.25, 0.25)])
    for place in corners.poses[:, :2]:
        off = np.hypot(*(right - place).T)
        assert off.min() < 0.1 or np.abs(place[1] - 3.3) > 0.9


def test_a_corridor_that_ends_in_a_hall_has_a_mouth() -> None:
    passages = of_kind(seen_in(HALL, (2.5, 2.1, 0.0)), "passage")
    assert len(passages) == 1
    np.testing.assert_allclose(passages.poses[0, :2], (4.75, 2.125), atol=0.15)
    assert passages.widths[0] == pytest.approx(1.5, abs=0.1)
    assert abs(np.cos(passages.poses[0, 2])) > 0.99


def test_a_corridor_that_goes_on_has_no_mouth() -> None:
    view = look(floor(), np.array([3.0, 3.3, 0.0]), np.random.default_rng(0))
    assert len(seen_mouths(view, MouthParams())) == 0


def test_a_mouth_wider_than_a_corridor_is_none() -> None:
    view = look(floor(HALL), np.array([2.5, 2.1, 0.0]), np.random.default_rng(0))
    assert len(seen_mouths(view, MouthParams(widths=(0.7, 1.2)))) == 0


@pytest.mark.parametrize("x", np.arange(0.6, 6.0, 0.6).tolist())
def test_walls_of_rooms_in_line_across_a_corridor_are_no_passage(x: float) -> None:
    passages = of_kind(seen_in(CROSSING, (x, 2.75, 0.0)), "passage")
    # Those left may lead into the rooms, not along the corridor.
    is_along = np.abs(np.cos(passages.poses[:, 2])) > 0.9
    assert not (is_along & (np.abs(passages.poses[:, 1] - 2.75) < 0.5)).any()


def test_what_was_seen_already_is_not_seen_twice() -> None:
    doors = Features.joined([door(2.0, 1.0), door(5.0, 1.0)])
    kept = without_same_place(doors, door(2.2, 1.0))
    np.testing.assert_allclose(kept.poses[:, 0], [5.0])


def test_covariances_are_those_of_places() -> None:
    features = seen_in(ROOM, (1.5, 1.3, 0.0))
    assert (np.linalg.eigvalsh(features.covariances) > 0.0).all()
    assert (np.sqrt(features.covariances.trace(axis1=1, axis2=2)) < 0.3).all()


def test_the_beams_of_the_world_span_half_a_circle() -> None:
    assert np.ptp(BEARINGS) == pytest.approx(np.pi)
