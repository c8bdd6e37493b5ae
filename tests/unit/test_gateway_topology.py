"""Topological maps, ways and their library over HTTP, and what people are told of them."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from gateway_world import ROBOT, GatewayWorld
from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage_schemas.commands import Done
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Part
from pilotage_schemas.topology import (
    Edge,
    NearestNode,
    NodeArrival,
    NodeFound,
    NodeOf,
    Point,
    Relocalization,
    Route,
    RouteFloor,
    StoredTopology,
    TopologicalMap,
    TopologyFetch,
    TopologyFile,
    TopologyList,
    TopologyLoad,
    TopologyLoaded,
    TopologyRoute,
    TopologySaved,
    TopologyStore,
)
from pilotage_schemas.topology import Node as Place

LIBRARY = "/api/v1/topologies"
HERE = Pose2(x=1.0, y=2.0, theta=0.5)
FILE = b'{"type": "FeatureCollection", "features": []}'
CONTENT = np.frombuffer(FILE, np.int8)
WAY = np.array([[0.0, 0.0], [3.0, 0.0]], np.float32)
ROUTE = Route(
    nodes=(0, 1),
    edges=(2,),
    cost=5.0,
    way=WAY,
    floors=(RouteFloor(name="office", floor="1", nodes=2, edges=1, points=2),),
)
KEPT = StoredTopology(name="office", map_id="0123", floor="1", nodes=2, edges=1, saved_ns=7)


@pytest.fixture
def world() -> Iterator[GatewayWorld]:
    with GatewayWorld() as world:
        yield world


class Library:
    """A topology service that answers with what it was given, and notes what it was asked."""

    def __init__(self, world: GatewayWorld) -> None:
        self.asked: list[Part] = []
        node = world.other("topology")
        for query, reply in {
            "topology_route": ROUTE,
            "nearest_node": NodeFound(node=4, name="door 4", pose=HERE, distance=0.5),
            "topology_list": TopologyList(topologies=(KEPT,)),
            "topology_fetch": TopologyFile(content=CONTENT),
            "topology_store": TopologySaved(name="office", map_id="0123", path="office.geojson"),
            "topology_load": TopologyLoaded(map_id="0123", nodes=2, edges=1),
            "topology_delete": Done(detail="deleted office"),
        }.items():
            node.answer(query, self._noting(reply))
        self._pump(world, node)

    def _noting(self, reply: Part) -> Callable[[Part], Part]:
        def answer(request: Part) -> Part:
            self.asked.append(request)
            return reply

        return answer

    def _pump(self, world: GatewayWorld, node: Node) -> None:
        def pump() -> None:
            node.step()

        world.fabric.pump = pump


def graph(stamp_ns: int, **changes: object) -> TopologicalMap:
    nodes = tuple(
        Place(id=i, kind="node", name=f"node {i}", pose=HERE, features=()) for i in range(2)
    )
    fields: dict[str, object] = {
        "map_id": "0123",
        "nodes": nodes,
        "edges": (Edge(id=2, start=0, end=1, cost=3.0, way=WAY),),
    }
    fields |= {"stamp_ns": stamp_ns, "frame_id": "map"}
    return TopologicalMap.model_validate(fields | changes)


def test_before_there_is_a_map_the_service_that_should_send_it_is_named(
    world: GatewayWorld,
) -> None:
    answer = world.client.get(f"{ROBOT}/topology")
    assert answer.status_code == 404
    assert "topology should send it" in answer.json()["detail"]


def test_the_map_comes_as_json_with_its_ways_as_points(world: GatewayWorld) -> None:
    world.publish("topology", "topology", graph(world.now_ns))
    answer = world.client.get(f"{ROBOT}/topology").json()
    assert answer["edges"][0]["way"] == [[0.0, 0.0], [3.0, 0.0]]
    assert [node["name"] for node in answer["nodes"]] == ["node 0", "node 1"]
    assert answer["age_ms"] >= 0.0


def test_the_map_comes_as_geojson_byte_for_byte(world: GatewayWorld) -> None:
    library = Library(world)
    answer = world.client.get(f"{ROBOT}/topology", params={"format": "geojson"})
    assert answer.content == FILE
    assert answer.headers["content-type"] == "application/geo+json"
    assert library.asked == [TopologyFetch()]


def test_another_form_is_refused(world: GatewayWorld) -> None:
    assert world.client.get(f"{ROBOT}/topology", params={"format": "osm"}).status_code == 422


@pytest.mark.parametrize(
    ("ends", "wanted"),
    [
        (("3", "12"), TopologyRoute(start=3, end=12)),
        (
            ("1.5,-2", "0,0.25"),
            TopologyRoute(start=Point(x=1.5, y=-2.0), end=Point(x=0.0, y=0.25)),
        ),
        (("7", "top.floor-2:4"), TopologyRoute(start=7, end=NodeOf(name="top.floor-2", node=4))),
    ],
)
def test_a_way_is_asked_for_by_nodes_points_or_nodes_elsewhere(
    world: GatewayWorld, ends: tuple[str, str], wanted: TopologyRoute
) -> None:
    library = Library(world)
    answer = world.client.get(f"{ROBOT}/topology/route", params={"from": ends[0], "to": ends[1]})
    assert answer.status_code == 200
    assert answer.json()["way"] == [[0.0, 0.0], [3.0, 0.0]]
    assert answer.json()["floors"][0]["floor"] == "1"
    assert library.asked == [wanted]


@pytest.mark.parametrize("place", ["", "x", "1,", "1,2,3", "nan,1", "-3", "1e5,2", ":4", "../a:4"])
def test_a_place_that_is_none_is_refused(world: GatewayWorld, place: str) -> None:
    Library(world)
    answer = world.client.get(f"{ROBOT}/topology/route", params={"from": "3", "to": place})
    assert answer.status_code == 422
    assert "query.to" in answer.json()["detail"]


def test_a_way_that_there_is_not_is_a_refusal_with_the_reason(world: GatewayWorld) -> None:
    def refuse(_request: Part) -> Part:
        raise RefusedError("no way leads from node 3 to node 4")

    world.answer("topology", "topology_route", refuse)
    answer = world.client.get(f"{ROBOT}/topology/route", params={"from": "3", "to": "4"})
    assert (answer.status_code, answer.json()["detail"]) == (
        409,
        "no way leads from node 3 to node 4",
    )


def test_the_nearest_node_is_told(world: GatewayWorld) -> None:
    library = Library(world)
    answer = world.client.get(f"{ROBOT}/topology/nearest", params={"x": 1, "y": -2.5})
    assert answer.json()["name"] == "door 4"
    assert library.asked == [NearestNode(x=1.0, y=-2.5)]
    assert world.client.get(f"{ROBOT}/topology/nearest", params={"x": 1}).status_code == 422


def test_where_no_topology_service_runs_that_is_said(world: GatewayWorld) -> None:
    answer = world.client.get(f"{ROBOT}/topology/nearest", params={"x": 1, "y": 2})
    assert answer.status_code == 503
    assert "topology: the service is not running" in answer.json()["detail"]


def test_the_library_is_listed(world: GatewayWorld) -> None:
    Library(world)
    listed = world.client.get(LIBRARY).json()["topologies"]
    assert [(one["name"], one["floor"], one["nodes"]) for one in listed] == [("office", "1", 2)]


def test_a_map_is_downloaded_as_the_file_that_it_is(world: GatewayWorld) -> None:
    library = Library(world)
    answer = world.client.get(f"{LIBRARY}/office")
    assert answer.content == FILE
    assert 'filename="office.geojson"' in answer.headers["content-disposition"]
    assert library.asked[-1] == TopologyFetch(name="office")


def test_a_map_is_uploaded_as_it_is(world: GatewayWorld) -> None:
    library = Library(world)
    answer = world.client.put(f"{LIBRARY}/office", content=FILE)
    assert answer.json()["path"] == "office.geojson"
    (stored,) = library.asked
    assert isinstance(stored, TopologyStore)
    assert stored.content.tobytes() == FILE


def test_a_map_is_used_or_deleted_by_its_name(world: GatewayWorld) -> None:
    library = Library(world)
    assert world.client.post(f"{LIBRARY}/office/activate").json()["nodes"] == 2
    assert library.asked[-1] == TopologyLoad(name="office")
    assert world.client.delete(f"{LIBRARY}/office").json() == {"detail": "deleted office"}


@pytest.mark.parametrize(("method", "tail"), [("get", ""), ("post", "/activate"), ("delete", "")])
def test_a_map_that_is_not_there_is_not_found(world: GatewayWorld, method: str, tail: str) -> None:
    Library(world)
    answer = world.client.request(method, f"{LIBRARY}/cellar{tail}")
    assert answer.status_code == 404
    assert "it has office" in answer.json()["detail"]


def test_who_may_only_look_changes_nothing() -> None:
    tokens = {"viewer_tokens": ["v" * 16], "operator_tokens": ["o" * 16]}
    with GatewayWorld(**tokens) as world:
        Library(world)
        viewer: dict[str, Any] = {"headers": {"authorization": f"Bearer {'v' * 16}"}}
        assert world.client.get(LIBRARY, **viewer).status_code == 200
        for method, tail in (("put", ""), ("post", "/activate"), ("delete", "")):
            answer = world.client.request(method, f"{LIBRARY}/office{tail}", **viewer)
            assert answer.status_code == 403


def test_commands_of_whole_numbers_may_say_them_with_a_point(world: GatewayWorld) -> None:
    asked: list[Part] = []

    def link(request: Part) -> Part:
        asked.append(request)
        return Done()

    world.answer("topology", "topology_link", link)
    body = '{"start": {"name": "a", "node": 3.0}, "end": {"name": "b", "node": 4}, "cost": 2}'
    answer = world.client.post(f"{ROBOT}/commands/topology_link", content=body)
    assert answer.status_code == 200
    assert "start=NodeOf(name='a', node=3)" in repr(asked[0])
    spoilt = body.replace("3.0", "3.5")
    assert world.client.post(f"{ROBOT}/commands/topology_link", content=spoilt).status_code == 422


def test_another_map_is_an_event_and_its_growth_is_none(world: GatewayWorld) -> None:
    world.publish("topology", "topology", graph(world.now_ns))
    world.publish("topology", "topology", graph(world.now_ns + 1, edges=()))
    world.publish("topology", "topology", graph(world.now_ns + 2, name="office"))
    for map_id in ("growing-1", "growing-2"):
        drive = graph(world.now_ns + 3, built_from="drive", map_id=map_id)
        world.publish("topology", "topology", drive)
    assert world.events() == [
        "Topological map in use, built from the map: 2 nodes, 1 ways",
        "Topological map office in use, built from the map: 2 nodes, 1 ways",
        "Topological map in use, built from the drive: 2 nodes, 1 ways",
    ]


def test_a_place_reached_is_an_event(world: GatewayWorld) -> None:
    arrival = NodeArrival(
        stamp_ns=world.now_ns, frame_id="map", node=4, name="door 4", matched=5, bound=7
    )
    world.publish("topology", "node_arrival", arrival)
    world.publish("topology", "node_arrival", arrival.model_copy(update={"name": "", "node": 9}))
    assert world.events() == [
        "At door 4: 5 of 7 features seen again",
        "At node 9: 5 of 7 features seen again",
    ]
    assert {event.kind for event in world.service.events.after(0)} == {"place"}


def test_a_pose_found_again_is_an_event_and_one_corrected_is_none(world: GatewayWorld) -> None:
    found = Relocalization(
        stamp_ns=world.now_ns, frame_id="map", node=4, pose=HERE, covariance=np.eye(3), matched=5
    )
    for cause in ("corrected", "recovered", "chain"):
        message = found.model_copy(update={"cause": cause})
        world.publish("topology", "relocalization", message)
    assert world.events() == [
        "Pose found again at a known place, at node 4 by 5 features",
        "Pose found again by a chain of places, at node 4 by 5 features",
    ]
