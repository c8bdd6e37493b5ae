"""What stops beams and bodies."""

import numpy as np
import pytest

from drawing import draw
from pilotage.robot.simulator.walls import Walls
from robot_world import ROOM

WALLS = Walls.of(ROOM)


def test_distance_to_the_nearest_wall_is_exact() -> None:
    distance, direction = WALLS.nearest(1.1, 1.75, 2.0)
    assert distance == pytest.approx(0.6)
    assert abs(direction) == pytest.approx(np.pi)


def test_distance_to_a_corner_is_diagonal() -> None:
    world = draw("""
        ...
        ...
        #..
    """)
    distance, direction = Walls.of(world).nearest(1.3, 1.4, 2.0)
    assert distance == pytest.approx(0.5)
    assert direction == pytest.approx(np.arctan2(-0.4, -0.3))


def test_nothing_near_is_infinitely_far() -> None:
    assert WALLS.nearest(3.0, 1.75, 0.5)[0] == np.inf


def test_a_point_outside_of_the_map_touches_what_is_there() -> None:
    assert WALLS.nearest(-1.0, 1.0, 0.5)[0] == 0.0
    assert WALLS.overlaps(-1.0, 1.0, 0.1)


@pytest.mark.parametrize(("x", "is_in_wall"), [(0.701, False), (0.699, True), (0.3, True)])
def test_a_disc_overlaps_where_its_rim_crosses_a_wall(x: float, is_in_wall: bool) -> None:  # noqa: FBT001 - a parameter
    assert WALLS.overlaps(x, 1.75, 0.2) == is_in_wall


def test_nobody_stands_on_unknown_ground_but_beams_pass() -> None:
    walls = Walls.of(draw(".?.#"))
    assert walls.overlaps(1.5, 0.5, 0.1)
    assert walls.ranges((0.5, 0.5, 0.0), [0.0], 10.0) == pytest.approx([2.5])


def test_furniture_that_the_map_lacks_stops_beams_and_bodies() -> None:
    walls = Walls.of(ROOM, ((3.0, 1.5, 3.5, 2.0),))
    assert walls.overlaps(3.2, 1.7, 0.1)
    assert walls.ranges((1.0, 1.75, 0.0), [0.0], 10.0) == pytest.approx([2.0])
    assert WALLS.ranges((1.0, 1.75, 0.0), [0.0], 10.0) == pytest.approx([4.5])


def test_furniture_beyond_the_map_is_cut_off() -> None:
    walls = Walls.of(ROOM, ((-3.0, -1.5, 0.2, 9.0),))
    assert walls.stops_beams.sum() == ROOM.is_wall.sum()


def test_beams_turn_with_the_pose_and_with_the_map() -> None:
    turned = draw("...#", origin=(10.0, 20.0, np.pi / 2.0))
    walls = Walls.of(turned)
    assert walls.ranges((9.5, 20.5, 0.0), [np.pi / 2.0], 10.0) == pytest.approx([2.5])
    distance, direction = walls.nearest(9.5, 22.5, 1.0)
    assert (distance, direction) == pytest.approx((0.5, np.pi / 2.0))


def test_places_keep_their_distance() -> None:
    places = WALLS.places(0.4)
    assert len(places) > 0
    assert all(not WALLS.overlaps(x, y, 0.4) for x, y in places)


def test_of_two_rooms_without_a_door_the_larger_is_the_place() -> None:
    world = draw("""
        ##########
        #..#.....#
        #..#.....#
        #..#.....#
        ##########
    """)
    places = Walls.of(world).places(0.2)
    assert (places[:, 0] > 4.0).all()
    assert len(places) > 0


def test_a_door_joins_two_rooms() -> None:
    world = draw(
        """
        ##########
        #...#....#
        #...#....#
        #........#
        #...#....#
        #...#....#
        ##########
        """,
        resolution=0.5,
    )
    places = Walls.of(world).places(0.1)
    assert places[:, 0].min() < 2.0
    assert places[:, 0].max() > 3.0


def test_a_full_map_has_no_places() -> None:
    assert len(Walls.of(draw("####")).places(0.1)) == 0
