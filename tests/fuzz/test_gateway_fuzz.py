"""The gateway under random requests, random bus traffic and random clients."""

import asyncio
import socket
import threading
from collections.abc import Iterator
from typing import Any, Self

import cbor2
import numpy as np
import pytest
import requests
import schemathesis
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from schemathesis import Case, GenerationMode
from schemathesis.schemas import BaseSchema
from starlette.websockets import WebSocketDisconnect

from gateway_world import (
    GatewayWorld,
    WebSocketTestSession,
    belief,
    deployment,
    description,
    grid,
    odometry,
    planning_status,
    pose_estimate,
    process,
    scan,
    status,
)
from pilotage.gateway.config import GatewaySettings
from pilotage.gateway.map_archive import packed
from pilotage.gateway.routes.commands import EXAMPLES
from pilotage.gateway.routes.library import EXAMPLE, SAVED_EXAMPLE
from pilotage.gateway.server import listening, serve_at
from pilotage_schemas.commands import Done, MapFile, MapList, MapSaved, StoredMap
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Part
from pilotage_schemas.topics import QUERIES, TOPICS, encoding, topic_key
from pilotage_schemas.topology import (
    NodeFound,
    Route,
    StoredTopology,
    TopologyFile,
    TopologyList,
    TopologySaved,
)

CASES = 300
"""Of each kind of request, over 36 operations: the whole file stays under 20 s."""


@schemathesis.serializer("application/zip")
def zipped(_context: object, _value: object) -> bytes:
    """An archive that can be read: random bytes are none, and are tested apart."""
    return packed({"map.yaml": b"image: map.pgm", "map.pgm": b"P5"})


GRAPH = b'{"type": "FeatureCollection", "features": []}'
KEPT = StoredTopology(name="office", map_id="0123", floor="1", nodes=3, edges=2, saved_ns=1)
ANSWERS: dict[str, Part] = {
    "map_list": MapList(maps=(StoredMap.model_validate(EXAMPLE),)),
    "map_fetch": MapFile(content=np.zeros(3, np.int8)),
    "map_store": MapSaved.model_validate(SAVED_EXAMPLE),
    "map_delete": Done(detail="deleted office"),
    "planner_status": planning_status(1),
    "topology_route": Route(
        nodes=(3,), edges=(), cost=0.0, way=np.zeros((1, 2), np.float32), floors=()
    ),
    "nearest_node": NodeFound(
        node=3, name="door 3", pose=Pose2(x=0.0, y=0.0, theta=0.0), distance=1.0
    ),
    "topology_list": TopologyList(topologies=(KEPT,)),
    "topology_delete": Done(detail="deleted office"),
    "topology_fetch": TopologyFile(content=np.frombuffer(GRAPH, np.int8)),
    "topology_store": TopologySaved(name="office", map_id="0123", path="office.geojson"),
}


def answering(world: GatewayWorld) -> None:
    """Let every command be answered with its example, and the library hold one map."""
    for query in QUERIES.values():
        parsed = ANSWERS.get(query.name)
        if parsed is None:
            parsed = query.reply.model_validate(EXAMPLES[query.name][1])
        world.other(query.service).answer(query.name, lambda _request, parsed=parsed: parsed)  # type: ignore[misc]  # bound now

    def pump() -> None:
        for service in {query.service for query in QUERIES.values()}:
            world.other(service).step()

    world.fabric.pump = pump


def picture(world: GatewayWorld) -> None:
    """Publish one message of most topics."""
    now_ns = world.now_ns
    for service, topic, message in (
        ("mapper", "map", grid("#.\n.?")),
        ("localizer", "pose", pose_estimate(now_ns)),
        ("localizer", "belief", belief(now_ns)),
        ("robot", "scan", scan(now_ns, 1.0, float("inf"))),
        ("robot", "odometry", odometry(now_ns)),
        ("robot", "status", status(now_ns)),
        ("robot", "description", description(now_ns)),
        ("planner", "planning_status", planning_status(now_ns)),
        ("launcher", "deployment", deployment(now_ns, process("robot", "ready"))),
    ):
        world.other(service).publisher(topic).publish(message)


class ServedWorld(GatewayWorld):
    """A gateway that listens at a real port, in a thread with a loop of its own."""

    def __enter__(self) -> Self:
        self._listening = listening(GatewaySettings(port=0))
        listener = self._listening.__enter__()
        self.port = listener.getsockname()[1]
        self._thread = threading.Thread(target=self._serve, args=(listener,))
        self._thread.start()
        self.session = requests.Session()
        return self

    def __exit__(self, *reason: object) -> None:
        self.session.close()
        self.node.stop()
        self._thread.join(10.0)
        self._listening.__exit__(None, None, None)

    def _serve(self, listener: socket.socket) -> None:
        asyncio.run(serve_at(listener, self.node, self.service))


