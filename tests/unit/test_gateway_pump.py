"""The node's steps in the loop of the server."""

import asyncio
import threading

import pytest

from gateway_world import GatewayWorld, pose_estimate
from pilotage.bus.clock import HandClock
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.gateway.config import GatewaySettings
from pilotage.gateway.pump import pump
from pilotage.gateway.server import listening, serve_at
from pilotage_schemas.localization import PoseEstimate


class Pair:
    """A node that listens and one that publishes."""

    def __init__(self) -> None:
        fabric, clock = FakeFabric(), HandClock()
        self.node = Node("gateway", "demo", fabric, clock)
        self._poses = Node("localizer", "demo", fabric, clock).publisher("pose")

    def publish(self) -> None:
        self._poses.publish(pose_estimate(1_000_000 * 10**9))


def test_what_comes_from_another_thread_is_handled_in_the_loop() -> None:
    pair, handled_in = Pair(), []

    def handle(_message: PoseEstimate) -> None:
        handled_in.append(threading.current_thread())
        pair.node.stop()

    async def run() -> None:
        pumping = asyncio.create_task(pump(pair.node))
        await asyncio.to_thread(pair.publish)
        await pumping

    pair.node.subscribe("pose", handle)
    asyncio.run(run())
    assert handled_in == [threading.current_thread()]


def test_what_came_before_it_began_is_not_forgotten() -> None:
    pair = Pair()
    pair.node.subscribe("pose", lambda _message: pair.node.stop())
    pair.publish()
    asyncio.run(pump(pair.node))
    assert pair.node.is_stopping


def test_after_its_end_arrivals_wake_nobody() -> None:
    pair = Pair()
    pair.node.subscribe("pose", lambda _message: None)
    pair.node.stop()
    asyncio.run(pump(pair.node))
    pair.publish()


def test_a_handler_that_fails_ends_the_gateway_loudly() -> None:
    def fail(_message: PoseEstimate) -> None:
        raise ZeroDivisionError

    world = GatewayWorld()
    world.node.subscribe("pose", fail)
    world.other("localizer").publisher("pose").publish(pose_estimate(world.now_ns))
    with (
        listening(GatewaySettings(port=0)) as listener,
        pytest.raises(ExceptionGroup) as failure,
    ):
        asyncio.run(serve_at(listener, world.node, world.service))
    assert failure.group_contains(ZeroDivisionError)


def test_a_node_that_was_stopped_before_is_not_served() -> None:
    world = GatewayWorld()
    world.node.stop()
    with listening(GatewaySettings(port=0)) as listener:
        asyncio.run(serve_at(listener, world.node, world.service))
