"""Random bytes, wrong types and NaN on every topic and query of the registry, over a real router.

Nothing of it stops a service: each piece is refused and counted, and a good message sent after
it still arrives.
"""

import threading
import uuid
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import cbor2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pilotage.bus.clock import SystemClock
from pilotage.bus.fabric import NoAnswerError, RefusedError
from pilotage.bus.node import Node
from pilotage.bus.session import open_fabric
from pilotage_schemas.codec import DecodeError, decode, encode
from pilotage_schemas.message import Message, Part
from pilotage_schemas.topics import (
    QUERIES,
    TOPICS,
    Query,
    Topic,
    encoding,
    presence_key,
    query_key,
    topic_key,
)
from strategies import cbor_bytes, cbor_values, parts
from waiting import eventually

OWNERS = sorted({query.service for query in QUERIES.values()})


class Target:
    """One node per service that answers queries; the first also listens to every topic."""

    def __init__(self, endpoint: str, stack: ExitStack) -> None:
        self.robot = f"f{uuid.uuid4().hex[:12]}"
        self.handled: Counter[str] = Counter()
        self.nodes = {name: self.node(name, endpoint, stack) for name in OWNERS}
        self.attacker = stack.enter_context(open_fabric(endpoint))
        for topic in TOPICS.values():
            self.nodes["robot"].subscribe(topic.name, self.counting(topic.name))
        for query in QUERIES.values():
            self.nodes[query.service].answer(query.name, self.counting(query.name))
        for node in self.nodes.values():
            node.ready()
        self.threads = [threading.Thread(target=node.run) for node in self.nodes.values()]

    def node(self, name: str, endpoint: str, stack: ExitStack) -> Node:
        return Node(name, self.robot, stack.enter_context(open_fabric(endpoint)), SystemClock())

    def counting(self, name: str) -> Callable[[Part], Any]:
        def handle(message: Part) -> Part:
            self.handled[name] += 1
            return message

        return handle

    def dropped(self, topic: Topic) -> int:
        """How many samples of the topic have been dropped."""
        [counters] = [
            traffic
            for traffic in self.nodes["robot"].vitals._traffic
            if traffic.topic is topic and traffic.direction == "in"
        ]
        return counters.dropped

    def attack(self, topic: Topic) -> Callable[[bytes], None]:
        """The way in for bytes of any kind, under the topic's own key."""
        key = topic_key(self.robot, topic, "attacker")
        return self.attacker.declare_publisher(key, encoding(topic.message), "latest_wins")

    def is_refused(self, topic: Topic, send: Callable[[bytes], None], payload: bytes) -> None:
        """Send bytes and wait until they have been counted as dropped."""
        before = self.dropped(topic)
        send(payload)
        eventually(lambda: self.dropped(topic) == before + 1, what=f"{topic.name} dropped")

    def alive(self) -> bool:
        return all(thread.is_alive() for thread in self.threads)


@pytest.fixture(scope="module")
def target(router_endpoint: str) -> Iterator[Target]:
    with ExitStack() as stack:
        target = Target(router_endpoint, stack)
        for thread in target.threads:
            thread.start()
        yield target
        for node in target.nodes.values():
            node.stop()
        for thread in target.threads:
            thread.join(10.0)


topics = pytest.mark.parametrize("topic", TOPICS.values(), ids=lambda topic: topic.name)
queries = pytest.mark.parametrize("query", QUERIES.values(), ids=lambda query: query.name)


def corrupted(kind: type[Part]) -> st.SearchStrategy[bytes]:
    """A valid message with one of its fields replaced by anything."""

    @st.composite
    def draw_one(draw: st.DrawFn) -> bytes:
        fields = cbor2.loads(encode(draw(parts(kind))))
        if fields:
            fields[draw(st.sampled_from(sorted(fields)))] = draw(cbor_values())
        else:
            fields["unheard_of"] = draw(cbor_values())
        return cbor2.dumps(fields)

    return draw_one()


def is_valid(kind: type[Part], payload: bytes) -> bool:
    try:
        decode(kind, payload)
    except DecodeError:
        return False
    return True


