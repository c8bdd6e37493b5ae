"""What comes in is checked and counted; what goes out is numbered."""

from collections.abc import Callable

import pytest

from pilotage.bus.clock import HandClock
from pilotage.bus.endpoints import (
    MAX_SENDERS,
    REORDER_WINDOW,
    Asked,
    Desk,
    Inlet,
    Publisher,
    RejectedError,
    Traffic,
    reason_of,
    refusal,
)
from pilotage.bus.fabric import Question, RefusedError, Sample
from pilotage.bus.inbox import Inbox
from pilotage_schemas.codec import decode, encode
from pilotage_schemas.commands import Done, Drive
from pilotage_schemas.message import Message, Part
from pilotage_schemas.sensors import Odometry
from pilotage_schemas.topics import QUERIES, TOPICS
from sample_messages import bumper, grid, odometry

SECOND = 1_000_000_000
CLOCK = HandClock()
NOW = CLOCK.now_ns()


def inlet(topic: str, got: list[Message] | None = None, depth: int = 10) -> Inlet:
    def handle(message: Message, _sample: Sample) -> None:
        if got is not None:
            got.append(message)

    return Inlet(Traffic(TOPICS[topic], "in"), handle, Inbox(depth))


def arrive(end: Inlet, message: Message, seq: int = 0, key: str = "odometry") -> None:
    payload = encode(message.model_copy(update={"seq": seq}))
    end.inbox.put(0, Sample(key, payload))
    end.handle_next(CLOCK)


def test_messages_are_numbered_as_they_go() -> None:
    sent: list[bytes] = []
    publisher: Publisher[Odometry] = Publisher(sent.append, Traffic(TOPICS["odometry"], "out"))
    for _ in range(3):
        publisher.publish(odometry(NOW))
    assert [decode(Odometry, payload).seq for payload in sent] == [0, 1, 2]
    assert (publisher.traffic.count, publisher.traffic.last_stamp_ns) == (3, NOW)


def test_a_publisher_takes_its_own_message_only() -> None:
    publisher: Publisher[Message] = Publisher(lambda _: None, Traffic(TOPICS["odometry"], "out"))
    with pytest.raises(TypeError, match="odometry carries Odometry"):
        publisher.publish(bumper(NOW))


def test_a_good_message_reaches_the_handler() -> None:
    got: list[Message] = []
    end = inlet("odometry", got)
    arrive(end, odometry(NOW))
    assert [message.stamp_ns for message in got] == [NOW]
    assert (end.traffic.count, end.traffic.dropped, end.traffic.last_stamp_ns) == (1, 0, NOW)


def test_a_malformed_message_is_counted_and_goes_no_further() -> None:
    got: list[Message] = []
    end = inlet("odometry", got)
    end.inbox.put(0, Sample("pilotage/@v1/demo/odometry", b"\xff"))
    with pytest.raises(RejectedError, match="not valid CBOR") as rejected:
        end.handle_next(CLOCK)
    assert rejected.value.source == "odometry"
    assert (got, end.traffic.count, end.traffic.dropped) == ([], 1, 1)
    assert end.traffic.last_stamp_ns is None


def test_an_old_sample_of_a_stream_is_stale() -> None:
    with pytest.raises(RejectedError, match=r"stale: 6\.0 s old"):
        arrive(inlet("odometry"), odometry(NOW - 6 * SECOND))


def test_a_slow_stream_may_be_older() -> None:
    end = inlet("odometry")
    arrive(end, odometry(NOW - 4 * SECOND))
    assert end.traffic.dropped == 0


def test_an_event_is_never_stale() -> None:
    end = inlet("bumper")
    arrive(end, bumper(1))
    assert end.traffic.dropped == 0


def test_stamps_may_run_ahead_of_the_clock_as_a_fast_replay_does() -> None:
    end = inlet("odometry")
    arrive(end, odometry(NOW + 3600 * SECOND))
    assert end.traffic.dropped == 0


def test_a_repeated_sample_is_out_of_order() -> None:
    end = inlet("odometry")
    arrive(end, odometry(NOW), seq=5)
    with pytest.raises(RejectedError, match="out of order: number 5 after 5"):
        arrive(end, odometry(NOW), seq=5)


def test_a_late_sample_is_out_of_order() -> None:
    end = inlet("odometry")
    arrive(end, odometry(NOW), seq=5)
    with pytest.raises(RejectedError, match="out of order: number 4 after 5"):
        arrive(end, odometry(NOW - SECOND), seq=4)
    assert end.traffic.dropped == 1


def test_a_restarted_publisher_begins_again_with_newer_stamps() -> None:
    end = inlet("odometry")
    arrive(end, odometry(NOW - SECOND), seq=5)
    arrive(end, odometry(NOW), seq=0)
    assert end.traffic.dropped == 0


