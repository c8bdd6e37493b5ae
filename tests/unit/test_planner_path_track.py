import numpy as np
import pytest

from pilotage.planner.path_braking import free_way, safe_speed
from pilotage.planner.path_track import Track, distances_to_line

BEND = Track(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]]))


def test_a_track_is_as_long_as_its_pieces() -> None:
    assert BEND.length == pytest.approx(3.0)
    assert BEND.at([-1.0, 0.5, 2.5, 9.0]) == pytest.approx(
        np.array([[0.0, 0.0], [0.5, 0.0], [2.0, 0.5], [2.0, 1.0]])
    )


def test_the_nearest_point_of_a_track_may_lie_within_a_piece() -> None:
    assert BEND.nearest((1.2, 0.3), 0.0, 9.0) == pytest.approx((1.2, 0.3))
    assert BEND.nearest((2.4, 0.7), 0.0, 9.0) == pytest.approx((2.7, 0.4))
    assert BEND.nearest((3.0, 2.0), 0.0, 9.0) == pytest.approx((3.0, np.sqrt(2.0)))


def test_only_the_part_asked_for_is_looked_at() -> None:
    assert BEND.nearest((2.0, 0.9), -1.0, 1.5)[0] == pytest.approx(1.5)
    hairpin = Track(np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 0.1], [0.0, 0.1]]))
    assert hairpin.nearest((1.0, 0.1), 0.0, 2.0)[0] == pytest.approx(1.0)
    assert hairpin.nearest((1.0, 0.0), 8.0, 10.0)[0] == pytest.approx(9.1)


def test_a_track_may_end_where_it_begins() -> None:
    assert Track(np.ones((2, 2))).nearest((1.0, 3.0), -1.0, 1.0) == pytest.approx((0.0, 2.0))


def test_distances_are_to_the_line_between_two_points_and_not_beyond() -> None:
    points = np.array([[1.0, 1.0], [3.0, 0.0], [-1.0, 0.0]])
    assert distances_to_line(points, (0.0, 0.0), (2.0, 0.0)) == pytest.approx([1.0, 1.0, 1.0])


def test_the_way_is_free_until_the_body_meets_a_point() -> None:
    ahead = np.array([[1.0, 0.0]])
    assert free_way(ahead, 0.0, 0.2, 2.0) == pytest.approx(0.78, abs=0.035)
    assert free_way(ahead, 0.0, 0.2, 0.5) == 0.5
    assert free_way(np.zeros((0, 2)), 0.0, 0.2, 2.0) == 2.0


def test_a_point_beside_the_way_is_passed() -> None:
    assert free_way(np.array([[1.0, 0.25], [-0.25, 0.0]]), 0.0, 0.2, 2.0) == 2.0


def test_an_arc_meets_what_stands_in_its_bend() -> None:
    left = np.array([[1.0, 1.0]])
    assert free_way(left, 0.0, 0.2, 2.0) == 2.0
    assert free_way(left, 1.0, 0.2, 2.0) == pytest.approx(np.pi / 2.0 - 0.2, abs=0.04)
    assert free_way(left, -1.0, 0.2, 2.0) == 2.0


def test_a_body_that_stands_against_something_may_go_away_from_it_only() -> None:
    behind, ahead = np.array([[-0.15, 0.0]]), np.array([[0.15, 0.0]])
    assert free_way(behind, 0.0, 0.2, 1.0) == 1.0
    assert free_way(ahead, 0.0, 0.2, 1.0) <= 0.0


@pytest.mark.parametrize("free", [0.0, 0.1, 0.5, 3.0])
def test_at_the_safe_speed_the_robot_stops_just_in_time(free: float) -> None:
    speed = safe_speed(free, braking=0.6, delay=0.25)
    assert speed * 0.25 + speed**2 / (2.0 * 0.6) == pytest.approx(free)
    assert safe_speed(-0.1, 0.6, 0.25) == 0.0
