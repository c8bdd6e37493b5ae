"""Odometry that goes on, and odometry that was counted anew."""

import numpy as np
import pytest

from pilotage.core.odometry_watch import OdometrySample, restart_between

BEFORE = OdometrySample(100, 5_000_000_000, np.array([1.0, 2.0, 0.3]))


def after(seconds: float, x: float = 1.0, seq: int = 101) -> OdometrySample:
    stamp_ns = BEFORE.stamp_ns + round(seconds * 1e9)
    return OdometrySample(seq, stamp_ns, np.array([x, 2.0, -3.0]))


@pytest.mark.parametrize(
    "now",
    [after(0.05), after(0.05, x=1.2), after(1.0, x=5.9), after(3600.0, x=900.0), after(0.0)],
    ids=["standing", "going", "fast", "after an hour", "the same"],
)
def test_what_a_robot_can_have_done_is_no_restart(now: OdometrySample) -> None:
    assert restart_between(BEFORE, now) is None


@pytest.mark.parametrize(
    "now",
    [after(0.05, x=1.3), after(1.0, x=6.1), after(-0.05), after(0.05, seq=99)],
    ids=["too far at once", "too fast", "earlier", "numbered anew"],
)
def test_what_no_robot_can_have_done_is_a_restart(now: OdometrySample) -> None:
    assert restart_between(BEFORE, now) is not None


def test_the_reason_names_way_and_time() -> None:
    assert restart_between(BEFORE, after(0.1, x=4.0)) == "jumped 3.00 m in 0.10 s: counting anew"
