"""Dead reckoning, and how far it errs."""

import numpy as np
import pytest
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.robot.simulator.wheel_odometry import WheelOdometry, WheelOdometryParams

EXACT = WheelOdometryParams(0.0, 0.0, 0.0, 0.0, 0.0)


def reckoned(
    params: WheelOdometryParams, steps: list[tuple[float, float]], seed: int = 0
) -> WheelOdometry:
    odometry = WheelOdometry(params, np.random.default_rng(seed))
    for way, turn in steps:
        odometry.count(way, turn)
    return odometry


def ends(steps: list[tuple[float, float]]) -> NDArray[np.float64]:
    """Where 150 robots of the default kind believe to be."""
    return np.array([reckoned(WheelOdometryParams(), steps, seed).pose for seed in range(150)])


def test_without_errors_it_is_where_the_wheels_have_led_it() -> None:
    square = [(0.1, 0.0)] * 10 + [(0.0, np.pi / 20.0)] * 10
    assert reckoned(EXACT, square * 4).pose == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert reckoned(EXACT, square).pose == pytest.approx([1.0, 0.0, np.pi / 2.0])


def test_standing_still_adds_nothing() -> None:
    odometry = reckoned(WheelOdometryParams(), [(0.0, 0.0)] * 1000)
    assert not odometry.pose.any()
    assert not odometry.covariance.any()


def test_ten_metres_are_wrong_by_one_to_two_per_cent() -> None:
    errors = ends([(0.25, 0.0)] * 40)[:, 0] - 10.0
    assert 0.05 < errors.std() < 0.2
    assert abs(errors.mean()) < 0.03


def test_a_full_turn_is_wrong_by_one_to_two_degrees() -> None:
    errors = np.rad2deg(wrap(ends([(0.0, 2.0 * np.pi / 25)] * 25)[:, 2]))
    assert 1.0 < errors.std() < 2.0


def test_the_covariance_tells_how_far_it_errs() -> None:
    steps = [(0.25, 0.0)] * 20 + [(0.0, np.pi / 20)] * 10 + [(0.25, 0.0)] * 20
    stated = reckoned(WheelOdometryParams(), steps).covariance
    found = np.cov(ends(steps).T)
    assert np.sqrt(np.diag(stated)) == pytest.approx(np.sqrt(np.diag(found)), rel=0.5)
    assert stated == pytest.approx(stated.T)
    assert np.linalg.eigvalsh(stated).min() > 0.0


def test_how_often_the_wheels_are_read_does_not_matter_to_the_spread() -> None:
    coarse, fine = ends([(1.0, 0.0)] * 5), ends([(0.1, 0.0)] * 50)
    assert coarse[:, 2].std() == pytest.approx(fine[:, 2].std(), rel=0.2)


def test_two_robots_do_not_have_the_same_wheels() -> None:
    steps = [(0.1, 0.0)] * 50
    one, other = (reckoned(WheelOdometryParams(), steps, seed).pose for seed in (1, 2))
    assert one[0] != other[0]


def test_negative_errors_are_refused() -> None:
    with pytest.raises(ValueError, match="noise_of_rotation must not be negative"):
        WheelOdometryParams(noise_of_rotation=-0.1)
