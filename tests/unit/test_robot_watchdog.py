"""Limits, and who has fallen silent."""

import pytest

from pilotage.robot.watchdog import CommandWatch, Limits, SensorWatch

LIMITS = Limits(linear=0.5, angular=1.0, acceleration=1.0, angular_acceleration=2.0)


@pytest.mark.parametrize(
    ("wanted", "present", "given"),
    [
        ((9.0, 0.0), (0.0, 0.0), (0.1, 0.0)),
        ((9.0, 9.0), (0.5, 1.0), (0.5, 1.0)),
        ((-9.0, -9.0), (-0.5, -1.0), (-0.5, -1.0)),
        ((0.0, 0.0), (0.5, 1.0), (0.0, 0.0)),
        ((0.2, 0.3), (0.5, 1.0), (0.2, 0.3)),
        ((-0.5, 0.0), (0.5, 0.0), (-0.1, 0.0)),
        ((0.05, -0.1), (0.0, 0.0), (0.05, -0.1)),
    ],
)
def test_speeds_grow_slowly_and_fall_at_once(
    wanted: tuple[float, float], present: tuple[float, float], given: tuple[float, float]
) -> None:
    assert LIMITS.applied(wanted, present, 0.1) == pytest.approx(given)


def test_whoever_has_said_nothing_yet_is_silent() -> None:
    assert CommandWatch().is_silent(0.0)


def test_a_command_holds_for_half_a_second() -> None:
    watch = CommandWatch(0.5)
    watch.feed(10.0)
    assert not watch.is_silent(10.499)
    assert watch.is_silent(10.5)
    watch.feed(10.6)
    assert not watch.is_silent(11.0)


def test_the_silent_sensor_is_named() -> None:
    watch = SensorWatch({"odometry": 0.5, "scan": 1.0})
    watch.hear("odometry", 10.0)
    watch.hear("scan", 10.0)
    both = ("odometry", "scan")
    assert watch.silent(both, 10.4) is None
    assert watch.silent(both, 10.6) == "odometry"
    watch.hear("odometry", 10.9)
    assert watch.silent(both, 11.1) == "scan"
    assert watch.silent(("odometry",), 11.1) is None


def test_a_sensor_that_never_spoke_is_silent() -> None:
    assert SensorWatch({"scan": 1.0}).silent(("scan",), 0.0) == "scan"
