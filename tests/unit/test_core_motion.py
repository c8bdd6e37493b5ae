import math

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.motion import OdometryNoise, arc, sample_odometry

SILENT = OdometryNoise(0.0, 0.0, 0.0, 0.0)
MANY = np.zeros((20_000, 3))


def test_quarter_circle_ends_a_radius_ahead_and_a_radius_aside() -> None:
    pose = arc([0.0, 0.0, 0.0], linear=math.pi / 2.0, angular=math.pi / 2.0, dt=1.0)
    assert pose == pytest.approx([1.0, 1.0, math.pi / 2.0])


def test_arc_without_a_turn_is_a_straight_line() -> None:
    assert arc([1.0, 2.0, math.pi / 2.0], 0.5, 0.0, 2.0) == pytest.approx([1.0, 3.0, math.pi / 2.0])


@pytest.mark.parametrize("angular", [1e-3, 1e-6, 1e-9, 1e-15, -1e-9])
def test_arc_is_smooth_where_the_turn_vanishes(angular: float) -> None:
    straight = arc([0.0, 0.0, 0.2], 1.0, 0.0, 1.0)
    assert arc([0.0, 0.0, 0.2], 1.0, angular, 1.0) == pytest.approx(
        straight, abs=abs(angular) + 1e-12
    )


def test_arc_equals_many_small_straight_steps() -> None:
    pose = np.array([1.0, -1.0, 2.0])
    walked = pose
    for _ in range(20_000):
        walked = se2.compose(walked, [0.7 * 1e-4, 0.0, -1.3 * 1e-4])
    assert arc(pose, 0.7, -1.3, 2.0) == pytest.approx(walked, abs=1e-4)


def test_arc_agrees_with_the_corrected_equations_of_the_thesis() -> None:
    theta, way, turn = 0.4, 1.7, 0.9
    x = way / turn * (math.sin(theta + turn) - math.sin(theta))
    y = -way / turn * (math.cos(theta + turn) - math.cos(theta))
    assert arc([0.0, 0.0, theta], way, turn, 1.0) == pytest.approx([x, y, theta + turn])


def test_arc_moves_many_poses_at_once() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [5.0, 5.0, math.pi]])
    assert arc(poses, 1.0, 0.0, 1.0) == pytest.approx(
        np.array([[1.0, 0.0, 0.0], [4.0, 5.0, -math.pi]])
    )


@pytest.mark.parametrize(
    "increment", [[0.5, 0.1, 0.3], [-0.4, 0.0, 0.1], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]
)
def test_without_noise_the_particles_move_as_the_odometry_says(increment: list[float]) -> None:
    poses = np.array([[1.0, 2.0, 3.0], [0.0, 0.0, -1.0]])
    moved = sample_odometry(poses, increment, SILENT, np.random.default_rng(1))
    assert moved == pytest.approx(se2.compose(poses, increment))


def test_standing_robot_stays_where_it_is() -> None:
    moved = sample_odometry(MANY, [0.0, 0.0, 0.0], OdometryNoise(), np.random.default_rng(1))
    assert (moved == 0.0).all()


def test_straight_way_spreads_as_its_coefficients_say() -> None:
    noise = OdometryNoise(
        rotation_noise_from_translation=0.04, translation_noise_from_translation=0.01
    )
    moved = sample_odometry(MANY, [2.0, 0.0, 0.0], noise, np.random.default_rng(2))
    way = np.hypot(moved[:, 0], moved[:, 1])
    assert way.std() == pytest.approx(0.2, rel=0.05)
    direction = np.arctan2(moved[:, 1], moved[:, 0])
    assert direction.std() == pytest.approx(0.4, rel=0.05)


def test_turn_on_the_spot_spreads_the_heading_alone() -> None:
    noise = OdometryNoise(0.01, 0.0, 0.0, 0.0)
    moved = sample_odometry(MANY, [0.0, 0.0, 1.0], noise, np.random.default_rng(3))
    assert moved[:, 2].std() == pytest.approx(0.1, rel=0.05)
    assert (moved[:, :2] == 0.0).all()


def test_driving_backwards_is_no_half_turn() -> None:
    noise = OdometryNoise(0.25, 0.0, 0.0, 0.0)
    moved = sample_odometry(MANY, [-1.0, 0.0, 0.0], noise, np.random.default_rng(4))
    assert moved[:, 2].std() < 1e-6


def test_same_generator_gives_the_same_sample() -> None:
    one, two = (
        sample_odometry(MANY[:5], [1.0, 0.0, 0.1], OdometryNoise(), np.random.default_rng(5))
        for _ in range(2)
    )
    assert (one == two).all()


@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
def test_noise_that_is_no_variance_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="rotation_noise_from_rotation"):
        OdometryNoise(rotation_noise_from_rotation=value)
