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
MAX_CLIENT_MESSAGE = 4096


class Server(uvicorn.Server):
    """Ends what clients wait for before it waits for their connections to close."""

    def __init__(self, config: uvicorn.Config, service: GatewayService) -> None:
        super().__init__(config)
        self._service = service

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Let go of everybody."""
        self._service.close()
        await super().shutdown(sockets)


def serve(node: Node, service: GatewayService) -> None:
    """Serve until the first signal; ConfigError when the port cannot be had."""
    with listening(service.settings) as listener:
        node.ready()
        asyncio.run(_serve(node, service, listener))


@contextlib.contextmanager
def listening(settings: GatewaySettings) -> Iterator[socket.socket]:
    """Open the port at which clients are served."""
    host, port = settings.host, settings.port
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        listener = socket.create_server((host, port), family=family, backlog=128)
    except OSError as error:
        raise ConfigError(f"cannot listen at {host}:{port}: {error.strerror}") from error
    with listener:
        yield listener


async def _serve(node: Node, service: GatewayService, listener: socket.socket) -> None:
    access = access_of(service.settings, listener.getsockname()[1])
    server = Server(_config(create_app(service, access)), service)
    async with asyncio.TaskGroup() as tasks:
        pumping = tasks.create_task(pump(node))
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
