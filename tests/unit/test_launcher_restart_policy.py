"""The restart policy: patience that doubles, and an end of patience."""

import pytest

from pilotage.launcher.restart_policy import RestartHistory, RestartPolicy


@pytest.fixture
def history() -> RestartHistory:
    return RestartHistory(RestartPolicy())


def test_the_wait_doubles_after_each_failure(history: RestartHistory) -> None:
    assert [history.fail(now) for now in (0.0, 1.0, 2.0, 3.0)] == [0.2, 0.4, 0.8, 1.6]


def test_the_fifth_failure_within_a_minute_is_the_last(history: RestartHistory) -> None:
    delays = [history.fail(now) for now in (0.0, 10.0, 20.0, 30.0, 59.9)]
    assert delays[-1] is None
    assert None not in delays[:-1]


def test_failures_that_lie_a_minute_back_do_not_count(history: RestartHistory) -> None:
    for now in (0.0, 10.0, 20.0, 30.0):
        history.fail(now)
    assert history.fail(60.0) is not None
    assert history.count(60.0) == 4


def test_the_wait_never_exceeds_ten_seconds(history: RestartHistory) -> None:
    delays = [history.fail(20.0 * number) for number in range(12)]
    assert delays[-1] == 10.0


def test_a_minute_without_a_failure_begins_anew(history: RestartHistory) -> None:
    for now in (0.0, 1.0, 2.0):
        history.fail(now)
    assert history.count(70.0) == 0
    assert history.fail(70.0) == 0.2


def test_a_start_that_was_asked_for_begins_anew(history: RestartHistory) -> None:
    for now in (0.0, 1.0, 2.0, 3.0):
        history.fail(now)
    history.forget()
    assert history.count(4.0) == 0
    assert history.fail(4.0) == 0.2


def test_a_policy_of_one_failure_never_restarts() -> None:
    assert RestartHistory(RestartPolicy(max_failures=1)).fail(0.0) is None
