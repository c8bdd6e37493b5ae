"""Wheels that need time to gain speed, brake hard, and slip now and then."""

import numpy as np
import pytest

from pilotage.robot.simulator.drive import (
    DriveParams,
    SlipParams,
    Wheels,
    accelerated,
    ground_twist,
    slipped,
)

DRIVE = DriveParams(max_linear=1.0, max_angular=2.0, acceleration=1.0, braking=10.0)
RNG = np.random.default_rng(7)


def driven(wheels: Wheels, wanted: tuple[float, float], seconds: float) -> Wheels:
    for _ in range(round(seconds / 0.01)):
        wheels = accelerated(wheels, wanted, DRIVE, 0.01)
    return wheels


def test_speed_grows_by_the_acceleration() -> None:
    assert driven(Wheels(), (0.8, 0.0), 0.5).linear == pytest.approx(0.5)


def test_speed_stays_at_what_is_wanted() -> None:
    assert driven(Wheels(), (0.8, -0.4), 2.0) == Wheels(linear=0.8, angular=-0.4)


def test_nothing_goes_faster_than_the_drive_can() -> None:
    wheels = driven(Wheels(), (9.0, -9.0), 5.0)
    assert (wheels.linear, wheels.angular) == pytest.approx((1.0, -2.0))


def test_full_speed_is_braked_within_a_tenth_of_a_second() -> None:
    wheels = driven(Wheels(linear=1.0, angular=2.0), (0.0, 0.0), 0.1)
    assert (wheels.linear, wheels.angular) == pytest.approx((0.0, 0.0))


def test_turning_back_begins_with_braking() -> None:
    wheels = accelerated(Wheels(linear=0.5), (-0.5, 0.0), DRIVE, 0.01)
    assert wheels.linear == pytest.approx(0.4)
    assert driven(Wheels(linear=0.05), (-0.5, 0.0), 0.02).linear == pytest.approx(-0.01)


def test_wheels_that_stand_do_not_slip() -> None:
    slippery = SlipParams(rate=1e9)
    assert slipped(Wheels(angular=1.0), slippery, 0.01, RNG) == Wheels(angular=1.0)


def test_slips_come_as_often_per_metre_as_stated() -> None:
    params = SlipParams(rate=0.5, duration=0.01)
    begun = sum(slipped(Wheels(linear=1.0), params, 0.01, RNG).slip_left > 0 for _ in range(40_000))
    assert begun / 400.0 == pytest.approx(0.5, rel=0.2)


def test_a_slip_ends_after_its_duration() -> None:
    wheels = Wheels(linear=1.0, slip_left=0.05)
    for _ in range(5):
        assert wheels.slip_left > 0.0
        wheels = slipped(wheels, SlipParams(rate=0.0), 0.01, RNG)
    assert wheels.slip_left == pytest.approx(0.0)


def test_a_slipping_robot_is_slower_than_its_wheels_and_turns() -> None:
    wheels = Wheels(linear=1.0, slip_left=0.1, slip_yaw_rate=0.2)
    assert ground_twist(wheels, SlipParams(share=0.4)) == pytest.approx((0.6, 0.2))
    assert ground_twist(Wheels(linear=1.0, slip_yaw_rate=0.2), SlipParams()) == (1.0, 0.0)


@pytest.mark.parametrize(
    "wrong", [{"radius": 0.0}, {"max_linear": -1.0}, {"acceleration": 0.0}, {"braking": 0.0}]
)
def test_a_chassis_that_cannot_be_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        DriveParams(**wrong)


def test_more_than_everything_cannot_be_lost_to_a_slip() -> None:
    with pytest.raises(ValueError, match="share must be 1 at most"):
        SlipParams(share=1.1)