@pytest.fixture(scope="module")
def served() -> Iterator[ServedWorld]:
    with ServedWorld() as world:
        answering(world)
        picture(world)
        yield world


def described() -> BaseSchema:
    """Return the API as it describes itself; the event stream never ends and is tested apart."""
    document = GatewayWorld().client.get("/api/v1/openapi.json").json()
    return schemathesis.openapi.from_dict(document).exclude(path_regex="/events$")


def check(case: Case[Any], served: ServedWorld) -> None:
    case.call_and_validate(base_url=f"http://127.0.0.1:{served.port}", session=served.session)


SCHEMA = described()
QUICKLY = settings(deadline=None, max_examples=100)
THOROUGHLY = settings(
    deadline=None, max_examples=CASES, derandomize=True, suppress_health_check=list(HealthCheck)
)


@THOROUGHLY
@given(case=SCHEMA.as_strategy())
def test_good_requests_are_answered_as_described(case: Case[Any], served: ServedWorld) -> None:
    check(case, served)


@THOROUGHLY
@given(case=SCHEMA.as_strategy(generation_mode=GenerationMode.NEGATIVE))
def test_bad_requests_are_refused_as_described(case: Case[Any], served: ServedWorld) -> None:
    check(case, served)


def flood(world: GatewayWorld, topic: str, payload: bytes) -> None:
    """Publish raw bytes as the topic's owner would."""
    registered = TOPICS[topic]
    key = topic_key("demo", registered, "stranger")
    put = world.fabric.declare_publisher(key, encoding(registered.message), "latest_wins")
    put(payload)
    world.step()


@pytest.fixture(scope="module")
def world() -> Iterator[GatewayWorld]:
    with GatewayWorld() as world:
        picture(world)
        world.step()
        yield world


def dropped(world: GatewayWorld) -> int:
    return world.node.vitals.report().dropped


@QUICKLY
@given(topic=st.sampled_from(list(TOPICS)), payload=st.binary(max_size=200))
def test_random_bytes_on_any_topic_are_counted_and_dropped(
    world: GatewayWorld, topic: str, payload: bytes
) -> None:
    before = dropped(world)
    flood(world, topic, payload)
    assert dropped(world) == before + 1
    assert world.client.get("/readyz").status_code == 200


def drain(stream: WebSocketTestSession) -> None:
    while True:
        stream.receive_bytes()


NUMBERS = st.floats(width=32) | st.integers() | st.none() | st.text(max_size=5)


@QUICKLY
@given(
    topic=st.sampled_from(list(TOPICS)),
    fields=st.dictionaries(
        st.sampled_from(["stamp_ns", "frame_id", "seq", "pose", "state", "cells", "processes"]),
        st.recursive(
            NUMBERS,
            lambda inner: st.lists(inner) | st.dictionaries(st.text(max_size=5), inner),
            max_leaves=10,
        ),
    ),
)
def test_wrong_fields_on_any_topic_change_nothing(
    world: GatewayWorld, topic: str, fields: dict[str, object]
) -> None:
    before = world.client.get("/api/v1/robots/demo").json()
    flood(world, topic, cbor2.dumps(fields))
    assert world.client.get("/api/v1/robots/demo").json() == before


@QUICKLY
@given(text=st.text(max_size=100) | st.sampled_from(['{"ping":', '{"pause":true,"ping":1}']))
def test_whatever_a_client_says_harms_only_itself(world: GatewayWorld, text: str) -> None:
    with world.stream("?topics=") as stream:
        stream.receive_bytes()
        stream.send_text(text)
        stream.send_text("bye")
        with pytest.raises(WebSocketDisconnect) as end:
            drain(stream)
    assert end.value.code == 1007
    assert world.service.hub.count == 0


@QUICKLY
@given(data=st.binary(min_size=1, max_size=300))
def test_random_bytes_at_the_port_are_answered_or_hung_up_on(
    served: ServedWorld, data: bytes
) -> None:
    with socket.create_connection(("127.0.0.1", served.port), timeout=10.0) as connection:
        connection.sendall(data + b"\r\n\r\n")
        connection.shutdown(socket.SHUT_WR)
        while connection.recv(4096):
            pass
    assert served.session.get(f"http://127.0.0.1:{served.port}/healthz").status_code == 200
