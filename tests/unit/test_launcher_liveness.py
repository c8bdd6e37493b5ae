"""Liveness: what heartbeats say, and what their absence says."""

import pytest

from pilotage.launcher.liveness import Liveness


@pytest.fixture
def liveness() -> Liveness:
    """A process that started at 100 s, with 60 s to its first beat and 2 s of grace."""
    return Liveness(last=100.0, within=60.0, hang_grace=2.0)


def test_a_process_that_starts_has_its_start_limit(liveness: Liveness) -> None:
    assert not liveness.is_ready
    assert not liveness.is_late(159.9)
    assert liveness.is_late(160.0)
    assert not liveness.is_hung(161.9)
    assert liveness.is_hung(162.0)


def test_a_beat_that_says_ready_makes_it_ready(liveness: Liveness) -> None:
    liveness.beat("starting", 60.0, 100.5)
    assert not liveness.is_ready
    liveness.beat("ready", 1.0, 101.0)
    assert liveness.is_ready


def test_four_missed_beats_are_late_after_one_second(liveness: Liveness) -> None:
    liveness.beat("ready", 1.0, 101.0)
    assert not liveness.is_late(101.99)
    assert liveness.is_late(102.0)
    assert liveness.silent_for(102.5) == 1.5


def test_a_late_process_that_beats_again_is_not_late(liveness: Liveness) -> None:
    liveness.beat("ready", 1.0, 101.0)
    assert liveness.is_late(102.5)
    liveness.beat("ready", 1.0, 102.6)
    assert not liveness.is_late(103.0)


def test_busy_work_has_the_time_it_asked_for(liveness: Liveness) -> None:
    liveness.beat("ready", 1.0, 101.0)
    liveness.beat("busy", 30.0, 101.2)
    assert liveness.is_ready
    assert not liveness.is_late(131.0)
    assert liveness.is_late(131.3)


def test_busy_work_before_ready_does_not_make_ready(liveness: Liveness) -> None:
    liveness.beat("busy", 30.0, 101.0)
    assert not liveness.is_ready


def test_a_service_that_starts_over_is_not_ready(liveness: Liveness) -> None:
    liveness.beat("ready", 1.0, 101.0)
    liveness.beat("starting", 60.0, 101.5)
    assert not liveness.is_ready


def test_beats_that_cannot_arrive_are_excused(liveness: Liveness) -> None:
    liveness.beat("ready", 1.0, 101.0)
    liveness.excuse(110.0)
    assert not liveness.is_late(109.9)
    assert liveness.is_late(110.0)
    assert liveness.is_hung(112.0)


def test_an_excuse_never_shortens_an_earlier_one(liveness: Liveness) -> None:
    liveness.beat("ready", 1.0, 101.0)
    liveness.excuse(110.0)
    liveness.excuse(105.0)
    assert not liveness.is_late(109.0)
