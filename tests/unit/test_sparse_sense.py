"""What odometry can tell: steps worth a scan, and whether it knows back from ahead."""

import numpy as np
import pytest

from pilotage.mapper.odometry_sense import OdometrySense, OdometryStep, SenseParams

PARAMS = SenseParams()


def told(*ahead: float, period: float = 0.2) -> list[OdometryStep | None]:
    """The steps of a robot that odometry says went so many m straight on between scans."""
    return driven(OdometrySense(PARAMS), *ahead, period=period)


def driven(sense: OdometrySense, *ahead: float, period: float = 0.2) -> list[OdometryStep | None]:
    ways = np.cumsum([0.0, *ahead])
    return [sense.step(period * k, np.array([way, 0.0, 0.0])) for k, way in enumerate(ways)]


def steps(found: list[OdometryStep | None]) -> list[float]:
    return [float(step.increment[0]) for step in found if step is not None]


def test_the_first_scan_is_a_step_of_nothing() -> None:
    (first,) = told()
    assert first is not None
    assert not first.increment.any()


def test_who_stands_makes_no_steps() -> None:
    assert told(0.0, 0.001, 0.0)[1:] == [None, None, None]


def test_small_ways_add_up_to_a_step() -> None:
    assert steps(told(0.02, 0.01, 0.02, 0.1)) == pytest.approx([0.0, 0.05, 0.1])


def test_a_turn_on_the_spot_is_a_step() -> None:
    sense = OdometrySense(PARAMS)
    sense.step(0.0, np.zeros(3))
    step = sense.step(0.2, np.array([0.0, 0.0, 0.1]))
    assert step is not None
    assert step.increment.tolist() == pytest.approx([0.0, 0.0, 0.1])


def test_turning_back_is_likely_after_a_stop_only() -> None:
    *_, before, _, after = told(0.1, 0.1, 0.001, 0.1)
    assert before is not None
    assert after is not None
    assert (before.back, before.ahead) == PARAMS.without_stop
    assert (after.back, after.ahead) == PARAMS.after_stop


def test_a_stop_is_forgotten_after_the_next_step() -> None:
    last = told(0.1, 0.001, 0.1, 0.1)[-1]
    assert last is not None
    assert (last.back, last.ahead) == PARAMS.without_stop


def test_a_slow_drive_between_rare_scans_is_no_stop() -> None:
    last = told(0.3, 0.3, period=1.0)[-1]
    assert last is not None
    assert last.back == PARAMS.without_stop[0]


def test_odometry_that_told_of_a_way_back_knows_its_sign() -> None:
    sense = OdometrySense(PARAMS)
    *_, last = driven(sense, 0.1, -0.05, 0.001, 0.1)
    assert sense.is_signed
    assert last is not None
    assert (last.back, last.ahead) == (0.0, 1.0)


def test_what_is_known_of_the_sign_is_kept() -> None:
    sense = OdometrySense(PARAMS)
    sense.go_on(5.0, np.array([1.0, 0.0, 0.0]), is_signed=True)
    step = sense.step(5.2, np.array([1.1, 0.0, 0.0]))
    assert step is not None
    assert step.increment.tolist() == pytest.approx([0.1, 0.0, 0.0])
    assert step.back == 0.0
