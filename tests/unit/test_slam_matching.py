"""Scans on maps: the search finds them, the refinement fits them, the tracker follows them."""

import math
from itertools import product

import numpy as np
import pytest
from numpy.typing import ArrayLike

from pilotage.core import se2
from pilotage.mapper.correlative_search import (
    FULL,
    SearchRaster,
    SearchWindow,
    search,
    search_raster,
    turn_step,
)
from pilotage.mapper.scan_matcher import MatchParams, refine
from pilotage.mapper.scan_tracker import (
    HERE,
    Tracked,
    TrackerParams,
    corrected,
    local_map,
    predicted,
)
from pilotage.mapper.surfels import SurfelParams, surfel_map
from slam_world import building, points_at

ROOM = """
    ##################
    #........#.......#
    #........#.......#
    #................#
    #................#
    #..####..........#
    #..####.......####
    #................#
    #................#
    ##################
    """
HERE_IN_ROOM = np.array([3.1, 2.6, 0.3])
PARAMS = TrackerParams()
SURE = np.diag([0.01, 0.01, 0.005]) ** 2
DENSE = np.linspace(-math.pi, math.pi, 1440, endpoint=False)


def off_by(x: float, y: float, theta: float) -> np.ndarray:
    """A pose beside HERE_IN_ROOM."""
    pose: np.ndarray = HERE_IN_ROOM + np.array([x, y, theta])
    return pose


@pytest.fixture(scope="module")
def room() -> np.ndarray:
    """What was seen of the room, as points in its frame."""
    world = building(ROOM, 4)
    others = [(1.0, 1.0, 0.0), (5.5, 1.0, 2.0), (5.5, 3.2, 2.0), (1.2, 3.2, -1.0)]
    places: list[ArrayLike] = [HERE_IN_ROOM, *others]
    seen = [se2.transform_points(pose, points_at(world, pose, None, DENSE)) for pose in places]
    return np.vstack(seen)


def corridor(length: float = 20.0) -> np.ndarray:
    """The points of two long walls at y = -1 and 1, every 2 cm."""
    x = np.arange(-length, length, 0.02)
    return np.vstack([np.column_stack([x, np.full(len(x), side)]) for side in (-1.0, 1.0)])


def raster_of(points: np.ndarray, depth: int = 4) -> SearchRaster:
    return search_raster(surfel_map(points, SurfelParams()), 0.08, depth)


def best_of_all(
    raster: SearchRaster, points: np.ndarray, guess: np.ndarray, window: SearchWindow
) -> float:
    """The score of the best pose of a window, each looked at."""
    step = turn_step(points, raster.cell)
    turns = range(-math.ceil(window.turn / step), math.ceil(window.turn / step) + 1)
    half = math.ceil(window.radius / raster.cell)
    shifts = range(-half, half + 1)
    values, best = raster.layers[0], 0.0
    for turn, row, col in product(turns, shifts, shifts):
        pose = guess + np.array([0.0, 0.0, turn * step])
        cells = (se2.transform_points(pose, points) - raster.corner) / raster.cell
        rows, cols = np.floor(cells).astype(int)[:, ::-1].T + raster.pad + [[row], [col]]
        inside = (rows >= 0) & (rows < values.shape[0]) & (cols >= 0) & (cols < values.shape[1])
        fit = values[rows[inside], cols[inside]].sum() / FULL
        off = (row * raster.cell, col * raster.cell)
        away = (math.hypot(*off) / window.sigma) ** 2 + (turn * step / window.turn_sigma) ** 2
        best = max(best, float(fit - 0.5 * window.weight * away) / len(points))
    return best


@pytest.mark.parametrize("sigma", [math.inf, 0.2])
def test_search_finds_the_best_pose_of_its_window(room: np.ndarray, sigma: float) -> None:
    points = points_at(building(ROOM, 4), HERE_IN_ROOM)[::6]
    guess = off_by(0.12, -0.2, 0.06)
    window = SearchWindow(0.3, 0.08, sigma, sigma, 2.0)
    found = search(raster_of(room), points, guess, window)
    assert found is not None
    assert found[1] == pytest.approx(best_of_all(raster_of(room), points, guess, window))


@pytest.mark.parametrize("depth", [1, 2, 4, 6])
def test_search_finds_a_scan_far_from_its_guess(room: np.ndarray, depth: int) -> None:
    points = points_at(building(ROOM, 4), HERE_IN_ROOM)
    guess = off_by(0.9, -0.8, 0.9)
    found = search(raster_of(room, depth), points, guess, SearchWindow(1.0, 1.0))
    assert found is not None
    pose, score = found
    assert np.hypot(*(pose - HERE_IN_ROOM)[:2]) < 0.08
    assert abs(pose[2] - HERE_IN_ROOM[2]) < 0.03
    assert score > 0.7


