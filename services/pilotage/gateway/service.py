"""The gateway between the bus and its clients: takes in what comes, keeps it, passes it on."""

from collections.abc import Iterator
from functools import partial

import cbor2

import pilotage
from pilotage.bus.deployment import Deployment
from pilotage.bus.fabric import Sample
from pilotage.bus.node import Node
from pilotage.gateway.commander import Commander
from pilotage.gateway.config import GatewaySettings
from pilotage.gateway.event_log import EventLog
from pilotage.gateway.live_state import LiveState, Received, envelope
from pilotage.gateway.map_files import MapFiles
from pilotage.gateway.stream import Hub, Item
from pilotage.gateway.watch import Watch
from pilotage_schemas.mapping import GridPatch
from pilotage_schemas.message import Message
from pilotage_schemas.topics import EVERYONE, TOPICS

LINK_POLL_S = 0.25


class GatewayService:
    """Everything the gateway knows of one robot; all of it belongs to the loop of `node`."""

    def __init__(self, settings: GatewaySettings, node: Node, _deployment: Deployment) -> None:
        self.settings = settings
        self.node = node
        self.robot = node.robot
        self.state = LiveState()
        self.events = EventLog()
        self.hub = Hub(settings.max_streams)
        self.commander = Commander(node, self.events)
        self.map_files = MapFiles()
        self.is_linked = node.fabric.is_connected()
        self.linked_since_ns = node.clock.now_ns()
        self._watch = Watch(self.events)
        for topic in TOPICS:
            node.subscribe_samples(topic, partial(self._on_message, topic))
        node.every(LINK_POLL_S, self._poll_link)

    def hello(self) -> bytes:
        """Return the first message of a stream: whose it is, and the gateway's clock."""
        greeting = {
            "robot": self.robot,
            "now_ns": self.node.clock.now_ns(),
            "version": pilotage.__version__,
        }
        return envelope("hello", cbor2.dumps(greeting), received_ns=self.node.clock.now_ns())

    def picture(self) -> Iterator[Item]:
        """Yield all that a client needs for the full picture."""
        yield ("link", "gateway"), self._link_envelope
        for received in self.state.everything():
            yield received.item

    def close(self) -> None:
        """Let go of everybody who waits for something."""
        self.hub.close()
        self.commander.close()

    def _on_message(self, topic: str, message: Message, sample: Sample) -> None:
        registered = TOPICS[topic]
        service = (
            sample.key.rsplit("/", 1)[-1] if registered.owner == EVERYONE else registered.owner
        )
        now_ns = self.node.clock.now_ns()
        received = Received(topic, service, sample.payload, message, now_ns)
        self.state.take(received)
        self._watch.see(message, now_ns)
        if isinstance(message, GridPatch):
            self._pass_on_patch(received, message)
        else:
            self.hub.publish(*received.item)

    def _pass_on_patch(self, received: Received, patch: GridPatch) -> None:
        """Patches do not replace each other, as messages of other topics do."""
        whole = self.state.newest("map")
        if whole is not None:
            _, make = received.item
            self.hub.publish_step(("map_patch", f"mapper {patch.seq}"), make, whole.item)

    def _poll_link(self) -> None:
        is_linked = self.node.fabric.is_connected()
        if is_linked == self.is_linked:
            return
        now_ns = self.node.clock.now_ns()
        self.is_linked, self.linked_since_ns = is_linked, now_ns
        if is_linked:
            self.events.append(now_ns, "link", "info", "The bus is back")
        else:
            self.events.append(now_ns, "link", "fault", "The bus is gone; waiting for the router")
        self.hub.publish(("link", "gateway"), self._link_envelope)

    def _link_envelope(self) -> bytes:
        link = {"connected": self.is_linked, "since_ns": self.linked_since_ns}
        return envelope("link", cbor2.dumps(link), received_ns=self.linked_since_ns)
