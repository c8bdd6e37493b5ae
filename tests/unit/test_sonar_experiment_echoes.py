"""What a sonar hears of walls: perpendiculars, corners and edges, and what goes astray."""

import numpy as np
import pytest
from numpy.typing import NDArray

from pilotage.experiments.sonar_echoes import EchoParams, bounced, sonar_ranges
from pilotage.experiments.wall_segments import (
    cross,
    distance_to_walls,
    is_concave,
    is_seen,
    nearest_in_cone,
)

Floats = NDArray[np.float64]
WALL_AHEAD = np.array([[2.0, -5.0, 2.0, 5.0]])
EXACT = EchoParams(sigma=0.0, share_without_echo=0.0, share_of_crosstalk=0.0)
SURE = EchoParams(
    sigma=0.0, share_without_echo=0.0, share_of_crosstalk=0.0, edge_chance=1.0, edge_reach=1e9
)


def heard(walls: Floats, sonar: tuple[float, float, float], params: EchoParams = EXACT) -> float:
    return float(sonar_ranges(walls, np.array([sonar]), params, np.random.default_rng(0))[0])


def share_heard(walls: Floats, sonar: tuple[float, float, float], params: EchoParams) -> float:
    many = np.tile(sonar, (400, 1))
    ranges = sonar_ranges(walls, many, params, np.random.default_rng(0))
    return float(np.isfinite(ranges).mean())


def test_a_wall_ahead_answers_from_its_perpendicular() -> None:
    assert heard(WALL_AHEAD, (0.0, 0.0, 0.0)) == pytest.approx(2.0)


def test_a_wall_askew_within_the_cone_still_answers_from_its_perpendicular() -> None:
    assert heard(WALL_AHEAD, (0.0, 0.0, np.deg2rad(12.0))) == pytest.approx(2.0)


def test_a_wall_askew_beyond_the_cone_answers_from_the_edge_of_the_cone() -> None:
    askew = np.deg2rad(20.0)
    at_the_edge = 2.0 / np.cos(np.deg2rad(7.5))
    assert heard(WALL_AHEAD, (0.0, 0.0, askew)) == pytest.approx(at_the_edge, abs=0.006)


def test_a_wall_seen_askew_is_a_mirror() -> None:
    alone = EchoParams(bounce_chance=0.0)
    assert share_heard(WALL_AHEAD, (0.0, 0.0, np.deg2rad(20.0)), alone) > 0.95
    assert 0.3 < share_heard(WALL_AHEAD, (0.0, 0.0, np.deg2rad(35.0)), alone) < 0.8
    assert share_heard(WALL_AHEAD, (0.0, 0.0, np.deg2rad(50.0)), alone) < 0.02


def test_what_is_beyond_the_range_does_not_answer() -> None:
    assert heard(WALL_AHEAD, (-2.5, 0.0, 0.0)) == np.inf


def test_what_is_too_near_is_heard_at_the_least_range() -> None:
    assert heard(WALL_AHEAD, (1.95, 0.0, 0.0)) == pytest.approx(0.1)


def test_ranges_come_in_steps_of_the_resolution() -> None:
    noisy = EchoParams(share_without_echo=0.0, share_of_crosstalk=0.0)
    ranges = sonar_ranges(WALL_AHEAD, np.zeros((500, 3)), noisy, np.random.default_rng(0))
    assert ranges * 100.0 == pytest.approx(np.round(ranges * 100.0))
    assert ranges.mean() == pytest.approx(2.0, abs=0.002)
    assert ranges.std() == pytest.approx(0.01, rel=0.2)


def test_a_concave_corner_answers_like_a_wall() -> None:
    corner = np.array([[0.0, 2.0, 2.0, 2.0], [2.0, 2.0, 2.0, 0.0]])
    assert heard(corner, (1.0, 1.0, np.pi / 4.0)) == pytest.approx(np.sqrt(2.0), abs=0.006)