def test_search_finds_a_scan_that_was_turned_half_round(room: np.ndarray) -> None:
    points = points_at(building(ROOM, 4), HERE_IN_ROOM)
    guess = off_by(0.1, 0.1, math.pi)
    found = search(raster_of(room), points, guess, SearchWindow(0.3, math.pi))
    assert found is not None
    assert math.cos(found[0][2] - HERE_IN_ROOM[2]) > 0.999


def test_search_does_not_leave_its_window(room: np.ndarray) -> None:
    points = points_at(building(ROOM, 4), HERE_IN_ROOM)
    guess = off_by(0.9, 0.0, 0.0)
    found = search(raster_of(room), points, guess, SearchWindow(0.4, 0.1))
    assert found is not None
    assert np.abs(found[0] - guess)[:2].max() < 0.45
    assert found[1] < 0.6


def test_search_finds_nothing_where_nothing_is(room: np.ndarray) -> None:
    points = points_at(building(ROOM, 4), HERE_IN_ROOM)
    window = SearchWindow(0.5, 0.2)
    assert search(raster_of(room), points, np.array([90.0, 90.0, 0.0]), window) is None
    assert search(raster_of(room), points, HERE_IN_ROOM, window, least=1.01) is None


def test_of_poses_that_fit_alike_the_expected_one_is_found() -> None:
    """Along a corridor all fit; what a way off costs decides."""
    points = points_at(building("#" * 40 + "\n" + "." * 40 + "\n" + "#" * 40, 10), (20.0, 1.5, 0.0))
    raster = raster_of(corridor() * [1.0, 0.5])
    window = SearchWindow(1.0, 0.0, 0.3, 0.1)
    found = search(raster, points[::4], np.array([3.0, 0.1, 0.0]), window)
    assert found is not None
    assert found[0] == pytest.approx([3.0, 0.0, 0.0], abs=0.06)


@pytest.mark.parametrize("offset", [(0.05, -0.04, 0.03), (-0.08, 0.02, -0.05), (0.0, 0.0, 0.0)])
def test_a_scan_is_fitted_to_a_millimetre(
    room: np.ndarray, offset: tuple[float, float, float]
) -> None:
    points = points_at(building(ROOM, 4), HERE_IN_ROOM)
    surfels = surfel_map(room, SurfelParams())
    match = refine(surfels, points, off_by(*offset), MatchParams())
    assert np.abs(match.pose - HERE_IN_ROOM)[:2].max() < 0.001
    assert abs(match.pose[2] - HERE_IN_ROOM[2]) < 0.0005
    assert match.cost < 0.05
    assert match.seen > 0.99


def test_a_noisy_scan_is_fitted_to_its_noise(room: np.ndarray) -> None:
    rng = np.random.default_rng(3)
    surfels = surfel_map(room, SurfelParams())
    off = []
    for _ in range(20):
        points = points_at(building(ROOM, 4), HERE_IN_ROOM, rng)
        match = refine(surfels, points, HERE_IN_ROOM + rng.normal(0.0, 0.03, 3), MatchParams())
        off.append(match.pose - HERE_IN_ROOM)
    assert np.abs(np.mean(off, axis=0)).max() < 0.002
    assert np.std(off, axis=0).max() < 0.004


def test_furniture_that_came_does_not_move_the_fit(room: np.ndarray) -> None:
    points = points_at(building(ROOM, 4), HERE_IN_ROOM)
    points[20:50] *= 0.6
    match = refine(surfel_map(room, SurfelParams()), points, HERE_IN_ROOM, MatchParams())
    assert np.abs(match.pose - HERE_IN_ROOM).max() < 0.003
    assert 0.05 < match.cost < 0.3


def test_along_a_corridor_the_expectation_decides() -> None:
    surfels = surfel_map(corridor(), SurfelParams())
    points = corridor(4.0)[::10] + np.array([0.0, 0.3])  # seen from 0.3 m right of the middle
    expected = np.array([0.4, -0.2, 0.0])
    prior = np.diag([1.0 / 0.1**2, 1.0 / 0.1**2, 1.0 / 0.05**2]), expected
    match = refine(surfels, points, expected, MatchParams(), prior)
    assert match.pose[0] == pytest.approx(0.4, abs=0.02)
    assert match.pose[1] == pytest.approx(-0.3, abs=0.001)


def test_a_corridor_says_little_of_the_way_along_it() -> None:
    surfels = surfel_map(corridor(), SurfelParams())
    match = refine(surfels, corridor(4.0)[::10], np.zeros(3), MatchParams())
    along, across = math.sqrt(match.information[0, 0]), math.sqrt(match.information[1, 1])
    assert across > 50.0 * along
    assert along < 1.0 / 0.5  # no better known than half a metre


