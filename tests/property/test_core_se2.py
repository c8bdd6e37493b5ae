import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pilotage.core import se2
from pilotage.core.angles import circular_mean, difference, wrap
from pilotage.core.motion import arc

LENGTHS = st.floats(-100.0, 100.0) | st.sampled_from([0.0, 1e-9, -1e-9])
ANGLES = st.floats(-10.0, 10.0) | st.sampled_from([0.0, 1e-9, math.pi, -math.pi, 2.0 * math.pi])
POSES = st.tuples(LENGTHS, LENGTHS, ANGLES).map(np.array)
IDENTITY = np.zeros(3)


def assert_same(one: np.ndarray, two: np.ndarray, tolerance: float = 1e-9) -> None:
    """Poses agree; headings on both sides of the wrap are close."""
    assert one[:2] == pytest.approx(two[:2], abs=tolerance)
    assert difference(float(one[2]), float(two[2])) == pytest.approx(0.0, abs=tolerance)


@given(POSES)
def test_identity_changes_nothing(pose: np.ndarray) -> None:
    assert_same(se2.compose(IDENTITY, pose), pose)
    assert_same(se2.compose(pose, IDENTITY), pose)


@given(POSES)
def test_inverse_undoes_from_either_side(pose: np.ndarray) -> None:
    assert_same(se2.compose(pose, se2.inverse(pose)), IDENTITY)
    assert_same(se2.compose(se2.inverse(pose), pose), IDENTITY)


@given(POSES, POSES, POSES)
def test_composition_is_associative(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> None:
    assert_same(se2.compose(se2.compose(a, b), c), se2.compose(a, se2.compose(b, c)))


@given(POSES, POSES)
def test_between_leads_from_one_to_the_other(a: np.ndarray, b: np.ndarray) -> None:
    assert_same(se2.compose(a, se2.between(a, b)), b)


@given(POSES, POSES, st.tuples(LENGTHS, LENGTHS))
def test_points_go_through_a_composition_as_through_its_parts(
    a: np.ndarray, b: np.ndarray, point: tuple[float, float]
) -> None:
    at_once = se2.transform_points(se2.compose(a, b), [point])
    in_steps = se2.transform_points(a, se2.transform_points(b, [point]))
    assert at_once == pytest.approx(in_steps, abs=1e-9)


@given(POSES, POSES)
def test_interpolation_meets_both_ends(a: np.ndarray, b: np.ndarray) -> None:
    assert_same(se2.interpolate(a, b, 0.0), a)
    assert_same(se2.interpolate(a, b, 1.0), b)


@given(ANGLES, st.integers(-3, 3))
def test_wrap_is_periodic_and_stays_in_its_interval(angle: float, turns: int) -> None:
    wrapped = wrap(angle + 2.0 * math.pi * turns)
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


@given(st.floats(-1e-15, 1e-15) | st.floats(-20.0, 20.0))
def test_wrap_never_returns_pi_itself(offset: float) -> None:
    assert -math.pi <= wrap(math.pi + offset) < math.pi


@given(ANGLES, st.lists(st.floats(-1.5, 1.5), min_size=1, max_size=8))
def test_mean_direction_turns_with_the_directions(turn: float, angles: list[float]) -> None:
    weights = np.ones(len(angles))
    mean = circular_mean(np.array(angles), weights)
    turned = circular_mean(np.array(angles) + turn, weights)
    assert difference(turned, mean + turn) == pytest.approx(0.0, abs=1e-6)


SPEEDS = st.floats(-3.0, 3.0) | st.sampled_from([0.0, 1e-12, -1e-12])


@given(POSES, SPEEDS, SPEEDS, st.floats(0.0, 2.0), st.floats(0.0, 2.0))
def test_two_arcs_in_a_row_are_one_longer_arc(
    pose: np.ndarray, linear: float, angular: float, first: float, second: float
) -> None:
    in_steps = arc(arc(pose, linear, angular, first), linear, angular, second)
    assert_same(in_steps, arc(pose, linear, angular, first + second))


@given(POSES, SPEEDS, SPEEDS, st.floats(0.0, 2.0))
def test_arc_driven_back_ends_at_its_start(
    pose: np.ndarray, linear: float, angular: float, dt: float
) -> None:
    assert_same(arc(arc(pose, linear, angular, dt), -linear, -angular, dt), pose)
