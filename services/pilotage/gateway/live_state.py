"""What the gateway knows now: the newest message of every topic and service."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import cbor2

from pilotage.gateway.growing_map import GrowingMap
from pilotage.gateway.latency import LatencyStatistics
from pilotage.gateway.stream import Item
from pilotage.gateway.trajectory import Trajectory
from pilotage_schemas.codec import encode
from pilotage_schemas.localization import PoseEstimate
from pilotage_schemas.mapping import GridPatch, OccupancyGrid
from pilotage_schemas.message import Message
from pilotage_schemas.sensors import RobotStatus

MAX_SOURCES = 64
"""Services per topic that are remembered: the bus is not trusted to stay within reason."""


@dataclass(frozen=True)
class Received:
    """One message as it came off the bus; `received_ns` by the gateway's clock.

    Without a payload the message was put together here.
    """

    topic: str
    service: str
    payload: bytes | None
    message: Message
    received_ns: int

    @property
    def age_ms(self) -> float:
        """Time from measurement to arrival; negative when the sender's clock is ahead."""
        return (self.received_ns - self.message.stamp_ns) / 1e6

    @property
    def item(self) -> Item:
        """The message as a client's outbox takes it."""
        return (self.topic, self.service), lambda: self.envelope

    @cached_property
    def envelope(self) -> bytes:
        """The message in the form it has on the stream; made once for all clients."""
        payload = encode(self.message) if self.payload is None else self.payload
        return envelope(self.topic, payload, self.service, self.received_ns, self.age_ms)


def envelope(
    topic: str,
    payload: bytes,
    service: str = "gateway",
    received_ns: int = 0,
    age_ms: float = 0.0,
) -> bytes:
    """Return one binary message of the stream; the payload is carried as it is."""
    return cbor2.dumps(
        {
            "topic": topic,
            "service": service,
            "payload": payload,
            "received_ns": received_ns,
            "age_ms": age_ms,
        }
    )


class LiveState:
    """The newest of everything, the trajectory of the last minute and the ages at arrival."""

    def __init__(self) -> None:
        self.trajectory = Trajectory()
        self.latency = LatencyStatistics()
        self.map = GrowingMap()
        self._newest: dict[str, dict[str, Received]] = {}

    def take(self, received: Received) -> None:
        """Remember a message; a patch becomes part of the map."""
        if isinstance(received.message, GridPatch):
            self._take_patch(received, received.message)
            return
        sources = self._newest.setdefault(received.topic, {})
        if received.service not in sources and len(sources) >= MAX_SOURCES:
            return
        sources[received.service] = received
        if self._is_real_time():
            self.latency.add(received.topic, received.age_ms)
        if isinstance(received.message, OccupancyGrid):
            self._take_map(received, received.message)
        if isinstance(received.message, PoseEstimate):
            self.trajectory.add(received.message)

    def newest(self, topic: str, service: str | None = None) -> Received | None:
        """Return the newest message of a topic, of one service or of whichever sent last."""
        sources = self._newest.get(topic, {})
        if service is not None:
            return sources.get(service)
        return max(sources.values(), key=lambda received: received.received_ns, default=None)

    def sources(self, topic: str) -> dict[str, Received]:
        """Return the newest message of each service that publishes the topic, by name."""
        return dict(sorted(self._newest.get(topic, {}).items()))

    def everything(self) -> Iterator[Received]:
        """Yield the newest of every topic and service."""
        for sources in self._newest.values():
            yield from sources.values()

    def _take_map(self, received: Received, grid: OccupancyGrid) -> None:
        self.map.take(grid)
        if self.map.revision:
            self._remember_map(received)

    def _take_patch(self, received: Received, patch: GridPatch) -> None:
        if self.map.lay(patch):
            self._remember_map(received)

    def _remember_map(self, cause: Received) -> None:
        """Let the newest map be the patched one."""
        grid = self.map.grid
        if grid is not None:
            made = Received("map", cause.service, None, grid, cause.received_ns)
            self._newest["map"] = {cause.service: made}

    def _is_real_time(self) -> bool:
        """Say whether stamps are of this clock: a log replayed faster runs ahead of it."""
        status = self.newest("status")
        if status is None or not isinstance(status.message, RobotStatus):
            return True
        return status.message.speed_factor == 1.0
