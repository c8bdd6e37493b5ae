"""A real gateway process on a real bus, with real clients."""

import json
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Self

import cbor2
import httpx
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from gateway_world import grid, pose_estimate, scan
from pilotage.bus.clock import SystemClock
from pilotage.bus.node import Node
from pilotage.bus.session import open_fabric
from pilotage_schemas.codec import encode
from pilotage_schemas.message import Message
from pilotage_schemas.topics import QUERIES, query_key
from processes import RouterProcess, free_port, listens
from waiting import eventually

END_S = 1.5
"""A gateway ends within 1 s of the signal; the rest is for a machine that is busy."""


class GatewayProcess:
    """A gateway on the bus at `endpoint`; what it writes to stderr is kept."""

    def __init__(self, folder: Path, endpoint: str, **settings: object) -> None:
        self.port = free_port()
        self.stderr = folder / f"gateway_{self.port}.log"
        self._deployment = folder / f"gateway_{self.port}.yaml"
        self.robot = f"gateway_{self.port}"
        section = {"port": self.port} | settings
        self._deployment.write_text(
            json.dumps(
                {"robot": self.robot, "endpoint": endpoint, "services": {"gateway": section}}
            ),
            encoding="utf-8",
        )

    def __enter__(self) -> Self:
        command = [sys.executable, "-m", "pilotage.gateway", "--deployment", str(self._deployment)]
        with self.stderr.open("wb") as log:
            self.process = subprocess.Popen(command, stderr=log)
        eventually(self._is_up, within=20.0, what="the gateway listening or its end")
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.wait(timeout=10.0)

    def _is_up(self) -> bool:
        return listens(self.port) or self.process.poll() is not None

    @property
    def address(self) -> str:
        return f"127.0.0.1:{self.port}/api/v1/robots/{self.robot}"

    @property
    def log(self) -> str:
        return self.stderr.read_text(encoding="utf-8")

    def get(self, path: str) -> httpx.Response:
        return httpx.get(f"http://{self.address}/{path}", timeout=10.0)

    def post(self, command: str) -> httpx.Response:
        return httpx.post(f"http://{self.address}/commands/{command}", timeout=20.0)

    def stream(self, query: str = "", origin: str | None = None) -> ClientConnection:
        """Open the live stream; `origin` as of a page that a browser shows."""
        headers = {} if origin is None else {"origin": origin}
        address = f"ws://{self.address}/stream{query}"
        return connect(address, additional_headers=headers, max_size=None)


@pytest.fixture
def gateway(tmp_path: Path, router_endpoint: str) -> Iterator[GatewayProcess]:
    with GatewayProcess(tmp_path, router_endpoint) as gateway:
        yield gateway


@pytest.fixture
def localizer(gateway: GatewayProcess, router_endpoint: str) -> Iterator[Node]:
    with open_fabric(router_endpoint) as fabric:
        yield Node("localizer", gateway.robot, fabric, SystemClock())


Envelope = dict[str, Any]


def envelope_of(stream: ClientConnection, topic: str, timeout: float = 10.0) -> Envelope:
    """Return the next envelope of a topic; TimeoutError after `timeout` s of silence."""
    while True:
        data = stream.recv(timeout=timeout)
        assert isinstance(data, bytes)
        envelope: Envelope = cbor2.loads(data)
        if envelope["topic"] == topic:
            return envelope


def publish_until(node: Node, topic: str, message: Message, stream: ClientConnection) -> Envelope:
    """Publish until the stream has it: the subscription may still be on its way."""
    publisher = node.publisher(topic)

    def arrives() -> Envelope | None:
        publisher.publish(message)
        try:
            return envelope_of(stream, topic, timeout=0.05)
        except TimeoutError:
            return None

    found = eventually(arrives, within=10.0, what=f"{topic} on the stream")
    assert found is not None
    return found


def drain(stream: ClientConnection) -> None:
    """Receive until the stream ends."""
    while True:
        stream.recv(timeout=10.0)


def test_a_message_passes_from_the_bus_to_a_client_byte_for_byte(
    gateway: GatewayProcess, localizer: Node
) -> None:
    message = pose_estimate(time.time_ns())
    with gateway.stream("?topics=pose") as stream:
        envelope_of(stream, "hello")
        envelope = publish_until(localizer, "pose", message, stream)
    numbered = message.model_copy(update={"seq": cbor2.loads(envelope["payload"])["seq"]})
    assert envelope["payload"] == encode(numbered)
    assert 0.0 < envelope["age_ms"] < 10_000.0
    assert gateway.get("pose").json()["state"] == "localized"


def test_a_client_that_comes_late_gets_the_map_at_once(
    gateway: GatewayProcess, router_endpoint: str
) -> None:
    with open_fabric(router_endpoint) as fabric:
        mapper = Node("mapper", gateway.robot, fabric, SystemClock())
        mapper.publisher("map").publish(grid("#."))
        eventually(lambda: gateway.get("map").status_code == 200, what="the map")
        with gateway.stream() as stream:
            assert envelope_of(stream, "map")["service"] == "mapper"


def test_strangers_and_foreign_pages_are_refused_on_the_wire(gateway: GatewayProcess) -> None:
    with pytest.raises(InvalidStatus) as refusal, gateway.stream(origin="http://evil.example"):
        pass
    assert refusal.value.response.status_code == 403
    assert b"urn:pilotage:problem:forbidden" in refusal.value.response.body
    answer = httpx.get(f"http://127.0.0.1:{gateway.port}/healthz", headers={"host": "evil:80"})
    assert answer.status_code == 421