@topics
def test_nothing_on_a_topic_stops_its_listener(target: Target, topic: Topic) -> None:
    send = target.attack(topic)

    @settings(max_examples=25)
    @given(st.one_of(st.binary(max_size=64), cbor_bytes(), corrupted(topic.message)))
    def attack(payload: bytes) -> None:
        if is_valid(topic.message, payload):
            return
        target.is_refused(topic, send, payload)

    attack()
    assert target.alive()


@topics
def test_nan_on_a_topic_is_refused(target: Target, topic: Topic) -> None:
    send = target.attack(topic)

    @settings(max_examples=5)
    @given(parts(topic.message))
    def attack(message: Message) -> None:
        fields = cbor2.loads(encode(message))
        for name, value in fields.items():
            poisoned = with_nan(value)
            if poisoned is not None:
                target.is_refused(topic, send, cbor2.dumps(fields | {name: poisoned}))

    attack()
    assert target.alive()


def with_nan(value: object) -> object:
    """The same value with a NaN in it, None where it has no place for one."""
    match value:
        case float():
            return float("nan")
        case cbor2.CBORTag(tag=85 | 86, value=bytes(data)) if data:
            dtype = np.float32 if value.tag == 85 else np.float64
            numbers = np.frombuffer(data, dtype).copy()
            numbers[-1] = np.nan
            return cbor2.CBORTag(value.tag, numbers.tobytes())
        case cbor2.CBORTag(tag=40, value=[shape, data]) if (poisoned := with_nan(data)) is not None:
            return cbor2.CBORTag(40, [list(shape), poisoned])
        case dict():
            inside = {name: with_nan(inner) for name, inner in value.items()}
            found = {name: inner for name, inner in inside.items() if inner is not None}
            return value | found if found else None
        case _:
            return None


@topics
def test_a_good_message_after_the_bad_ones_arrives(target: Target, topic: Topic) -> None:
    send = target.attack(topic)

    @settings(max_examples=3)
    @given(parts(topic.message))
    def recover(message: Message) -> None:
        target.is_refused(topic, send, b"\xff")
        handled = target.handled[topic.name]
        stamp_ns = target.nodes["robot"].clock.now_ns()
        send(encode(message.model_copy(update={"stamp_ns": stamp_ns, "seq": 0})))
        eventually(lambda: target.handled[topic.name] > handled)

    recover()


@queries
def test_nothing_asked_stops_a_service(target: Target, query: Query) -> None:
    key = query_key(target.robot, query)
    node = target.nodes[query.service]
    counted = node.vitals.bad_questions
    eventually(lambda: is_refused(target, key, b""))
    refused = 1

    @settings(max_examples=25)
    @given(st.one_of(st.binary(max_size=64), cbor_bytes(), corrupted(query.request)))
    def attack(payload: bytes) -> None:
        nonlocal refused
        if not is_valid(query.request, payload):
            assert is_refused(target, key, payload)
            refused += 1

    attack()
    eventually(lambda: node.vitals.bad_questions == counted + refused)
    assert target.alive()


def is_refused(target: Target, key: str, payload: bytes) -> bool:
    """Ask; say whether the service refused, rather than being unknown yet or answering."""
    try:
        target.attacker.ask(key, payload, 5.0)
    except RefusedError:
        return True
    except NoAnswerError:
        return False
    return False


def test_foreign_keys_under_our_prefix_stop_nobody(target: Target) -> None:
    for key in (
        presence_key(target.robot, "nobody"),
        f"pilotage/@v1/{target.robot}/heartbeat/ä b",
        f"pilotage/@v1/{target.robot}/scan/too/deep",
        f"pilotage/@v1/{target.robot}/unheard_of",
    ):
        target.attacker.declare_publisher(key, "text/plain", "never_drop")(b"hello")
    target.attacker.declare_presence(presence_key(target.robot, "a b"))
    target.is_refused(TOPICS["scan"], target.attack(TOPICS["scan"]), b"\xff")
    assert target.alive()
