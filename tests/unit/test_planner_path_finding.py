"""Paths over drawn ground, and why there are none."""

import itertools

import numpy as np
import pytest

from drawing import draw
from pilotage.core.grid import OCCUPIED, GridGeometry, OccupancyMap
from pilotage.planner.ground import Ground
from pilotage.planner.path_finding import NoPathError, find_path

RADIUS = 0.165


def hall(rows: int = 60, cols: int = 100) -> OccupancyMap:
    """A hall of 5 m x 3 m in cells of 5 cm, its walls one cell thick, its corner at 0, 0."""
    cells = np.zeros((rows, cols), np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    return OccupancyMap(GridGeometry(rows, cols, 0.05), cells)


def two_rooms(door: float) -> OccupancyMap:
    """A hall with a wall at x = 2.5 m and a door of that width in m whose middle is y = 1.5 m."""
    world = hall()
    half = round(door / 0.05 / 2.0)
    world.cells[:, 50:52] = OCCUPIED
    world.cells[30 - half : 30 + half, 50:52] = 0
    return world


def along(path: np.ndarray) -> np.ndarray:
    """Points every centimetre of a path."""
    pieces = [
        a + np.linspace(0.0, 1.0, int(100.0 * np.hypot(*(b - a))) + 2)[:, None] * (b - a)
        for a, b in itertools.pairwise(path)
    ]
    return np.vstack(pieces)


def refusal(ground: Ground, start: tuple[float, float], goal: tuple[float, float]) -> str:
    with pytest.raises(NoPathError) as refused:
        find_path(ground, start, goal, RADIUS)
    return str(refused.value)


def test_in_the_open_the_path_is_straight() -> None:
    path = find_path(Ground.of(hall()), (1.0, 1.0), (4.0, 2.0), RADIUS)
    assert path == pytest.approx(np.array([[1.0, 1.0], [4.0, 2.0]]))


def test_a_path_through_a_door_keeps_its_middle() -> None:
    ground = Ground.of(two_rooms(0.8))
    way = along(find_path(ground, (1.0, 0.5), (4.0, 2.5), RADIUS))
    inside = way[np.abs(way[:, 0] - 2.55) < 0.05]
    assert np.abs(inside[:, 1] - 1.5).max() < 0.1
    assert ground.gaps_at(way).min() > RADIUS + 0.04


def test_a_door_of_half_a_metre_is_passed_and_a_narrower_one_is_not() -> None:
    find_path(Ground.of(two_rooms(0.55)), (1.0, 0.5), (4.0, 2.5), RADIUS)
    why = refusal(Ground.of(two_rooms(0.4)), (1.0, 0.5), (4.0, 2.5))
    assert "cannot be reached" in why


def test_a_robot_keeps_clear_of_walls_where_it_can() -> None:
    ground = Ground.of(hall())
    way = along(find_path(ground, (0.5, 0.5), (4.5, 0.5), RADIUS))
    middle = way[(way[:, 0] > 1.5) & (way[:, 0] < 3.5)]
    assert ground.gaps_at(middle).min() > RADIUS + 0.2


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        ((9.0, 1.0), "off the map"),
        ((2.0, -0.5), "off the map"),
        ((2.0, 0.02), "in a wall"),
        ((2.0, 0.15), "too close to a wall"),
        ((4.0, 1.5), "unknown ground"),
    ],
)
def test_a_goal_that_is_no_place_for_the_robot_is_refused(
    goal: tuple[float, float], reason: str
) -> None:
    world = hall()
    world.cells[25:35, 75:85] = -1
    assert reason in refusal(Ground.of(world), (1.0, 1.0), goal)


def test_a_goal_behind_a_wall_cannot_be_reached() -> None:
    why = refusal(Ground.of(two_rooms(0.0)), (1.0, 1.0), (4.0, 1.0))
    assert "(4.00, 1.00) cannot be reached" in why


