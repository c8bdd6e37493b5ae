"""Topics over a real router: streams, events, late joiners, bad and old samples."""

import itertools
import uuid
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest

from gateway_world import pose_estimate
from pilotage.bus.clock import SystemClock
from pilotage.bus.endpoints import Publisher
from pilotage.bus.node import Node
from pilotage.bus.session import ZenohFabric, open_fabric
from pilotage_schemas.codec import encode
from pilotage_schemas.mapping import GridPatch, OccupancyGrid
from pilotage_schemas.message import Message
from pilotage_schemas.sensors import Bumper, Odometry
from pilotage_schemas.topics import PATCHES_KEPT
from sample_messages import bumper, grid, odometry
from waiting import eventually, never

SECOND = 1_000_000_000


class Bus:
    """Nodes of one robot, each with a session of its own on the shared router."""

    def __init__(self, endpoint: str, stack: ExitStack) -> None:
        self.robot_name = f"r{uuid.uuid4().hex[:12]}"
        self.endpoint = endpoint
        self._stack = stack
        self._nodes: list[Node] = []

    def fabric(self) -> ZenohFabric:
        return self._stack.enter_context(open_fabric(self.endpoint))

    def node(self, name: str, robot: str | None = None) -> Node:
        node = Node(name, robot or self.robot_name, self.fabric(), SystemClock())
        self._nodes.append(node)
        return node

    def eventually(self, condition: Callable[[], object], within: float = 5.0) -> None:
        """Step all nodes until the condition holds."""

        def stepped() -> object:
            for node in self._nodes:
                node.step()
            return condition()

        eventually(stepped, within)


@pytest.fixture
def bus(router_endpoint: str) -> Iterator[Bus]:
    with ExitStack() as stack:
        yield Bus(router_endpoint, stack)


def publish_until(bus: Bus, node: Node, got: list[Odometry]) -> None:
    """Publish odometry until the first arrives: a stream keeps nothing for late joiners."""
    publisher = node.publisher("odometry")

    def arrived() -> bool:
        publisher.publish(odometry(node.clock.now_ns()))
        return bool(got)

    bus.eventually(arrived)


def test_a_stream_reaches_its_subscriber(bus: Bus) -> None:
    robot, mapper = bus.node("robot"), bus.node("mapper")
    got: list[Odometry] = []
    mapper.subscribe("odometry", got.append)
    publish_until(bus, robot, got)
    robot.publisher("odometry").publish(odometry(robot.clock.now_ns(), x=1.5))
    bus.eventually(lambda: got[-1].pose.x == 1.5)


def test_a_map_of_25_million_cells_arrives(bus: Bus) -> None:
    mapper, localizer = bus.node("mapper"), bus.node("localizer")
    got: list[OccupancyGrid] = []
    localizer.subscribe("map", got.append)
    mapper.publisher("map").publish(grid(mapper.clock.now_ns(), rows=5000, cols=5000))
    bus.eventually(lambda: got and got[0].cells.shape == (5000, 5000), within=20.0)


def test_a_late_joiner_gets_the_last_event_only(bus: Bus) -> None:
    mapper, localizer = bus.node("mapper"), bus.node("localizer")
    for rows in (2, 3, 4):
        mapper.publisher("map").publish(grid(mapper.clock.now_ns(), rows=rows))
    got: list[OccupancyGrid] = []
    localizer.subscribe("map", got.append)
    bus.eventually(lambda: got)
    assert [len(message.cells) for message in got] == [4]
    mapper.publisher("map").publish(grid(mapper.clock.now_ns(), rows=5))
    bus.eventually(lambda: [len(message.cells) for message in got] == [4, 5])


def test_events_arrive_all_and_in_order(bus: Bus) -> None:
    robot, mapper = bus.node("robot"), bus.node("mapper")
    got: list[Bumper] = []
    mapper.subscribe("bumper", got.append)
    # Of what was published before the two knew of each other only the last would come.
    robot.publisher("bumper").publish(bumper(0))
    bus.eventually(lambda: got)
    for number in range(1, 500):
        robot.publisher("bumper").publish(bumper(number))
    bus.eventually(lambda: got[-1].stamp_ns == 499, within=20.0)
    assert [message.stamp_ns for message in got] == list(range(500))
    assert mapper.vitals.report().dropped == 0


def test_a_publisher_that_comes_later_is_heard(bus: Bus) -> None:
    got: list[Bumper] = []
    bus.node("mapper").subscribe("bumper", got.append)
    bus.node("robot").publisher("bumper").publish(bumper(7))
    bus.eventually(lambda: [message.stamp_ns for message in got] == [7])


def test_every_service_is_heard_on_a_topic_that_each_publishes(bus: Bus) -> None:
    gateway = bus.node("gateway")
    heard: set[str] = set()
    gateway.subscribe("heartbeat", lambda beat: heard.add(beat.service))
    for name in ("robot", "mapper"):
        bus.node(name).ready()
    bus.eventually(lambda: {"robot", "mapper"} <= heard)


