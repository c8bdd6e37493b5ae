"""Serves the application over TCP in the loop that also steps the node."""

import asyncio
import contextlib
import socket
from collections.abc import Iterator

import uvicorn

from pilotage.bus.deployment import ConfigError
from pilotage.bus.node import Node
from pilotage.gateway.access import access_of
from pilotage.gateway.app import create_app
from pilotage.gateway.config import GatewaySettings
from pilotage.gateway.guard import Guard
from pilotage.gateway.pump import pump
from pilotage.gateway.service import GatewayService

GRACE_S = 1
PATIENCE_S = 0.5
"""A client that reads nothing cannot be said goodbye to: its buffer is full."""

MAX_CLIENT_MESSAGE = 4096


class Server(uvicorn.Server):
    """Ends what clients wait for before it waits for their connections to close."""

    def __init__(self, config: uvicorn.Config, service: GatewayService) -> None:
        super().__init__(config)
        self._service = service

    def stop(self) -> None:
        """Ask the server to end."""
        self.should_exit = True

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Let go of everybody; who does not go in time is hung up on."""
        self._service.close()
        asyncio.get_running_loop().call_later(PATIENCE_S, self._hang_up)
        await super().shutdown(sockets)

    def _hang_up(self) -> None:
        for connection in list(self.server_state.connections):
            connection.transport.abort()


def serve(node: Node, service: GatewayService) -> None:
    """Serve until the first signal; ConfigError when the port cannot be had."""
    with listening(service.settings) as listener:
        asyncio.run(serve_at(listener, node, service))


@contextlib.contextmanager
def listening(settings: GatewaySettings) -> Iterator[socket.socket]:
    """Open the port at which clients are served."""
    host, port = settings.host, settings.port
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        listener = socket.create_server((host, port), family=family, backlog=128)
    except OSError as error:
        raise ConfigError(f"cannot listen at {host}:{port}: {error.strerror}") from error
    # Connections inherit it. Without it an answer of two packets waits 40 ms for the client's
    # delayed acknowledgement; asyncio sets it only on sockets that name their protocol.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    with listener:
        yield listener


async def serve_at(listener: socket.socket, node: Node, service: GatewayService) -> None:
    """Step the node and serve until a signal comes or the node is stopped."""
    access = access_of(service.settings, listener.getsockname()[1])
    server = Server(_config(create_app(service, access)), service)
    # Not before: making the application takes longer than a heartbeat may be late.
    node.ready()
    async with asyncio.TaskGroup() as tasks:
        pumping = tasks.create_task(pump(node))
        pumping.add_done_callback(lambda _task: server.stop())
        if not node.is_stopping:
            await server.serve(sockets=[listener])
        pumping.cancel()


def _config(app: Guard) -> uvicorn.Config:
    return uvicorn.Config(
        app,
        lifespan="off",
        # Addresses in the log would hold the tokens of streams.
        access_log=False,
        log_config=None,
        log_level="warning",
        proxy_headers=False,
        server_header=False,
        ws="websockets-sansio",
        ws_max_size=MAX_CLIENT_MESSAGE,
        # Float arrays hardly shrink, and the time it takes is latency.
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=GRACE_S,
    )
