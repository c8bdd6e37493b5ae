"""A service's place on the bus and the one loop that owns its state.

Callbacks of the fabric only enqueue; `step` hands everything to the handlers, in order of
arrival, on the caller's thread. So handlers need no locks, and tests need no threads.
"""

import contextlib
import itertools
import logging
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

from pilotage.bus.clock import Clock
from pilotage.bus.endpoints import (
    Desk,
    Inlet,
    Publisher,
    RejectedError,
    reason_of,
)
from pilotage.bus.fabric import Fabric, Question, RefusedError, Sample
from pilotage.bus.vitals import Vitals
from pilotage_schemas.codec import decode, encode
from pilotage_schemas.health import Heartbeat
from pilotage_schemas.message import Message, Part
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
WARN_EVERY_S = 60.0


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
        self._inlets: list[Inlet] = []
        self._desks: list[Desk] = []
        self._calls: deque[tuple[int, Callable[[], None]]] = deque()
        self._timers: list[Timer] = []
        self._publishers: dict[str, Publisher[Any]] = {}
        self._warned: dict[str, float] = {}
        self._wake = threading.Event()
        self._stopping = False
        self.vitals = Vitals(name, clock)
        self._heartbeat: Publisher[Heartbeat] = self.publisher("heartbeat")
        self._health = self.publisher("health")
        self._beat(STARTING_LIMIT_S)

    def publisher(self, topic_name: str) -> Publisher[Any]:
        """Return the publisher of a topic that this service owns."""
        if topic_name not in self._publishers:
            topic = TOPICS[topic_name]
            if topic.owner not in (self.name, EVERYONE):
                raise ValueError(f"{topic_name} belongs to {topic.owner}, not to {self.name}")
            key = topic_key(self.robot, topic, self.name)
            put = self.fabric.declare_publisher(key, encoding(topic.message), topic.delivery)
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
        inlet = Inlet(self.vitals.traffic(topic, "in"), handler, depth or default)
        self._inlets.append(inlet)
        key = topic_key(self.robot, topic, "*")

        def enqueue(sample: Sample) -> None:
            inlet.enqueue(next(self._arrivals), sample)
            self._notify()

        self.fabric.declare_subscriber(key, topic.delivery, enqueue)

    def answer(self, query_name: str, handler: Callable[[Any], Part]) -> None:
        """Answer a query with what `handler(request)` returns; RefusedError(reason) refuses."""
        query = QUERIES[query_name]
        if query.service != self.name:
            raise ValueError(f"{query_name} belongs to {query.service}, not to {self.name}")
        desk = Desk(query, handler)
        self._desks.append(desk)

        def enqueue(question: Question) -> None:
            desk.pending.append((next(self._arrivals), question))
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
        return decode(query.reply, payload)

    def every(self, period: float, handler: Callable[[], None]) -> None:
        """Call `handler` every `period` seconds, from now on."""
        self._timers.append(Timer(period, handler, self.clock.monotonic() + period))

    def watch_presence(self, handler: Callable[[str, bool], None]) -> None:
        """Tell `handler(service, is_present)` of every service that comes or goes."""

        def enqueue(key: str, present: bool) -> None:  # noqa: FBT001 - the fabric's signature
            service = key.rsplit("/", 1)[-1]
            self._calls.append((next(self._arrivals), lambda: handler(service, present)))
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
        while self._handle_oldest():
            self._run_due_timers()
        self._run_due_timers()
        now = self.clock.monotonic()
        return max(0.0, min((timer.due - now for timer in self._timers), default=HEARTBEAT_S))

    def run(self) -> None:
        """Step until `stop`."""
        self.on_arrival = self._wake.set
        while not self._stopping:
            pause = self.step()
            self._wake.wait(pause)
            self._wake.clear()

    def stop(self) -> None:
        """Let `run` return after the present step; may be called from anywhere."""
        self._stopping = True
        self._wake.set()

    @property
    def is_stopping(self) -> bool:
        """Whether `stop` has been called."""
        return self._stopping

    def warn(self, source: str, text: str) -> None:
        """Log a warning, once per source and minute."""
        self.vitals.last_error = f"{source}: {text}"
        now = self.clock.monotonic()
        if now - self._warned.get(source, -WARN_EVERY_S) >= WARN_EVERY_S:
            self._warned[source] = now
            self.log.warning("%s: %s", source, text)

    def _notify(self) -> None:
        self.on_arrival()

    def _handle_oldest(self) -> bool:
        queues: list[Any] = [
            *(q for q in (self._calls,) if q),
            *(i for i in self._inlets if i.pending),
            *(d for d in self._desks if d.pending),
        ]
        if not queues:
            return False
        oldest = min(queues, key=lambda q: (q if isinstance(q, deque) else q.pending)[0][0])
        self._handle_one_of(oldest)
        return True

    def _handle_one_of(self, source: Any) -> None:  # noqa: ANN401 - one of three kinds, told apart here
        match source:
            case Inlet():
                self._handle_sample(source)
            case Desk():
                source.answer(source.pending.popleft()[1])
            case _:
                source.popleft()[1]()

    def _handle_sample(self, inlet: Inlet) -> None:
        _, sample = inlet.pending.popleft()
        inlet.traffic.count += 1
        try:
            message: Message = inlet.admit(sample, self.clock.now_ns())
        except RejectedError as error:
            inlet.traffic.dropped += 1
            self.warn(sample.key.rsplit("/", 1)[-1], f"dropped a sample: {error}")
            return
        inlet.handler(message, sample)

    def _run_due_timers(self) -> None:
        now = self.clock.monotonic()
        for timer in self._timers:
            if timer.due <= now:
                timer.due = max(timer.due + timer.period, now)
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
