import math

import numpy as np
import pytest

from pilotage.mapper.arc_median import (
    CrossingParams,
    crossing_score,
    find_crossings,
    mean_of_midpoints,
    place_echoes,
)
from pilotage.mapper.echo_memory import EchoMemory, EchoMemoryParams
from pilotage.mapper.sonar_arcs import all_crossings, are_on_surface

CONE = 0.44
LEAST = math.radians(30.0)
ONES = np.ones(12)


def arc_to(place: tuple[float, float], x: float, y: float, aside: float = 0.0) -> list[float]:
    """An arc of a sonar at (x, y) that passes through a place, `aside` rad from its axis."""
    dx, dy = place[0] - x, place[1] - y
    return [x, y, math.atan2(dy, dx) - aside, math.hypot(dx, dy)]


POST = 0.2, 0.8
TWO = np.array([arc_to(POST, -0.2, 0.0, 0.1), arc_to(POST, 0.6, 0.0, -0.05)])


def test_arcs_of_one_post_cross_at_it() -> None:
    found = all_crossings(TWO, CONE / 2.0, LEAST)
    assert found[:, :2] == pytest.approx(np.array([POST]))


def test_arcs_cross_at_the_angle_of_their_axes() -> None:
    arcs = np.array([arc_to((0.0, 1.0), 0.0, 0.0), arc_to((0.0, 1.0), -1.0, 1.0)])
    assert all_crossings(arcs, CONE / 2.0, LEAST)[:, 2] == pytest.approx([math.pi / 2.0])


def test_flat_crossings_are_left_out() -> None:
    arcs = np.array([arc_to(POST, 0.2, 0.0), arc_to(POST, 0.4, 0.0)])
    assert len(all_crossings(arcs, CONE / 2.0, LEAST)) == 0
    assert len(all_crossings(arcs, CONE / 2.0, 0.0)) == 1


def test_circles_that_cross_outside_the_cones_do_not_count() -> None:
    arcs = np.array([arc_to(POST, -0.5, 0.0, 0.23), arc_to(POST, 0.9, 0.0)])
    assert len(all_crossings(arcs, CONE / 2.0, LEAST)) == 0


@pytest.mark.parametrize("count", [0, 1])
def test_an_arc_alone_crosses_nothing(count: int) -> None:
    assert all_crossings(TWO[:count], CONE / 2.0, LEAST).shape == (0, 5)


def test_the_same_arc_twice_crosses_nowhere() -> None:
    assert len(all_crossings(TWO[[0, 0]], CONE / 2.0, 0.0)) == 0


def test_an_echo_is_placed_where_its_arc_is_crossed() -> None:
    for improved in (False, True):
        placed = place_echoes(TWO, 0, 2, CONE, (improved, LEAST, ONES, 0.0))
        assert placed == pytest.approx(np.array([[0.1, 1.0], [-0.05, 1.0]]))


def test_an_arc_that_nothing_crosses_keeps_its_middle() -> None:
    placed = place_echoes(TWO[:1], 0, 1, CONE, (True, LEAST, ONES, 0.0))
    assert placed.tolist() == [[0.0, 0.0]]


def test_median_is_not_moved_by_one_stray_crossing_but_the_mean_is() -> None:
    target = [0.0, 0.0, math.pi / 2.0, 1.0]
    places = [(math.sin(a), math.cos(a)) for a in (0.0, 0.002, 0.15)]
    arcs = np.array([target] + [arc_to(place, 1.2, 0.6) for place in places])
    median = place_echoes(arcs, 0, 1, CONE, (False, LEAST, ONES, 0.0))[0, 0]
    mean = place_echoes(arcs, 0, 1, CONE, (True, LEAST, ONES, 0.0))[0, 0]
    assert median == pytest.approx(-0.002, abs=1e-6)
    assert mean == pytest.approx(-(0.001 + 0.076) / 2.0, abs=1e-6)


