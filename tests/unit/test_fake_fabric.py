"""The fabric of the tests keeps the promises of the real one."""

import pytest

from pilotage.bus.fabric import (
    NoAnswerError,
    NoAnswerInTimeError,
    Question,
    RefusedError,
    Sample,
)
from pilotage.bus.fake import FakeFabric

CBOR = "application/cbor;Odometry.v1"


def test_a_payload_reaches_whoever_subscribed_to_its_key() -> None:
    fabric, got = FakeFabric(), list[Sample]()
    fabric.declare_subscriber("a/b", "latest_wins", got.append)
    fabric.declare_publisher("a/b", CBOR, "latest_wins")(b"1")
    fabric.declare_publisher("a/c", CBOR, "latest_wins")(b"2")
    assert got == [Sample("a/b", b"1")]


def test_a_star_stands_for_any_service() -> None:
    fabric, got = FakeFabric(), list[Sample]()
    fabric.declare_subscriber("health/*", "latest_wins", got.append)
    fabric.declare_publisher("health/robot", CBOR, "latest_wins")(b"1")
    assert [sample.source for sample in got] == ["robot"]


def test_a_late_joiner_gets_the_last_of_what_must_not_drop() -> None:
    fabric, got = FakeFabric(), list[Sample]()
    put = fabric.declare_publisher("map", CBOR, "never_drop")
    put(b"old")
    put(b"new")
    fabric.declare_subscriber("map", "never_drop", got.append)
    assert [sample.payload for sample in got] == [b"new"]


def test_a_late_joiner_gets_nothing_of_a_stream() -> None:
    fabric, got = FakeFabric(), list[Sample]()
    fabric.declare_publisher("scan", CBOR, "latest_wins")(b"1")
    fabric.declare_subscriber("scan", "latest_wins", got.append)
    assert not got


def test_an_encoding_that_is_not_ours_is_refused() -> None:
    with pytest.raises(ValueError, match="text/plain"):
        FakeFabric().declare_publisher("a", "text/plain", "latest_wins")


def test_a_question_is_answered_while_the_asker_waits() -> None:
    fabric, asked = FakeFabric(), list[Question]()
    fabric.declare_queryable("q", asked.append)
    fabric.pump = lambda: asked.pop().reply(b"yes")
    assert fabric.ask("q", b"?", 1.0) == b"yes"


def test_a_refusal_is_raised_with_its_bytes() -> None:
    fabric = FakeFabric()
    fabric.declare_queryable("q", lambda question: question.refuse(b"no"))
    with pytest.raises(RefusedError) as refused:
        fabric.ask("q", b"?", 1.0)
    assert refused.value.args == (b"no",)


def test_nobody_there_is_told_from_no_answer_in_time() -> None:
    fabric = FakeFabric()
    with pytest.raises(NoAnswerError, match="not running"):
        fabric.ask("q", b"?", 1.0)
    fabric.declare_queryable("q", lambda _question: None)
    with pytest.raises(NoAnswerInTimeError, match="within 1 s"):
        fabric.ask("q", b"?", 1.0)


def test_presence_is_told_at_once_and_at_each_change() -> None:
    fabric, seen = FakeFabric(), list[tuple[str, bool]]()
    fabric.declare_presence("alive/robot")
    fabric.watch_presence("alive/*", lambda key, present: seen.append((key, present)))
    fabric.declare_presence("alive/mapper")
    fabric.withdraw("alive/robot")
    assert seen == [("alive/robot", True), ("alive/mapper", True), ("alive/robot", False)]


def test_a_closed_fabric_carries_nothing() -> None:
    fabric, got = FakeFabric(), list[Sample]()
    fabric.declare_subscriber("a", "latest_wins", got.append)
    fabric.close()
    fabric.declare_publisher("a", CBOR, "latest_wins")(b"1")
    assert not got
    assert fabric.is_connected()


def test_a_late_subscriber_gets_as_much_history_as_is_kept_and_asked_for() -> None:
    fabric = FakeFabric()
    put = fabric.declare_publisher("patch", CBOR, "never_drop", history=3)
    for number in range(5):
        put(b"%d" % number)
    all_kept: list[Sample] = []
    last: list[Sample] = []
    fabric.declare_subscriber("patch", "never_drop", all_kept.append, history=10)
    fabric.declare_subscriber("patch", "never_drop", last.append)
    assert [sample.payload for sample in all_kept] == [b"2", b"3", b"4"]
    assert [sample.payload for sample in last] == [b"4"]