def test_many_points_are_worth_no_more_than_some(room: np.ndarray) -> None:
    surfels = surfel_map(room, SurfelParams())
    world = building(ROOM, 4)
    few = refine(surfels, points_at(world, HERE_IN_ROOM), HERE_IN_ROOM, MatchParams())
    dense = points_at(world, HERE_IN_ROOM, None, DENSE)
    many = refine(surfels, dense, HERE_IN_ROOM, MatchParams())
    assert np.diag(many.information) == pytest.approx(np.diag(few.information), rel=0.1)


def test_what_fits_nowhere_costs_all_and_moves_nothing(room: np.ndarray) -> None:
    nowhere = np.array([50.0, 50.0, 0.0])
    match = refine(surfel_map(room, SurfelParams()), np.ones((5, 2)), nowhere, MatchParams())
    assert match.pose == pytest.approx(nowhere)
    assert (match.cost, match.seen) == (1.0, 0.0)
    assert not match.information.any()


def test_without_points_the_expectation_stays(room: np.ndarray) -> None:
    prior = np.eye(3), HERE_IN_ROOM
    none = np.empty((0, 2))
    match = refine(surfel_map(room, SurfelParams()), none, HERE_IN_ROOM, MatchParams(), prior)
    assert match.pose == pytest.approx(HERE_IN_ROOM)
    assert match.seen == 0.0


def test_headings_are_compared_across_half_a_turn(room: np.ndarray) -> None:
    """A scan taken towards -x: a heading just below pi is next to one just above -pi."""
    pose = np.array([3.1, 2.6, math.pi - 0.01])
    points = points_at(building(ROOM, 4), pose)
    expected = np.array([3.1, 2.6, -math.pi + 0.01])
    prior = np.diag([1e4, 1e4, 1e4]), expected
    match = refine(surfel_map(room, SurfelParams()), points, expected, MatchParams(), prior)
    assert abs(math.remainder(match.pose[2] - pose[2], math.tau)) < 0.02
    assert -math.pi <= match.pose[2] < math.pi


def test_odometry_predicts_and_the_scan_corrects(room: np.ndarray) -> None:
    begin = Tracked(HERE_IN_ROOM, SURE, is_matched=True)
    moved = np.array([0.3, 0.0, 0.1])
    truth = se2.compose(HERE_IN_ROOM, moved)
    guess = predicted(begin, moved + np.array([0.06, -0.05, 0.08]), PARAMS.drift)
    assert not guess.is_matched
    points = points_at(building(ROOM, 4), truth)
    found = corrected(guess, points, local_map(room, PARAMS), PARAMS)
    assert found.is_matched
    assert found.pose == pytest.approx(truth, abs=0.004)
    assert (np.diag(found.covariance) < np.diag(guess.covariance)).all()
    assert (np.diag(guess.covariance) > np.diag(SURE)).all()


def test_a_robot_that_was_lifted_and_turned_is_found(room: np.ndarray) -> None:
    truth = off_by(0.4, -0.3, 1.4)
    guess = Tracked(HERE_IN_ROOM, SURE, is_matched=False)
    points = points_at(building(ROOM, 4), truth)
    found = corrected(guess, points, local_map(room, PARAMS), PARAMS)
    assert found.is_matched
    assert found.pose == pytest.approx(truth, abs=0.01)


def test_a_scan_of_elsewhere_is_not_believed(room: np.ndarray) -> None:
    rng = np.random.default_rng(1)
    angles = rng.uniform(-math.pi, math.pi, 200)
    lengths = rng.uniform(0.3, 8.0, 200)
    points = lengths[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    guess = Tracked(HERE_IN_ROOM, SURE, is_matched=False)
    found = corrected(guess, points, local_map(room, PARAMS), PARAMS)
    assert not found.is_matched
    assert found.pose == pytest.approx(guess.pose)
    assert (np.diag(found.covariance) >= np.diag(guess.covariance)).all()


def test_few_beams_correct_but_do_not_overrule_odometry(room: np.ndarray) -> None:
    bearings = np.linspace(-1.5, 1.5, 11)
    points = points_at(building(ROOM, 4), HERE_IN_ROOM, None, bearings)
    guess = Tracked(off_by(0.03, -0.02, 0.02), 4.0 * SURE, is_matched=False)
    here = local_map(room, PARAMS)
    found = corrected(guess, points, here, PARAMS)
    assert np.abs(found.pose - HERE_IN_ROOM).max() < 0.7 * np.abs(guess.pose - HERE_IN_ROOM).max()
    far = corrected(guess, 0.5 * points, here, PARAMS)
    assert np.abs(far.pose - guess.pose).max() < 0.1


def test_a_keyframe_is_its_own_origin() -> None:
    assert not HERE.pose.any()
    assert HERE.is_matched
    assert np.diag(HERE.covariance).max() < 1e-5


def test_a_map_of_one_point_can_be_matched_against() -> None:
    here = local_map(np.array([[1.0, 2.0]]), PARAMS)
    found = corrected(HERE, np.array([[1.01, 2.0]]), here, PARAMS)
    assert np.abs(found.pose).max() < 0.02
