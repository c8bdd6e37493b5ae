"""A service's place on the bus and the one loop that owns its state.

Callbacks of the fabric only enqueue; `step` hands everything to the handlers, in order of
arrival, on the caller's thread. So handlers need no locks, and tests need no threads.
"""

import contextlib
import itertools
import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

from pilotage.bus.clock import Clock
from pilotage.bus.endpoints import (
    Asked,
    Calls,
    Desk,
    Inlet,
    Publisher,
    RejectedError,
    Source,
    reason_of,
)
from pilotage.bus.fabric import BusError, Fabric, Question, RefusedError, Sample
from pilotage.bus.inbox import Inbox, Wake
from pilotage.bus.vitals import Vitals
from pilotage_schemas.codec import DecodeError, decode, encode
from pilotage_schemas.health import Heartbeat
from pilotage_schemas.message import Part
from pilotage_schemas.topics import (
    EVERYONE,
    QUERIES,
    TOPICS,
    encoding,
    presence_key,
    query_key,
    topic_key,
)

HEARTBEAT_S = 0.25
BEATS_MISSED = 4
BEAT_LIMIT_S = HEARTBEAT_S * BEATS_MISSED
STARTING_LIMIT_S = 60.0
HEALTH_S = 1.0
STREAM_DEPTH = 16
EVENT_DEPTH = 1000
CALL_DEPTH = 1000
WARN_EVERY_S = 60.0
MAX_WARNED = 1000


@dataclass
class Timer:
    """A handler that is due every `period` seconds."""

    period: float
    handler: Callable[[], None]
    due: float


