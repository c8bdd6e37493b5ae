import numpy as np
import pytest

from pilotage.core.grid import OCCUPIED, GridGeometry, OccupancyMap
from pilotage.core.laser_view import View
from pilotage.planner.ground import Ground
from pilotage.planner.obstacle_view import echo_view
from pilotage.planner.obstacles import Obstacles

HERE = np.array([1.0, 2.0, 0.0])


def hall() -> Ground:
    """6 m x 4 m in cells of 10 cm."""
    cells = np.zeros((40, 60), np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    return Ground.of(OccupancyMap(GridGeometry(40, 60, 0.1), cells))


def view(*points: tuple[float, float]) -> View:
    return View(np.reshape(np.array(points, float), (-1, 2)), np.zeros(1))


def test_what_the_map_lacks_is_remembered_where_it_stands() -> None:
    obstacles = Obstacles(hall(), memory=20.0)
    obstacles.look(HERE, view((2.04, 0.04)), 0.0, 0.2)
    assert obstacles.points == pytest.approx(np.array([[3.05, 2.05]]))
    turned = np.array([3.04, 1.0, np.pi / 2.0])
    obstacles.look(turned, view((1.04, 0.0)), 1.0, 0.2)
    assert len(obstacles.points) == 1


def test_the_walls_of_the_map_are_not_obstacles() -> None:
    obstacles = Obstacles(hall(), memory=20.0)
    obstacles.look(HERE, view((4.92, 0.0), (0.0, -1.75), (9.0, 0.0)), 0.0, 0.2)
    assert len(obstacles.points) == 0
    # What blocks the way is there for certain, be it near a wall.
    obstacles.look(HERE, view((0.0, -1.75)), 0.0, 0.05)
    assert len(obstacles.points) == 1


def test_what_is_not_seen_any_more_is_forgotten_after_a_while() -> None:
    obstacles = Obstacles(hall(), memory=20.0)
    obstacles.look(HERE, view((2.0, 0.0)), 0.0, 0.2)
    obstacles.look(HERE, view(), 19.0, 0.2)
    assert len(obstacles.points) == 1
    obstacles.look(HERE, view(), 21.0, 0.2)
    assert len(obstacles.points) == 0


def test_what_is_seen_through_is_forgotten_at_once() -> None:
    obstacles = Obstacles(hall(), memory=20.0)
    obstacles.look(HERE, view((2.0, 0.0)), 0.0, 0.2)
    obstacles.look(HERE, view((4.95, 0.0)), 0.1, 0.2)
    assert len(obstacles.points) == 0


def test_what_is_seen_again_or_hidden_is_kept() -> None:
    obstacles = Obstacles(hall(), memory=20.0)
    obstacles.look(HERE, view((2.0, 0.0)), 0.0, 0.2)
    obstacles.look(HERE, view((2.0, 0.0), (4.95, 0.2)), 15.0, 0.2)
    assert len(obstacles.points) == 1
    obstacles.look(HERE, view((1.0, 0.0)), 30.0, 0.2)
    assert len(obstacles.points) == 2


def test_a_look_beside_it_does_not_make_it_forgotten() -> None:
    obstacles = Obstacles(hall(), memory=20.0)
    obstacles.look(HERE, view((2.0, 0.0)), 0.0, 0.2)
    obstacles.look(HERE, view((4.95, 0.6), (-0.9, 0.0)), 0.1, 0.2)
    assert len(obstacles.points) == 1


def test_all_of_it_can_be_forgotten() -> None:
    obstacles = Obstacles(hall(), memory=20.0)
    obstacles.look(HERE, view((2.0, 0.0), (1.0, 0.5)), 0.0, 0.2)
    obstacles.forget()
    assert obstacles.points.shape == (0, 2)


def test_an_echo_may_come_from_anywhere_in_its_cone() -> None:
    mounts = np.array([[0.2, 0.0, 0.0], [0.0, 0.2, np.pi / 2.0]])
    seen = echo_view([0.5, np.inf], mounts, np.deg2rad(60.0))
    side = 0.5 * np.cos(np.pi / 6.0) + 0.2
    expected = np.array([[side, -0.25], [0.7, 0.0], [side, 0.25]])
    assert seen.points == pytest.approx(expected)


def test_echoes_from_afar_say_too_little_of_where_they_come_from() -> None:
    assert echo_view([3.0, np.nan], np.zeros((2, 3)), 0.4).points.shape == (0, 2)
    assert echo_view([], np.zeros((0, 3)), 0.4).gap == np.inf
