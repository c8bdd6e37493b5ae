import math

import numpy as np
import pytest

from pilotage.core.angles import circular_mean, difference, wrap


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [(0.0, 0.0), (math.pi, -math.pi), (-math.pi, -math.pi), (3.5 * math.pi, -0.5 * math.pi)],
)
def test_wrapped_angle_lies_from_minus_pi_to_below_pi(angle: float, wrapped: float) -> None:
    assert wrap(angle) == pytest.approx(wrapped)


def test_float_stays_a_float_and_an_array_keeps_its_shape() -> None:
    assert isinstance(wrap(4.0), float)
    assert wrap(np.full((2, 3), 4.0)).shape == (2, 3)


def test_difference_is_the_shortest_turn() -> None:
    assert difference(-3.0, 3.0) == pytest.approx(2.0 * math.pi - 6.0)
    assert difference(0.1, 0.3) == pytest.approx(-0.2)


def test_mean_of_directions_around_the_wrap_is_the_wrap() -> None:
    mean = circular_mean(np.array([3.0, -3.0]), np.array([1.0, 1.0]))
    assert abs(mean) == pytest.approx(math.pi)


def test_heavier_direction_pulls_the_mean() -> None:
    mean = circular_mean(np.array([0.0, math.pi / 2.0]), np.array([1.0, 3.0]))
    assert mean == pytest.approx(math.atan(3.0))