class Node:
    """The service `name` of `robot` on a fabric."""

    def __init__(self, name: str, robot: str, fabric: Fabric, clock: Clock) -> None:
        self.name = name
        self.robot = robot
        self.clock = clock
        self.fabric = fabric
        self.on_arrival: Callable[[], None] = lambda: None
        self.log = logging.getLogger(f"pilotage.{name}")
        self._state: Literal["starting", "ready", "busy"] = "starting"
        self._arrivals = itertools.count()
        self._calls = Calls(Inbox(CALL_DEPTH))
        self._sources: list[Source] = [self._calls]
        self._timers: list[Timer] = []
        self._when_idle: list[Callable[[], None]] = []
        self._publishers: dict[str, Publisher[Any]] = {}
        self._warned: dict[str, float] = {}
        self._wake = Wake()
        self._stopping = False
        self.vitals = Vitals(name, clock)
        self._heartbeat: Publisher[Heartbeat] = self.publisher("heartbeat")
        self._health = self.publisher("health")
        self._beat(STARTING_LIMIT_S)

    def publisher(self, topic_name: str) -> Publisher[Any]:
        """Return the publisher of a topic that this service owns, or publishes while mapping."""
        if topic_name not in self._publishers:
            topic = TOPICS[topic_name]
            if not {self.name, EVERYONE} & set(topic.publishers):
                raise ValueError(f"{topic_name} belongs to {topic.owner}, not to {self.name}")
            key = topic_key(self.robot, topic, self.name)
            put = self.fabric.declare_publisher(
                key, encoding(topic.message), topic.delivery, topic.history
            )
            traffic = self.vitals.traffic(topic, "out")
            self._publishers[topic_name] = Publisher(put, traffic)
        return self._publishers[topic_name]

    def subscribe(
        self, topic_name: str, handler: Callable[[Any], None], depth: int | None = None
    ) -> None:
        """Hand each message of a topic to `handler`.

        A stream keeps its newest `depth` samples while the service is busy; a topic that must
        not drop keeps them all (up to 1000).
        """
        self.subscribe_samples(topic_name, lambda message, _sample: handler(message), depth)

    def subscribe_samples(
        self, topic_name: str, handler: Callable[[Any, Sample], None], depth: int | None = None
    ) -> None:
        """Subscribe, handing `handler` the bytes and the key of each message with it."""
        topic = TOPICS[topic_name]
        default = STREAM_DEPTH if topic.delivery == "latest_wins" else EVENT_DEPTH
        inlet = Inlet(self.vitals.traffic(topic, "in"), handler, Inbox(depth or default))
        self._sources.append(inlet)
        key = topic_key(self.robot, topic, "*")

        def enqueue(sample: Sample) -> None:
            inlet.inbox.put(next(self._arrivals), sample)
            self._notify()

        self.fabric.declare_subscriber(key, topic.delivery, enqueue, topic.history)

    def answer(self, query_name: str, handler: Callable[[Any], Part]) -> None:
        """Answer a query with what `handler(request)` returns; RefusedError(reason) refuses."""
        query = QUERIES[query_name]
        if query.service != self.name:
            raise ValueError(f"{query_name} belongs to {query.service}, not to {self.name}")
        desk = Desk(query, handler)
        self._sources.append(desk)

        def enqueue(question: Question) -> None:
            asked = Asked(question, self.clock.monotonic())
            desk.inbox.put(next(self._arrivals), asked)
            self._notify()

        self.fabric.declare_queryable(query_key(self.robot, query), enqueue)

    def ask(self, query_name: str, request: Part) -> Part:
        """Return the reply of another service; NoAnswerError, or RefusedError with its reason.

        Blocks for at most the query's time limit: never call it from a handler of the loop.
        """
        query = QUERIES[query_name]
        if not isinstance(request, query.request):
            raise TypeError(f"{query_name} takes {query.request.__name__}")
        try:
            payload = self.fabric.ask(
                query_key(self.robot, query), encode(request), query.timeout_s
            )
        except RefusedError as error:
            raise RefusedError(reason_of(error)) from error
        try:
            return decode(query.reply, payload)
        except DecodeError as error:
            raise BusError(f"{query_name} was answered with something else: {error}") from error

    def every(self, period: float, handler: Callable[[], None]) -> None:
        """Call `handler` every `period` seconds, from now on."""
        self._timers.append(Timer(period, handler, self.clock.monotonic() + period))

    def when_idle(self, handler: Callable[[], None]) -> None:
        """Call `handler` whenever all that had come has been handled.

        The place for what is worth saying only of the newest: after long work much has come.
        """
        self._when_idle.append(handler)

    def watch_presence(self, handler: Callable[[str, bool], None]) -> None:
        """Tell `handler(service, is_present)` of every service that comes or goes."""

        def enqueue(key: str, present: bool) -> None:  # noqa: FBT001 - the fabric's signature
            service = key.rsplit("/", 1)[-1]
            self._calls.inbox.put(next(self._arrivals), lambda: handler(service, present))
            self._notify()

        self.fabric.watch_presence(presence_key(self.robot, "*"), enqueue)

    def ready(self) -> None:
        """Say that the service does its work from now on."""
        self.fabric.declare_presence(presence_key(self.robot, self.name))
        self._state = "ready"
        self._beat(BEAT_LIMIT_S)
        self.every(HEARTBEAT_S, lambda: self._beat(BEAT_LIMIT_S))
        self.every(HEALTH_S, lambda: self._health.publish(self.vitals.report()))

    @contextlib.contextmanager
    def busy(self, within: float) -> Iterator[None]:
        """Announce work that may hold the loop up to `within` seconds."""
        state, self._state = self._state, "busy"
        self._beat(within)
        try:
            yield
        finally:
            self._state = state
            self._beat(BEAT_LIMIT_S if state == "ready" else STARTING_LIMIT_S)

    def step(self) -> float:
        """Handle all that has come and all that is due; return seconds until the next timer."""
        while not self._stopping and self._handle_oldest():
            self._run_due_timers()
        self._run_due_timers()
        for handler in self._when_idle:
            handler()
        now = self.clock.monotonic()
        return max(0.0, min((timer.due - now for timer in self._timers), default=HEARTBEAT_S))

    def run(self) -> None:
        """Step until `stop`."""
        self.on_arrival = self._wake.call
        while not self._stopping:
            self._wake.wait(self.step())

    def stop(self) -> None:
        """Let `run` return after the present handler; may be called from anywhere."""
        self._stopping = True
        self._wake.call()

    @property
    def is_stopping(self) -> bool:
        """Whether `stop` has been called."""
        return self._stopping

    def warn(self, source: str, text: str) -> None:
        """Log a warning, once per source and minute."""
        self.vitals.last_error = f"{source}: {text}"
        now = self.clock.monotonic()
        if now - self._warned.get(source, -WARN_EVERY_S) >= WARN_EVERY_S:
            if len(self._warned) >= MAX_WARNED:
                self._warned.clear()
            self._warned[source] = now
            self.log.warning("%s: %s", source, text)

    def _notify(self) -> None:
        self.on_arrival()

    def _handle_oldest(self) -> bool:
        arrivals = ((source.inbox.oldest(), source) for source in self._sources)
        waiting = [(arrival, source) for arrival, source in arrivals if arrival is not None]
        if not waiting:
            return False
        _, source = min(waiting, key=lambda entry: entry[0])
        try:
            source.handle_next(self.clock)
        except RejectedError as error:
            self.vitals.bad_questions += isinstance(source, Desk)
            self.warn(error.source, f"dropped: {error}")
        return True

    def _run_due_timers(self) -> None:
        now = self.clock.monotonic()
        for timer in self._timers:
            if timer.due <= now:
                due = timer.due + timer.period
                timer.due = due if due > now else now + timer.period
                timer.handler()

    def _beat(self, within: float) -> None:
        self._heartbeat.publish(
            Heartbeat(
                stamp_ns=self.clock.now_ns(),
                frame_id="",
                service=self.name,
                state=self._state,
                within=within,
            )
        )
