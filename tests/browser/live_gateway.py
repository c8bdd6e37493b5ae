"""The real gateway on a fake bus, served over TCP in a thread: what the browser tests look at."""

import asyncio
import threading
from collections.abc import Callable
from typing import Any, Self

from pilotage.bus.clock import SystemClock
from pilotage.bus.deployment import Deployment
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.gateway.config import GatewaySettings
from pilotage.gateway.server import listening, serve_at
from pilotage.gateway.service import GatewayService
from pilotage_schemas.message import Message, Part


class LiveGateway:
    """A gateway of robot `demo`; publish to it as any service, `unplug` and `plug` it in again."""

    def __init__(self, **settings: object) -> None:
        self.fabric = FakeFabric()
        self.clock = SystemClock()
        self.settings = GatewaySettings.model_validate({"port": 0} | settings)
        self._others: dict[str, Node] = {}
        self._lock = threading.Lock()

    def __enter__(self) -> Self:
        self.plug()
        return self

    def __exit__(self, *reason: object) -> None:
        self.unplug()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.settings.port}/"

    def plug(self) -> None:
        """Start the gateway, at the same port as before."""
        self._node = Node("gateway", "demo", self.fabric, self.clock)
        service = GatewayService(self.settings, self._node, Deployment())
        self._opened = listening(self.settings)
        listener = self._opened.__enter__()
        port = listener.getsockname()[1]
        self.settings = self.settings.model_copy(update={"port": port})
        service.settings = self.settings

        def serve() -> None:
            asyncio.run(serve_at(listener, self._node, service))

        self._thread = threading.Thread(target=serve)
        self._thread.start()

    def unplug(self) -> None:
        """Let the gateway go, as when its machine is switched off."""
        self._node.stop()
        self._node.on_arrival()
        self._thread.join(10.0)
        self._opened.__exit__(None, None, None)

    def other(self, service: str) -> Node:
        """Return the node of another service."""
        if service not in self._others:
            self._others[service] = Node(service, "demo", self.fabric, self.clock)
        return self._others[service]

    def publish(self, service: str, topic: str, message: Message) -> None:
        """Send a message as `service`."""
        with self._lock:
            self.other(service).publisher(topic).publish(message)

    def answer(self, service: str, query: str, handler: Callable[[Any], Part]) -> None:
        """Let a service answer a query."""
        self.other(service).answer(query, handler)
        answering = [self._others[name] for name in self._others]

        def pump() -> None:
            with self._lock:
                for node in answering:
                    node.step()

        self.fabric.pump = pump