def test_a_publisher_far_behind_is_a_new_one() -> None:
    end = inlet("odometry")
    arrive(end, odometry(NOW), seq=REORDER_WINDOW)
    arrive(end, odometry(NOW - SECOND), seq=0)
    assert end.traffic.dropped == 0


def test_a_forged_number_does_not_shut_out_the_honest_ones() -> None:
    end = inlet("odometry")
    arrive(end, odometry(NOW), seq=2**63 - 1)
    arrive(end, odometry(NOW), seq=6)
    assert end.traffic.dropped == 0


def test_two_publishers_do_not_mix_their_numbers() -> None:
    end = inlet("odometry")
    arrive(end, odometry(NOW), seq=5, key="health/robot")
    arrive(end, odometry(NOW), seq=5, key="health/mapper")
    assert end.traffic.dropped == 0


def test_endlessly_many_publishers_do_not_fill_the_memory() -> None:
    end = inlet("odometry")
    for number in range(MAX_SENDERS + 10):
        arrive(end, odometry(NOW), key=f"health/{number}")
    assert len(end.newest) == MAX_SENDERS


@pytest.mark.parametrize(("topic", "dropped"), [("odometry", 0), ("map", 3)])
def test_an_overrun_is_a_loss_for_events_only(topic: str, dropped: int) -> None:
    end = inlet(topic, depth=2)
    make: dict[str, Callable[[int], Message]] = {"odometry": odometry, "map": grid}
    for seq in range(5):
        message = make[topic](NOW).model_copy(update={"seq": seq})
        end.inbox.put(seq, Sample(topic, encode(message)))
    end.handle_next(CLOCK)
    assert (end.traffic.count, end.traffic.dropped) == (4, dropped)


class Asking:
    """One question to the desk of `forward`, and what becomes of it."""

    def __init__(self, handler: Callable[[Drive], Part]) -> None:
        self.replies: list[bytes] = []
        self.refusals: list[bytes] = []
        self.clock = HandClock()
        self.desk = Desk(QUERIES["forward"], handler)

    def ask(self, payload: bytes, waited: float = 0.0) -> None:
        question = Question(payload, self.replies.append, self.refusals.append)
        self.desk.inbox.put(0, Asked(question, self.clock.monotonic()))
        self.clock.advance(waited)
        self.desk.handle_next(self.clock)

    def refusal(self) -> str:
        [payload] = self.refusals
        return reason_of(RefusedError(payload))


DRIVE = encode(Drive(distance=1.0))


def test_a_question_is_answered() -> None:
    asking = Asking(lambda drive: Done(detail=f"{drive.distance:g} m"))
    asking.ask(DRIVE)
    [reply] = asking.replies
    assert decode(Done, reply).detail == "1 m"
    assert not asking.refusals


def test_a_malformed_question_is_refused_and_reported() -> None:
    asking = Asking(lambda _: Done())
    with pytest.raises(RejectedError, match="distance: Field required") as rejected:
        asking.ask(b"\xa0")
    assert rejected.value.source == "forward"
    assert "distance: Field required" in asking.refusal()


def test_a_refusal_carries_its_reason() -> None:
    def refuse(_: Drive) -> Part:
        raise RefusedError("a wall is in the way")

    asking = Asking(refuse)
    asking.ask(DRIVE)
    assert asking.refusal() == "a wall is in the way"


def test_an_error_in_the_service_is_loud_and_the_asker_is_told() -> None:
    def fail(_: Drive) -> Part:
        raise ZeroDivisionError

    asking = Asking(fail)
    with pytest.raises(ZeroDivisionError):
        asking.ask(DRIVE)
    assert asking.refusal() == "the service failed while carrying it out"


def test_a_command_nobody_waits_for_any_more_is_not_carried_out() -> None:
    done: list[Drive] = []

    def drive(request: Drive) -> Part:
        done.append(request)
        return Done()

    asking = Asking(drive)
    with pytest.raises(RejectedError, match="nobody waits for its answer"):
        asking.ask(DRIVE, waited=1.6)
    assert not done
    assert "too busy" in asking.refusal()


def test_a_command_that_waited_a_little_is_carried_out() -> None:
    asking = Asking(lambda _: Done())
    asking.ask(DRIVE, waited=1.4)
    assert asking.replies


def test_a_long_reason_is_cut_to_what_a_refusal_may_hold() -> None:
    assert len(reason_of(RefusedError(refusal("a" * 5000)))) == 2000


@pytest.mark.parametrize("raw", [b"", b"\xff", b"Query not found"])
def test_a_refusal_from_elsewhere_has_no_readable_reason(raw: bytes) -> None:
    assert reason_of(RefusedError(raw)) == "refused without a readable reason"


def test_a_reason_that_is_text_already_stays_so() -> None:
    assert reason_of(RefusedError("no")) == "no"