def test_midpoints_lie_between_neighbours() -> None:
    assert mean_of_midpoints(np.array([0.0, 0.1, 0.2, 0.3])) == pytest.approx(0.15)
    assert mean_of_midpoints(np.array([0.0, 0.3])) == pytest.approx(0.15)
    assert mean_of_midpoints(np.array([0.2])) == 0.2


def test_score_is_equation_4_2() -> None:
    angle, cone_degrees, first, second = math.radians(40.0), 25.0, 0.8, 1.1
    weights = np.arange(12.0)
    printed = (
        360.0
        * (math.sin(angle) + math.tan(angle))
        / (math.pi * cone_degrees * math.sin(angle) * math.tan(angle) * 100.0 * (first + second))
        * 2.0  # the weight of 40 to 45 degrees
    )
    score = crossing_score(angle, first, second, math.radians(cone_degrees), weights)
    assert score == pytest.approx(printed)


@pytest.mark.parametrize(("degrees", "step"), [(30, 0), (34.9, 0), (35, 1), (89.9, 11), (90, 11)])
def test_weights_belong_to_steps_of_five_degrees(degrees: float, step: int) -> None:
    weights = np.zeros(12)
    weights[step] = 1.0
    assert crossing_score(math.radians(degrees), 1.0, 1.0, CONE, weights) > 0.0


def test_far_arcs_are_dropped_by_the_threshold_of_the_improved_method_alone() -> None:
    far = np.array([arc_to((0.0, 4.0), -2.0, 0.0), arc_to((0.0, 4.0), 2.0, 0.0)])
    params = CrossingParams(least_score=0.03)
    assert find_crossings(far, CONE, params, improved=False).is_used.tolist() == [True]
    assert find_crossings(far, CONE, params, improved=True).is_used.tolist() == [False]
    assert find_crossings(TWO, CONE, params, improved=True).is_used.tolist() == [True]


def test_crossings_name_their_arcs() -> None:
    found = find_crossings(TWO, CONE, CrossingParams(), improved=True)
    assert found.pairs.tolist() == [[0, 1]]
    assert found.points == pytest.approx(np.array([POST]))


def test_weights_must_fit_the_steps() -> None:
    with pytest.raises(ValueError, match="12 weights"):
        CrossingParams(weights=(1.0,))


def test_crossings_near_the_surface_are_valid() -> None:
    assert are_on_surface(np.array([0.0, 0.05, 0.07]), 0.06).tolist() == [True, True, False]


def test_an_echo_waits_for_others_to_cross_its_arc() -> None:
    memory = EchoMemory(EchoMemoryParams(delay=1), CONE, improved=True)
    assert len(memory.take(TWO[:1])) == 0
    assert memory.waiting()[:, 4].tolist() == [0.0]
    placed = memory.take(TWO[1:])
    assert placed[:, :4] == pytest.approx(TWO[:1])
    assert placed[:, 4] == pytest.approx([0.1])
    assert len(memory.waiting()) == 1


def test_memory_of_echoes_is_bounded() -> None:
    memory = EchoMemory(EchoMemoryParams(memory=20, delay=5), CONE, improved=True)
    for step in range(40):
        arcs = np.array([arc_to(POST, 0.01 * step, 0.0), arc_to(POST, -0.01 * step, 0.1)])
        memory.take(arcs)
    assert len(memory.remember()["arcs"]) == 25
    assert len(memory.waiting()) == 5


def test_every_echo_is_placed_once() -> None:
    memory = EchoMemory(EchoMemoryParams(memory=6, delay=3), CONE, improved=False)
    rng = np.random.default_rng(0)
    arcs = rng.uniform([-1, -1, -3, 0.2], [1, 1, 3, 1], (50, 4))
    placed = [memory.take(part) for part in np.array_split(arcs, 17)]
    assert np.concatenate([*placed, memory.waiting()])[:, :4] == pytest.approx(arcs)