def test_two_robots_on_one_router_do_not_mix(bus: Bus) -> None:
    ours, theirs = bus.node("robot"), bus.node("robot", robot=f"{bus.robot_name}_too")
    got: list[Odometry] = []
    bus.node("mapper").subscribe("odometry", got.append)
    publish_until(bus, ours, got)
    for _ in range(20):
        theirs.publisher("odometry").publish(odometry(theirs.clock.now_ns(), x=666.0))
    ours.publisher("odometry").publish(odometry(ours.clock.now_ns(), x=1.0))
    bus.eventually(lambda: got[-1].pose.x == 1.0)
    assert 666.0 not in {message.pose.x for message in got}


def test_bad_old_and_repeated_samples_are_dropped_and_counted(bus: Bus) -> None:
    robot, mapper = bus.node("robot"), bus.node("mapper")
    got: list[Odometry] = []
    mapper.subscribe("odometry", got.append)
    publish_until(bus, robot, got)
    key = f"pilotage/@v1/{bus.robot_name}/odometry"
    put = bus.fabric().declare_publisher(key, "application/cbor;Odometry.v1", "latest_wins")
    now = robot.clock.now_ns()

    def dropped() -> int:
        return mapper.vitals.report().dropped

    newest = numbered(odometry(now, x=3.0), 10_000)
    put(b"\xff\x00nonsense")
    bus.eventually(lambda: dropped() == 1)
    put(numbered(odometry(now - 60 * SECOND), 20_000))
    bus.eventually(lambda: dropped() == 2)
    put(newest)
    bus.eventually(lambda: got[-1].pose.x == 3.0)
    put(newest)
    bus.eventually(lambda: dropped() == 3)
    put(numbered(odometry(now - SECOND), 9_999))
    bus.eventually(lambda: dropped() == 4)
    assert "out of order: number 9999 after 10000" in mapper.vitals.report().last_error


def numbered(message: Message, seq: int) -> bytes:
    return encode(message.model_copy(update={"seq": seq}))


def test_a_subscriber_that_never_reads_does_not_stall_its_neighbour(bus: Bus) -> None:
    robot, idle, lively = bus.node("robot"), bus.node("mapper"), bus.node("localizer")
    unread: list[Message] = []
    idle.subscribe("odometry", unread.append)
    idle.subscribe("bumper", unread.append)
    got: list[Message] = []
    lively.subscribe("odometry", got.append)
    lively.subscribe("bumper", got.append)
    counter = itertools.count()

    def all_came() -> bool:
        for number in itertools.islice(counter, 20):
            robot.publisher("odometry").publish(odometry(robot.clock.now_ns()))
            robot.publisher("bumper").publish(bumper(number))
            lively.step()
        return len(got) > 3000

    eventually(all_came, within=20.0)
    assert not unread


def test_after_the_session_is_closed_nothing_more_comes(bus: Bus) -> None:
    robot, mapper = bus.node("robot"), bus.node("mapper")
    got: list[Odometry] = []
    mapper.subscribe("odometry", got.append)
    publish_until(bus, robot, got)
    mapper.fabric.close()
    mapper.step()
    before = len(got)

    def more_came() -> bool:
        robot.publisher("odometry").publish(odometry(robot.clock.now_ns()))
        mapper.step()
        return len(got) > before

    never(more_came, during=0.2)


def test_who_joins_late_gets_the_whole_map_and_all_its_patches_in_order(bus: Bus) -> None:
    mapper = bus.node("mapper")
    mapper.publisher("map").publish(grid(1))
    for number in range(PATCHES_KEPT + 5):
        cells = np.full((1, 1), number % 100, np.int8)
        patch = GridPatch(stamp_ns=1, frame_id="map", map_id="0123", row=0, col=0, cells=cells)
        mapper.publisher("map_patch").publish(patch)
    late = bus.node("gateway")
    maps: list[OccupancyGrid] = []
    patches: list[GridPatch] = []
    late.subscribe("map", maps.append)
    late.subscribe("map_patch", patches.append)
    bus.eventually(lambda: maps and len(patches) >= PATCHES_KEPT)
    assert [patch.seq for patch in patches] == list(range(5, PATCHES_KEPT + 5))


def test_the_pose_goes_from_one_service_to_the_other(bus: Bus) -> None:
    mapper, localizer, page = bus.node("mapper"), bus.node("localizer"), bus.node("gateway")
    xs: list[float] = []
    page.subscribe("pose", lambda estimate: xs.append(estimate.pose.x))
    for node, x in ((localizer, 1.0), (mapper, 2.0), (localizer, 3.0)):
        speaking = node.publisher("pose")

        def is_heard(node: Node = node, x: float = x, speaking: Publisher[Any] = speaking) -> bool:
            speaking.publish(pose_estimate(node.clock.now_ns(), x))
            return bool(xs) and xs[-1] == x

        bus.eventually(is_heard)
