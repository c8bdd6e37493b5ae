"""Typed ends of the bus: publishers that number their messages, inlets that check them."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Generic, Literal, Protocol, TypeVar

from pilotage.bus.clock import Clock
from pilotage.bus.fabric import Question, RefusedError, Sample
from pilotage.bus.inbox import Inbox
from pilotage_schemas.codec import DecodeError, decode, encode
from pilotage_schemas.commands import Refused
from pilotage_schemas.message import Message, Part
from pilotage_schemas.topics import Query, Topic

Sent = TypeVar("Sent", bound=Message)

REORDER_WINDOW = 100
"""A `seq` this little below the newest is a late sample; one further below, a new publisher."""

MAX_SENDERS = 1000
"""Keys of one topic whose newest sample is remembered; the longest known is forgotten first."""

MAX_QUESTIONS = 100

BEGIN_SHARE = 0.75
"""Share of a query's time limit within which it must be begun, or not at all: the asker's clock
started earlier, and a command that he has given up must not be carried out behind his back."""

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
    is_resting: bool = False
    """Whether another service publishes it at present, so that silence here is well."""


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
        if self.traffic.is_resting:
            raise ValueError(f"{self.traffic.topic.name} is another service's at present")
        numbered = message.model_copy(update={"seq": self.traffic.count})
        self._put(encode(numbered))
        self.traffic.count += 1
        self.traffic.last_stamp_ns = message.stamp_ns

    def rest(self, *, is_resting: bool) -> None:
        """Say whether the topic is another service's at present; nothing may be sent then."""
        self.traffic.is_resting = is_resting


class RejectedError(ValueError):
    """Something that must not reach its handler: where it came from, and why not."""

    def __init__(self, source: str, reason: str) -> None:
        super().__init__(reason)
        self.source = source


class Source(Protocol):
    """Where work for the loop comes from."""

    inbox: Inbox[Any]

    def handle_next(self, clock: Clock) -> None:
        """Do the oldest piece of work; RejectedError when it is no good."""
        ...


@dataclass
class Calls:
    """Functions to be called by the loop."""

    inbox: Inbox[Callable[[], None]]

    def handle_next(self, _clock: Clock) -> None:
        """Call the oldest."""
        self.inbox.take()()


@dataclass
class Inlet:
    """What comes in by one topic: bounded, checked, counted."""

    traffic: Traffic
    handler: Callable[[Any, Sample], None]
    inbox: Inbox[Sample]
    newest: dict[str, tuple[int, int]] = field(default_factory=dict)

    def handle_next(self, clock: Clock) -> None:
        """Hand the oldest message to the handler; count it, and whether it was no good.

        The handler too may raise RejectedError: what it cannot use is dropped alike.
        """
        self._count_lost(self.inbox.lost())
        sample = self.inbox.take()
        self.traffic.count += 1
        try:
            self.handler(self.admit(sample, clock.now_ns()), sample)
        except RejectedError:
            self.traffic.dropped += 1
            raise

    def admit(self, sample: Sample, now_ns: int) -> Message:
        """Return the message, or raise RejectedError: malformed, stale or out of order."""
        try:
            message = decode(self.traffic.topic.message, sample.payload)
        except DecodeError as error:
            raise RejectedError(sample.source, str(error)) from error
        reason = self._too_old(message, now_ns) or self._out_of_order(message, sample.key)
        if reason is not None:
            raise RejectedError(sample.source, reason)
        self._remember(sample.key, message)
        return message

    def _too_old(self, message: Message, now_ns: int) -> str | None:
        limit = self.traffic.topic.stale_after
        age = (now_ns - message.stamp_ns) / 1e9
        if limit is None or age <= max(STALE_FLOOR_S, 10.0 * limit):
            return None
        return f"stale: {age:.1f} s old (are the clocks in step?)"

    def _out_of_order(self, message: Message, key: str) -> str | None:
        seq, stamp_ns = self.newest.get(key, (-1, -1))
        is_late = 0 <= seq - message.seq < REORDER_WINDOW and message.stamp_ns <= stamp_ns
        return f"out of order: number {message.seq} after {seq}" if is_late else None

    def _remember(self, key: str, message: Message) -> None:
        if key not in self.newest and len(self.newest) >= MAX_SENDERS:
            del self.newest[next(iter(self.newest))]
        self.newest[key] = (message.seq, message.stamp_ns)
        self.traffic.last_stamp_ns = message.stamp_ns

    def _count_lost(self, lost: int) -> None:
        """Count samples that had to make room; only of events are they a loss."""
        self.traffic.count += lost
        if self.traffic.topic.delivery == "never_drop":
            self.traffic.dropped += lost


@dataclass(frozen=True)
class Asked:
    """A question and when it came, in the clock's monotonic seconds."""

    question: Question
    at: float


@dataclass
class Desk:
    """Where one query is answered."""

    query: Query
    handler: Callable[[Any], Part]
    inbox: Inbox[Asked] = field(default_factory=lambda: Inbox(MAX_QUESTIONS))

    def handle_next(self, clock: Clock) -> None:
        """Answer the oldest question, unless whoever asked has given up by now."""
        asked = self.inbox.take()
        if clock.monotonic() - asked.at > BEGIN_SHARE * self.query.timeout_s:
            asked.question.refuse(refusal("the service was too busy to begin in time"))
            raise RejectedError(self.query.name, "nobody waits for its answer any more")
        self.answer(asked.question)

    def answer(self, question: Question) -> None:
        """Reply with what the handler returns, or with its refusal."""
        try:
            request = decode(self.query.request, question.payload)
            reply = self.handler(request)
        except DecodeError as error:
            question.refuse(refusal(str(error)))
            raise RejectedError(self.query.name, str(error)) from error
        except RefusedError as error:
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