def test_too_much_from_a_client_ends_its_stream(gateway: GatewayProcess) -> None:
    with gateway.stream("?topics=") as stream:
        stream.send("x" * 5000)
        with pytest.raises(ConnectionClosed):
            drain(stream)


def test_a_client_that_reads_nothing_holds_up_nobody(
    gateway: GatewayProcess, localizer: Node, router_endpoint: str
) -> None:
    with open_fabric(router_endpoint) as fabric:
        robot = Node("robot", gateway.robot, fabric, SystemClock())
        scans = robot.publisher("scan")
        address = ("127.0.0.1", gateway.port)
        with socket.create_connection(address) as stuck, gateway.stream("?topics=pose") as stream:
            stuck.sendall(handshake(gateway))
            assert stuck.recv(12) == b"HTTP/1.1 101"
            # Far more than the buffers of both ends hold.
            for _ in range(300):
                scans.publish(scan(time.time_ns(), *([1.0] * 10_000)))
            envelope = publish_until(localizer, "pose", pose_estimate(time.time_ns()), stream)
            assert envelope["service"] == "localizer"
            ends_well(gateway, signal.SIGTERM)


def handshake(gateway: GatewayProcess) -> bytes:
    """Return the request of a WebSocket client that will then fall silent."""
    return (
        f"GET /api/v1/robots/{gateway.robot}/stream HTTP/1.1\r\nHost: 127.0.0.1:{gateway.port}\r\n"
        "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    ).encode()


def ends_well(gateway: GatewayProcess, number: int) -> None:
    """Send the signal and check that the gateway ends in time, with exit code 0, in peace."""
    began = time.monotonic()
    gateway.process.send_signal(number)
    assert gateway.process.wait(timeout=10.0) == 0
    assert time.monotonic() - began < END_S
    assert "Traceback" not in gateway.log
    assert "ERROR" not in gateway.log


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_though_clients_are_there(gateway: GatewayProcess, number: int) -> None:
    events = f"http://{gateway.address}/events"
    with gateway.stream() as stream, httpx.stream("GET", events, timeout=10.0) as following:
        blocks = following.iter_bytes()
        assert next(blocks).startswith(b":")
        envelope_of(stream, "hello")
        ends_well(gateway, number)
        with pytest.raises(ConnectionClosed) as end:
            drain(stream)
        assert end.value.rcvd is not None
        assert end.value.rcvd.code == 1012
        assert not [block for block in blocks if not block.startswith((b":", b"id:"))]


def test_a_signal_ends_it_though_a_command_waits(
    gateway: GatewayProcess, router_endpoint: str
) -> None:
    asked: list[object] = []
    with open_fabric(router_endpoint) as fabric, ThreadPoolExecutor(1) as caller:
        fabric.declare_queryable(query_key(gateway.robot, QUERIES["load_map"]), asked.append)
        body = {"path": "maps/office.yaml"}
        address = f"http://{gateway.address}/commands/load_map"
        waiting = caller.submit(httpx.post, address, json=body, timeout=20.0)
        eventually(lambda: asked, what="the question at the mapper")
        ends_well(gateway, signal.SIGINT)
        answer = waiting.result()
    assert answer.status_code == 503
    assert "stopping" in answer.json()["detail"]


def test_a_lost_router_is_told_and_its_return_heals_everything(tmp_path: Path) -> None:
    with (
        RouterProcess(tmp_path) as router,
        GatewayProcess(tmp_path, router.endpoint) as gateway,
        gateway.stream("?topics=link,heartbeat") as stream,
    ):
        assert link_of(stream) is True
        router.kill()
        assert link_of(stream) is False
        assert gateway.post("stop").status_code in (503, 504)
        assert gateway.get("health").json()["connected"] is False
        router.start()
        assert link_of(stream) is True
        envelope_of(stream, "heartbeat")
        ends_well(gateway, signal.SIGINT)


def link_of(stream: ClientConnection) -> bool:
    connected: bool = cbor2.loads(envelope_of(stream, "link")["payload"])["connected"]
    return connected


def refused(gateway: GatewayProcess) -> str:
    """Return the one line with which a gateway that cannot start ends."""
    assert gateway.process.wait(timeout=20.0) == 2
    (line,) = gateway.log.splitlines()
    return line


def test_a_port_in_use_is_refused_in_one_line(tmp_path: Path, router_endpoint: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with GatewayProcess(tmp_path, router_endpoint, port=port) as gateway:
            line = refused(gateway)
    assert line.startswith(f"pilotage gateway: cannot listen at 127.0.0.1:{port}: ")
    assert "in use" in line


def test_an_open_address_without_tokens_is_refused(tmp_path: Path, router_endpoint: str) -> None:
    with GatewayProcess(tmp_path, router_endpoint, host="0.0.0.0") as gateway:  # noqa: S104 - refused
        assert "operator_tokens are needed" in refused(gateway)


def test_with_tokens_it_serves_all_addresses(tmp_path: Path, router_endpoint: str) -> None:
    token = "a-token-of-this-test"  # noqa: S105 - made up
    settings = {"host": "0.0.0.0", "operator_tokens": [token]}  # noqa: S104 - guarded by a token
    with GatewayProcess(tmp_path, router_endpoint, **settings) as gateway:
        assert gateway.get("health").status_code == 401
        with gateway.stream(f"?topics=&token={token}") as stream:
            assert envelope_of(stream, "hello")
        ends_well(gateway, signal.SIGINT)
        assert token not in gateway.log
