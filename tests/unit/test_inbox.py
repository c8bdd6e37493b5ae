"""The queue between threads, and the wake-up call."""

import signal
import threading
from collections.abc import Iterator

import pytest

from pilotage.bus.inbox import Inbox, Wake
from waiting import eventually


def test_items_come_out_in_order() -> None:
    inbox: Inbox[str] = Inbox(3)
    for arrival, item in enumerate("abc"):
        inbox.put(arrival, item)
    assert [inbox.take() for _ in range(3)] == ["a", "b", "c"]


def test_the_oldest_arrival_is_known_without_taking_it() -> None:
    inbox: Inbox[str] = Inbox(3)
    assert inbox.oldest() is None
    inbox.put(7, "a")
    inbox.put(9, "b")
    assert inbox.oldest() == 7


def test_the_oldest_makes_room_and_is_counted_once() -> None:
    inbox: Inbox[int] = Inbox(2)
    for item in range(5):
        inbox.put(item, item)
    assert inbox.lost() == 3
    assert inbox.lost() == 0
    assert [inbox.take(), inbox.take()] == [3, 4]


def test_a_queue_without_room_is_refused() -> None:
    with pytest.raises(ValueError, match="depth 0"):
        Inbox(0)


def test_nothing_gets_lost_uncounted_between_many_threads() -> None:
    inbox: Inbox[int] = Inbox(1)
    taken = lost = 0

    def pour() -> None:
        for number in range(2000):
            inbox.put(number, number)

    threads = [threading.Thread(target=pour) for _ in range(4)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads) or inbox.oldest() is not None:
        if inbox.oldest() is not None:
            inbox.take()
            taken += 1
        lost += inbox.lost()
    assert taken + lost == 4 * 2000


def test_a_call_wakes_the_sleeper() -> None:
    wake = Wake()
    threading.Thread(target=wake.call).start()
    assert wake.wait(5.0)


def test_a_call_before_the_sleep_is_kept_but_not_twice() -> None:
    wake = Wake()
    wake.call()
    wake.call()
    assert wake.wait(0.0)
    assert not wake.wait(0.0)


def test_without_a_call_the_sleep_ends_by_itself() -> None:
    assert not Wake().wait(0.001)


@pytest.fixture
def alarm() -> Iterator[None]:
    before = signal.getsignal(signal.SIGALRM)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.usefixtures("alarm")
def test_a_signal_handler_may_call_at_any_moment() -> None:
    wake = Wake()
    calls = 0

    def call(*_: object) -> None:
        nonlocal calls
        calls += 1
        wake.call()

    def waited() -> bool:
        wake.wait(0.0002)
        return calls > 300

    signal.signal(signal.SIGALRM, call)
    signal.setitimer(signal.ITIMER_REAL, 0.0003, 0.0003)
    eventually(waited, within=20.0)