def test_a_robot_that_is_walled_in_says_so() -> None:
    world = hall()
    world.cells[20:40, 20:22] = world.cells[20:40, 38:40] = OCCUPIED
    world.cells[20:22, 20:40] = world.cells[38:40, 20:40] = OCCUPIED
    assert "enclosed" in refusal(Ground.of(world), (1.5, 1.5), (4.0, 1.0))


def test_a_robot_off_the_map_or_inside_a_thick_wall_says_so() -> None:
    world = hall()
    assert "robot is off the map" in refusal(Ground.of(world), (-1.0, 1.0), (4.0, 1.0))
    world.cells[20:40, 20:40] = OCCUPIED
    assert "not free" in refusal(Ground.of(world), (1.5, 1.5), (4.0, 1.0))


@pytest.mark.parametrize("start", [(1.0, 0.1), (1.0, 0.04), (0.2, 0.2)])
def test_a_robot_too_near_a_wall_may_leave_it(start: tuple[float, float]) -> None:
    ground = Ground.of(hall())
    path = find_path(ground, start, (4.0, 1.5), RADIUS)
    assert path[0] == pytest.approx(start)
    way = along(path)
    away = way[np.hypot(*(way - start).T) > 0.6]
    assert ground.gaps_at(away).min() > RADIUS + 0.04


def test_leaving_a_wall_is_no_way_through_a_gap_that_is_too_narrow() -> None:
    assert "reached" in refusal(Ground.of(two_rooms(0.3)), (2.3, 1.5), (4.0, 1.0))


def test_obstacles_are_gone_round_and_may_close_a_door() -> None:
    ground = Ground.of(two_rooms(0.8))
    y = np.arange(1.0, 2.0, 0.05)
    beside = np.stack([np.full_like(y, 1.5), y], axis=1)
    way = along(find_path(ground.with_obstacles(beside), (0.7, 1.5), (4.0, 1.5), RADIUS))
    assert np.hypot(*(way[:, None] - beside[None]).T).min() > RADIUS + 0.04
    closed = ground.with_obstacles(beside + np.array([1.0, 0.0]))
    assert "reached" in refusal(closed, (0.7, 1.5), (4.0, 1.5))
    at_goal = ground.with_obstacles([[4.0, 1.5], [99.0, 99.0]])
    assert "the map lacks" in refusal(at_goal, (0.7, 1.5), (4.0, 1.5))


def test_obstacles_off_the_map_change_nothing() -> None:
    ground = Ground.of(hall())
    assert ground.with_obstacles([[99.0, 99.0]]) is ground
    assert ground.with_obstacles(np.zeros((0, 2))) is ground


def test_a_map_may_lie_askew_in_its_frame() -> None:
    straight = hall()
    askew = OccupancyMap(GridGeometry(60, 100, 0.05, (2.0, -1.0, 0.7)), straight.cells)
    start, goal = askew.geometry.centres_of([[20, 20], [40, 80]])
    path = find_path(Ground.of(askew), start, goal, RADIUS)
    assert path == pytest.approx(np.array([start, goal]))


def test_the_edge_of_the_map_stops_bodies() -> None:
    world = draw("..... ..... ..... ..... .....", resolution=0.1)
    assert Ground.of(world).clearance[2] == pytest.approx([0.1, 0.2, 0.3, 0.2, 0.1])
    assert Ground.of(world).gaps_at([[-1.0, 0.0], [0.25, 0.25]]) == pytest.approx([0.0, 0.25])


def test_where_unknown_ground_begins_no_laser_sees() -> None:
    ground = Ground.of(draw("??? ?.# ???"))
    edges = ground.unseen_near((1.5, 1.5), 9.0)
    assert sorted(map(tuple, edges.tolist())) == [(0.5, 1.5), (1.5, 0.5), (1.5, 2.5)]
    assert ground.unseen_near((1.5, 2.5), 0.5).tolist() == [[0.5, 1.5], [1.5, 2.5]]
    assert ground.unseen_near((99.0, -99.0), 1.0).shape == (0, 2)