def test_an_edge_answers_weakly_and_only_from_near() -> None:
    edge = np.array([[1.0, 0.0, 1.0, -3.0], [1.0, 0.0, 4.0, 0.0]])
    near = share_heard(edge, (0.3, 0.5, np.deg2rad(-35.0)), EchoParams(last_incidence=0.2))
    far = share_heard(edge, (-1.2, 1.6, np.deg2rad(-36.0)), EchoParams(last_incidence=0.2))
    assert 0.2 < near < 0.8
    assert far < 0.05


def test_the_end_of_a_wall_is_heard_by_its_true_range() -> None:
    post = np.array([[1.0, 1.0, 1.0, 5.0]])
    assert heard(post, (0.0, 1.05, np.deg2rad(-8.0)), SURE) == pytest.approx(1.0, abs=0.01)


def test_nothing_is_heard_through_a_wall() -> None:
    walls = np.array([[2.0, -5.0, 2.0, 5.0], [3.0, -5.0, 3.0, 5.0]])
    points, _ = nearest_in_cone(walls, np.zeros((1, 3)), 0.2)
    assert is_seen(walls, np.zeros((1, 3)), points).tolist() == [[True, False]]


def test_an_echo_by_way_of_two_walls_is_as_long_as_its_way() -> None:
    """A mirror at 45 degrees sends the sound up to a wall, which sends it back."""
    walls = np.array([[1.0, -1.0, 3.0, 1.0], [0.0, 1.5, 4.0, 1.5]])
    alone = EchoParams(half_cone=1e-6)
    assert bounced(walls, np.zeros((1, 3)), alone) == pytest.approx([2.0 + 1.5], abs=1e-3)


def test_an_echo_that_hits_nothing_never_comes_back() -> None:
    assert bounced(WALL_AHEAD, np.array([[0.0, 0.0, np.pi]]), EXACT).tolist() == [np.inf]
    assert bounced(WALL_AHEAD, np.array([[0.0, 0.0, 0.8]]), EXACT).tolist() == [np.inf]


def test_the_nearest_point_in_a_cone_is_that_of_a_fine_fan() -> None:
    rng = np.random.default_rng(4)
    walls, sonars = rng.uniform(-2.0, 2.0, (30, 4)), rng.uniform(-1.0, 1.0, (20, 3))
    points, holds = nearest_in_cone(walls, sonars, 0.2)
    exact = np.where(holds, np.hypot(*np.moveaxis(points - sonars[:, None, :2], -1, 0)), np.inf)
    fan = np.full(exact.shape, np.inf)
    for side in np.linspace(-0.2, 0.2, 801):
        way, where = cross(walls, sonars[:, :2], sonars[:, 2] + side)
        fan = np.minimum(fan, np.where(where, way, np.inf))
    # Where a wall only pokes its end into the cone, that end is a corner's affair.
    both = np.isfinite(exact) & np.isfinite(fan)
    assert both.sum() > 50
    assert np.all(exact[both] >= fan[both] - 1e-6)
    assert np.mean(exact[both] < fan[both] + 1e-3) > 0.85


def test_distances_are_to_the_nearest_of_all_walls_and_their_ends() -> None:
    walls = np.array([[0.0, 0.0, 1.0, 0.0], [3.0, 0.0, 3.0, 1.0]])
    points = np.array([[0.5, 0.4], [-3.0, 4.0], [2.9, 0.5]])
    assert distance_to_walls(walls, points) == pytest.approx([0.4, 5.0, 0.1])


@pytest.mark.parametrize(("sonar", "inside"), [((0.5, 0.5, 0.0), True), ((-0.5, -0.5, 0.0), False)])
def test_a_corner_is_concave_from_within(sonar: tuple[float, float, float], inside: bool) -> None:  # noqa: FBT001  - a case of the table
    walls = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    assert is_concave(walls, np.zeros((1, 2)), np.array([sonar])).tolist() == [[inside]]
