"""The topology service over a real router: late joiners, questions, large maps."""

import threading
import uuid
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
import pytest

from pilotage.bus.clock import SystemClock
from pilotage.bus.deployment import Deployment
from pilotage.bus.fabric import NoAnswerError, RefusedError
from pilotage.bus.node import Node
from pilotage.bus.session import open_fabric
from pilotage.mapper.messages import grid_message
from pilotage.topology.config import TopologySettings
from pilotage.topology.routes.floors import Floor
from pilotage.topology.service import TopologyService
from pilotage.topology.storage import packed, parsed
from pilotage_schemas import topology as t
from pilotage_schemas.message import Part
from topology_bench import FLAT
from topology_maps import graph
from waiting import eventually


class Neighbourhood:
    """Nodes of one robot, each with a session of its own."""

    def __init__(self, endpoint: str, stack: ExitStack) -> None:
        self._endpoint, self._stack = endpoint, stack
        self._robot = f"t{uuid.uuid4().hex[:12]}"

    def node(self, name: str) -> Node:
        fabric = self._stack.enter_context(open_fabric(self._endpoint))
        return Node(name, self._robot, fabric, SystemClock())

    def running(self, node: Node) -> None:
        """Run the node's loop in a thread until the end of the test."""
        self._stack.enter_context(_running(node))


@contextmanager
def _running(node: Node) -> Iterator[None]:
    thread = threading.Thread(target=node.run)
    thread.start()
    try:
        yield
    finally:
        node.stop()
        thread.join(20.0)


@pytest.fixture
def around(router_endpoint: str, tmp_path: Path) -> Iterator[Neighbourhood]:
    """The topology service runs, and the mapper has published a flat before it came."""
    with ExitStack() as stack:
        around = Neighbourhood(router_endpoint, stack)
        mapper = around.node("mapper")
        mapper.publisher("map").publish(grid_message(FLAT, "flat", mapper.clock.now_ns()))
        node = around.node("topology")
        service = TopologyService(TopologySettings(), node, Deployment(run_dir=tmp_path))
        around.running(node)
        yield around
        assert service is not None


def answered(asking: Node, query: str, request: Part) -> Part:
    """Ask until the service is known and has its map."""

    def reply() -> Part | None:
        try:
            return asking.ask(query, request)
        except (NoAnswerError, RefusedError):
            return None

    found = eventually(reply, 30.0, query)
    assert found is not None
    return found


def test_who_comes_late_gets_the_map_of_places_all_the_same(around: Neighbourhood) -> None:
    answered(around.node("planner"), "nearest_node", t.NearestNode(x=9.0, y=5.8))
    seen: list[t.TopologicalMap] = []
    late = around.node("gateway")
    late.subscribe("topology", seen.append)
    around.running(late)
    eventually(lambda: seen, 20.0, "the map of places")
    assert [node.kind for node in seen[0].nodes].count("door") == 2


def test_ways_are_answered_and_refused_over_the_bus(around: Neighbourhood) -> None:
    asking = around.node("gateway")
    rooms = t.Point(x=2.7, y=10.7), t.Point(x=8.9, y=3.3)
    route = answered(asking, "topology_route", t.TopologyRoute(start=rooms[0], end=rooms[1]))
    assert isinstance(route, t.Route)
    assert np.hypot(*np.diff(route.way, axis=0).T).sum() > 10.0
    with pytest.raises(RefusedError, match="there is no node 4711"):
        asking.ask("topology_route", t.TopologyRoute(start=4711, end=0))


def test_a_map_of_many_places_is_taken_in_and_given_back(around: Neighbourhood) -> None:
    side = 40
    places = [(float(i % side), float(i // side)) for i in range(side * side)]
    ways = [(i, i + 1) for i in range(side * side - 1) if (i + 1) % side]
    ways += [(i, i + side) for i in range(side * (side - 1))]
    town = Floor(graph(places, ways, "town"))
    asking = around.node("gateway")
    content = np.frombuffer(packed(town), np.int8)
    answered(asking, "topology_store", t.TopologyStore(name="town", content=content))
    file = asking.ask("topology_fetch", t.TopologyFetch(name="town"))
    assert isinstance(file, t.TopologyFile)
    assert len(parsed(file.content.tobytes()).map.edges) == len(ways)
    ends = t.NodeOf(name="town", node=0), t.NodeOf(name="town", node=side * side - 1)
    route = asking.ask("topology_route", t.TopologyRoute(start=ends[0], end=ends[1]))
    assert isinstance(route, t.Route)
    assert route.cost == pytest.approx(2.0 * (side - 1))
