"""The live stream: the newest of everything, byte for byte, to each at its own pace."""

import asyncio
import json
from collections.abc import Iterator
from typing import Any

import cbor2
import pytest
from starlette.websockets import WebSocketDisconnect

import pilotage
from gateway_world import (
    GatewayWorld,
    WebSocketDenialResponse,
    WebSocketTestSession,
    grid,
    odometry,
    pose_estimate,
    scan,
)
from pilotage.gateway.stream import Hub, Outbox, TooManyStreamsError
from pilotage_schemas.codec import decode, encode
from pilotage_schemas.localization import PoseEstimate


@pytest.fixture
def world() -> Iterator[GatewayWorld]:
    with GatewayWorld() as world:
        yield world


def take_now(outbox: Outbox) -> list[bytes]:
    """Return all that waits in the outbox."""

    async def take() -> list[bytes]:
        taken = []
        while outbox.has_more:
            data = await outbox.take()
            assert data is not None
            taken.append(data)
        return taken

    return asyncio.run(take())


def fill(outbox: Outbox, *items: tuple[str, bytes]) -> Outbox:
    for topic, data in items:
        outbox.put((topic, "robot"), lambda data=data: data)  # type: ignore[misc]  # bound now
    return outbox


def test_a_slow_client_gets_the_newest_of_each_topic_in_turn() -> None:
    outbox = fill(Outbox(), ("scan", b"1"), ("pose", b"2"), ("scan", b"3"), ("scan", b"4"))
    assert take_now(outbox) == [b"4", b"2"]


def test_the_same_topic_of_two_services_does_not_mix() -> None:
    outbox = Outbox()
    outbox.put(("health", "robot"), lambda: b"r")
    outbox.put(("health", "mapper"), lambda: b"m")
    assert take_now(outbox) == [b"r", b"m"]


def test_only_the_wanted_topics_come() -> None:
    assert take_now(fill(Outbox({"pose"}), ("scan", b"1"), ("pose", b"2"))) == [b"2"]


def test_a_paused_client_gets_the_whole_picture_on_return() -> None:
    outbox = fill(Outbox(), ("scan", b"1"))
    outbox.pause()
    fill(outbox, ("scan", b"2"))
    assert take_now(outbox) == []
    outbox.resume([(("scan", "robot"), lambda: b"3"), (("map", "mapper"), lambda: b"4")])
    assert take_now(outbox) == [b"3", b"4"]


def test_answers_come_through_a_pause() -> None:
    outbox = Outbox({"pose"})
    outbox.pause()
    outbox.put_own("pong", b"1")
    assert take_now(outbox) == [b"1"]


def test_a_message_that_nobody_takes_is_never_made() -> None:
    def never() -> bytes:
        raise AssertionError

    hub = Hub(1)
    hub.publish(("scan", "robot"), never)
    outbox = Outbox()
    with hub.feeding(outbox):
        hub.publish(("scan", "robot"), never)
        hub.publish(("scan", "robot"), lambda: b"1")
    assert take_now(outbox) == [b"1"]


def test_a_client_that_left_gets_nothing() -> None:
    hub, outbox = Hub(1), Outbox()
    with hub.feeding(outbox):
        assert hub.count == 1
    hub.publish(("scan", "robot"), lambda: b"1")
    assert take_now(outbox) == []
    assert hub.count == 0


def test_streams_are_limited_in_number() -> None:
    hub = Hub(1)
    with (
        hub.feeding(Outbox()),
        pytest.raises(TooManyStreamsError),
        hub.admitted(lambda: None),
    ):
        pass
    with hub.admitted(lambda: None):
        assert hub.is_full


def test_closing_ends_every_stream_and_admits_no_more() -> None:
    hub, outbox, ended = Hub(9), Outbox(), []
    with hub.feeding(outbox), hub.admitted(lambda: ended.append("events")):
        hub.close()
        assert asyncio.run(outbox.take()) is None
        assert ended == ["events"]
    with pytest.raises(TooManyStreamsError), hub.admitted(lambda: None):
        pass


def next_of(stream: WebSocketTestSession, topic: str) -> Any:  # noqa: ANN401 - CBOR
    """Return the next envelope of a topic."""
    while True:
        envelope = cbor2.loads(stream.receive_bytes())
        if envelope["topic"] == topic:
            return envelope


def test_the_first_message_says_whose_stream_it_is(world: GatewayWorld) -> None:
    with world.stream() as stream:
        envelope = cbor2.loads(stream.receive_bytes())
    assert envelope["topic"] == "hello"
    assert cbor2.loads(envelope["payload"]) == {
        "robot": "demo",
        "now_ns": world.now_ns,
        "version": pilotage.__version__,
    }


