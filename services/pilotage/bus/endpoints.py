"""Typed ends of the bus: publishers that number their messages, inlets that check them."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, Literal, TypeVar

from pilotage.bus.fabric import Question, RefusedError, Sample
from pilotage_schemas.codec import DecodeError, decode, encode
from pilotage_schemas.commands import Refused
from pilotage_schemas.message import Message, Part
from pilotage_schemas.topics import Query, Topic

Sent = TypeVar("Sent", bound=Message)

REORDER_WINDOW = 100
"""A `seq` this little below the newest is a late sample; one further below, a new publisher."""

STALE_FLOOR_S = 5.0
"""A sensor sample older than this (and than ten times its topic's limit) is of no use."""


@dataclass
class Traffic:
    """Counts of one topic in one direction since the service started."""

    topic: Topic
    direction: Literal["in", "out"]
    count: int = 0
    dropped: int = 0
    last_stamp_ns: int | None = None


class Publisher(Generic[Sent]):
    """Publishes messages of one topic, each with the next `seq`."""

    def __init__(self, put: Callable[[bytes], None], traffic: Traffic) -> None:
        self._put = put
        self.traffic = traffic

    def publish(self, message: Sent) -> None:
        """Send the message; its `seq` is set here."""
        expected = self.traffic.topic.message
        if not isinstance(message, expected):
            raise TypeError(f"{self.traffic.topic.name} carries {expected.__name__}")
        numbered = message.model_copy(update={"seq": self.traffic.count})
        self._put(encode(numbered))
        self.traffic.count += 1
        self.traffic.last_stamp_ns = message.stamp_ns


class RejectedError(ValueError):
    """A sample that must not reach its handler; the text says why."""


@dataclass
class Inlet:
    """What comes in by one topic: bounded, checked, counted."""

    traffic: Traffic
    handler: Callable[[Any, Sample], None]
    depth: int
    pending: deque[tuple[int, Sample]] = field(default_factory=deque)
    newest: dict[str, tuple[int, int]] = field(default_factory=dict)

    def enqueue(self, arrival: int, sample: Sample) -> None:
        """Keep the newest `depth` samples; of streams the older ones make room."""
        self.pending.append((arrival, sample))
        if len(self.pending) > self.depth:
            self.pending.popleft()

    def admit(self, sample: Sample, now_ns: int) -> Message:
        """Return the message, or raise RejectedError: malformed, stale or out of order."""
        try:
            message = decode(self.traffic.topic.message, sample.payload)
        except DecodeError as error:
            raise RejectedError(str(error)) from error
        self._check_age(message, now_ns)
        self._check_order(message, sample.key)
        self.newest[sample.key] = (message.seq, message.stamp_ns)
        self.traffic.last_stamp_ns = message.stamp_ns
        return message

    def _check_age(self, message: Message, now_ns: int) -> None:
        limit = self.traffic.topic.stale_after
        if limit is None:
            return
        age = (now_ns - message.stamp_ns) / 1e9
        if age > max(STALE_FLOOR_S, 10.0 * limit):
            raise RejectedError(f"stale: {age:.1f} s old (are the clocks in step?)")

    def _check_order(self, message: Message, key: str) -> None:
        seq, stamp_ns = self.newest.get(key, (-1, -1))
        is_late = 0 <= seq - message.seq < REORDER_WINDOW
        if is_late and message.stamp_ns <= stamp_ns:
            raise RejectedError(f"out of order: number {message.seq} after {seq}")


@dataclass
class Desk:
    """Where one query is answered."""

    query: Query
    handler: Callable[[Any], Part]
    pending: deque[tuple[int, Question]] = field(default_factory=deque)

    def answer(self, question: Question) -> None:
        """Reply with what the handler returns, or with its refusal."""
        try:
            request = decode(self.query.request, question.payload)
            reply = self.handler(request)
        except (DecodeError, RefusedError) as error:
            question.refuse(refusal(str(error)))
        except Exception:
            question.refuse(refusal("the service failed while carrying it out"))
            raise
        else:
            question.reply(encode(reply))


def refusal(reason: str) -> bytes:
    """Return the wire form of a refusal."""
    return encode(Refused(reason=reason[:2000]))


def reason_of(error: RefusedError) -> str:
    """Return the reason that a refusal from the wire carries."""
    raw = error.args[0]
    try:
        return decode(Refused, raw).reason if isinstance(raw, bytes) else str(raw)
    except DecodeError:
        return "refused without a readable reason"