def test_the_whole_picture_comes_at_once(world: GatewayWorld) -> None:
    world.publish("mapper", "map", grid("#."))
    world.publish("robot", "odometry", odometry(world.now_ns))
    world.publish("localizer", "pose", pose_estimate(world.now_ns))
    with world.stream() as stream:
        topics = [cbor2.loads(stream.receive_bytes())["topic"] for _ in range(8)]
    assert topics[:2] == ["hello", "link"]
    assert set(topics[2:]) == {"heartbeat", "map", "odometry", "pose"}


def test_a_payload_is_passed_on_byte_for_byte(world: GatewayWorld) -> None:
    sent = pose_estimate(world.now_ns)
    with world.stream("?topics=pose") as stream:
        world.publish("localizer", "pose", sent)
        envelope = next_of(stream, "pose")
    assert envelope["payload"] == encode(sent)
    assert decode(PoseEstimate, envelope["payload"]).pose == sent.pose
    assert envelope["service"] == "localizer"


def test_an_envelope_says_how_old_the_message_was(world: GatewayWorld) -> None:
    stamp_ns = world.now_ns
    world.clock.advance(0.25)
    with world.stream("?topics=scan") as stream:
        world.publish("robot", "scan", scan(stamp_ns, 1.0))
        envelope = next_of(stream, "scan")
    assert envelope["received_ns"] == world.now_ns
    assert envelope["age_ms"] == pytest.approx(250.0)


def test_heartbeats_name_their_service(world: GatewayWorld) -> None:
    world.other("robot")
    world.step()
    with world.stream("?topics=heartbeat") as stream:
        services = {cbor2.loads(stream.receive_bytes())["service"] for _ in range(2)}
    assert "robot" in services


def test_a_ping_is_answered(world: GatewayWorld) -> None:
    with world.stream("?topics=") as stream:
        stream.send_text(json.dumps({"ping": 17}))
        envelope = next_of(stream, "pong")
    assert cbor2.loads(envelope["payload"]) == 17
    assert envelope["received_ns"] == world.now_ns


def test_a_hidden_page_pauses_its_stream(world: GatewayWorld) -> None:
    with world.stream("?topics=pose") as stream:
        stream.send_text('{"pause": true}')
        stream.send_text('{"ping": 1}')
        next_of(stream, "pong")
        world.publish("localizer", "pose", pose_estimate(world.now_ns, 1.0))
        world.publish("localizer", "pose", pose_estimate(world.now_ns, 2.0))
        stream.send_text('{"pause": false}')
        envelope = cbor2.loads(stream.receive_bytes())
    assert decode(PoseEstimate, envelope["payload"]).pose.x == 2.0


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "null",
        '{"pause": 1}',
        '{"ping": "1"}',
        '{"ping": -1}',
        '{"ping": 1e400}',
        '{"ping": 9007199254740993}',
        '{"shout": true}',
        "[" * 4000,
    ],
)
def test_nonsense_ends_the_stream(world: GatewayWorld, text: str) -> None:
    with world.stream("?topics=") as stream:
        next_of(stream, "hello")
        stream.send_text(text)
        with pytest.raises(WebSocketDisconnect) as end:
            stream.receive_bytes()
    assert end.value.code == 1007


def test_bytes_from_a_client_are_nonsense(world: GatewayWorld) -> None:
    with world.stream("?topics=") as stream:
        next_of(stream, "hello")
        stream.send_bytes(b"\x00")
        with pytest.raises(WebSocketDisconnect):
            stream.receive_bytes()


def test_there_is_no_stream_of_another_robot(world: GatewayWorld) -> None:
    address = "ws://127.0.0.1:8000/api/v1/robots/r2d2/stream"
    with (
        pytest.raises(WebSocketDenialResponse) as denial,
        world.client.websocket_connect(address),
    ):
        pass
    assert denial.value.status_code == 404
    assert denial.value.json()["type"] == "urn:pilotage:problem:not-found"


def test_one_stream_too_many_is_refused() -> None:
    with GatewayWorld(max_streams=1) as world, world.stream() as first:
        next_of(first, "hello")
        with pytest.raises(WebSocketDenialResponse) as denial, world.stream():
            pass
        assert denial.value.status_code == 503
        assert world.client.get("/api/v1/robots/demo/events").status_code == 503


def test_the_end_of_the_gateway_ends_the_stream(world: GatewayWorld) -> None:
    with world.stream("?topics=") as stream:
        next_of(stream, "hello")
        assert world.client.portal is not None
        world.client.portal.call(world.service.close)
        with pytest.raises(WebSocketDisconnect) as end:
            stream.receive_bytes()
    assert end.value.code == 1012


def test_a_lost_bus_is_told_and_its_return_too(world: GatewayWorld) -> None:
    with world.stream("?topics=link") as stream:
        assert cbor2.loads(next_of(stream, "link")["payload"])["connected"] is True
        for connected in (False, True):
            world.fabric.connected = connected
            world.clock.advance(0.3)
            world.step()
            link = cbor2.loads(next_of(stream, "link")["payload"])
            assert link == {"connected": connected, "since_ns": world.now_ns}
    assert world.events() == ["The bus is gone; waiting for the router", "The bus is back"]
