"""Topological maps as GeoJSON, as nav2_route reads it."""

import copy
import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import networkx as nx
import numpy as np
import pytest
from geojson_pydantic import FeatureCollection

from naive.routes import read_as_nav2_route
from pilotage.topology.routes.floors import Floor, Link
from pilotage.topology.routes.geojson import (
    floor_from_geojson,
    floor_to_geojson,
    from_geojson,
    to_geojson,
)
from pilotage.topology.routes.route import Router
from pilotage.topology.routes.strict_json import JsonError
from pilotage.topology.topological_map import TopologicalMap
from topology_maps import CORRIDOR, features

SEEN = features(("corner", 3.5, 1.0, 0.7), ("door", 4.0, 2.0, 1.5))
WORLD = TopologicalMap(
    "0123", (replace(CORRIDOR.nodes[0], features=SEEN), *CORRIDOR.nodes[1:]), CORRIDOR.edges
)


def test_it_is_geojson() -> None:
    collection: FeatureCollection[Any] = FeatureCollection.model_validate_json(
        json.dumps(to_geojson(WORLD))
    )
    kinds = [feature.geometry.type for feature in collection.features if feature.geometry]
    assert kinds == ["Point"] * 5 + ["MultiLineString"] * 8


def test_a_node_says_what_nav2_wants_to_know_and_what_is_bound_to_it() -> None:
    node = to_geojson(WORLD)["features"][0]
    assert node["geometry"] == {"type": "Point", "coordinates": [0.0, 0.0]}
    assert node["properties"]["id"] == 0
    assert node["properties"]["frame"] == "map"
    assert node["properties"]["kind"] == "node"
    assert [one["kind"] for one in node["properties"]["features"]] == ["corner", "door"]
    assert node["properties"]["features"][0]["width"] is None


def test_each_edge_is_written_in_both_directions_with_an_id_of_its_own() -> None:
    document = to_geojson(WORLD)
    ids = [feature["properties"]["id"] for feature in document["features"]]
    assert len(set(ids)) == len(ids)
    there, back = document["features"][5:7]
    ends = {"startid": 0, "endid": 1}
    assert there["properties"] | ends == there["properties"]
    assert back["properties"] | {"startid": 1, "endid": 0} == back["properties"]
    assert back["geometry"]["coordinates"] == [there["geometry"]["coordinates"][0][::-1]]


def test_nav2_finds_the_routes_in_it_that_we_find() -> None:
    graph = read_as_nav2_route(to_geojson(WORLD))
    for start in range(5):
        for end in range(5):
            cost = nx.dijkstra_path_length(graph, start, end, "cost")
            assert cost == pytest.approx(Router(WORLD).route(start, end).cost)


def test_what_nav2_reads_as_metadata_is_of_the_types_that_it_knows() -> None:
    for feature in to_geojson(WORLD)["features"]:
        metadata = feature["properties"].get("metadata", {})
        assert all(isinstance(value, str) for value in metadata.values())


def test_a_date_is_written_only_if_it_is_given() -> None:
    assert "date_generated" not in to_geojson(WORLD)
    assert to_geojson(WORLD, "2026-11-23")["date_generated"] == "2026-11-23"


def test_what_is_known_of_a_floor_comes_back() -> None:
    links = (Link(2, "upstairs", 7, 12.0),)
    floor = Floor(CORRIDOR, "office", "ground floor", "drive", "equal", links)
    read = floor_from_geojson(json.loads(json.dumps(floor_to_geojson(floor))))
    assert replace(read, map=CORRIDOR) == floor


def nav2_graph() -> dict[str, Any]:
    """A graph as nav2's tools write it: no kinds, edges without coordinates."""

    def node(identity: int, x: float) -> dict[str, Any]:
        return {
            "type": "Feature",
            "geometry": {"type": "Point", "coordinates": [x, 0.0]},
            "properties": {"id": identity, "frame": "map"},
        }

    def edge(identity: int, start: int, end: int) -> dict[str, Any]:
        return {
            "type": "Feature",
            "geometry": {"type": "MultiLineString"},
            "properties": {"id": identity, "startid": start, "endid": end, "cost": 0.0},
        }

    features = [node(0, 0.0), node(1, 3.0), node(2, 7.0)]
    features += [edge(10, 0, 1), edge(11, 1, 0), edge(12, 2, 1), edge(13, 1, 2)]
    return {"type": "FeatureCollection", "name": "graph", "features": features}


def test_a_graph_of_nav2_is_read_with_each_pair_of_edges_as_one() -> None:
    world = from_geojson(nav2_graph())
    assert [(edge.id, edge.start, edge.end) for edge in world.edges] == [(10, 0, 1), (12, 2, 1)]
    assert [edge.length for edge in world.edges] == [3.0, 4.0]
    assert {node.kind for node in world.nodes} == {"node"}
    np.testing.assert_array_equal(world.edges[0].way, [[0.0, 0.0], [3.0, 0.0]])


def test_a_one_way_edge_is_refused() -> None:
    document = nav2_graph()
    del document["features"][-1]
    with pytest.raises(JsonError, match=r"features\[5\]: no edge leads back from node 1 to 2"):
        from_geojson(document)


Spoil = Callable[[dict[str, Any]], object]


def node_property(name: str, value: object) -> Spoil:
    return lambda document: document["features"][1]["properties"].update({name: value})


def edge_property(name: str, value: object) -> Spoil:
    return lambda document: document["features"][5]["properties"].update({name: value})


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda d: d.update(type="Feature"), "type must be one of FeatureCollection"),
        (lambda d: d.pop("features"), "features is missing"),
        (lambda d: d.update(features={}), "features must be an array"),
        (lambda d: d["features"].append(None), r"features\[13\] must be an object"),
        (lambda d: d["features"][2].pop("geometry"), r"features\[2\].geometry is missing"),
        (
            lambda d: d["features"][2]["geometry"].update(type="Polygon"),
            r"geometry.type must be one of Point",
        ),
        (
            lambda d: d["features"][2]["geometry"].update(coordinates=[1.0]),
            "coordinates must have 2 numbers",
        ),
        (
            lambda d: d["features"][2]["geometry"].update(coordinates=[1.0, float("nan")]),
            r"coordinates\[1\] must be a number no larger",
        ),
        (
            lambda d: d["features"][5]["geometry"].update(coordinates=[[[1.0, 1.0]]]),
            "a line has two points",
        ),
        (node_property("id", 0), "the id 0 is taken already"),
        (node_property("id", value=True), "id must be a whole number"),
        (node_property("id", 2.5), "id must be a whole number"),
        (node_property("id", -1), "id must be a whole number"),
        (node_property("id", 2**31), "id must be a whole number"),
        (node_property("kind", "window"), "kind must be one of node, door, corner, passage"),
        (node_property("kind", ["door"]), "kind must be one of"),
        (node_property("frame", "odom"), "frame must be one of map"),
        (node_property("name", "x" * 65), "name must be a text of at most 64 letters"),
        (node_property("theta", 4.0), r"theta must be an angle in \[-pi, pi\]"),
        (node_property("features", [{"kind": "corner"}]), r"covariance is missing"),
        (edge_property("startid", 99), "startid: there is no node 99"),
        (edge_property("endid", None), "endid is missing"),
        (edge_property("length", -1.0), "length must not be negative"),
        (edge_property("class", "stairs"), "class must be one of corridor"),
        (edge_property("endid", 3), r"features\[6\]: it is not edge 5 backward"),
        (
            lambda d: d.update(links=[{"node": 77, "name": "up", "there": 1, "cost": 1.0}]),
            "there is no node 77",
        ),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(spoil: Spoil, reason: str) -> None:
    document = copy.deepcopy(to_geojson(WORLD))
    spoil(document)
    with pytest.raises(JsonError, match=reason) as caught:
        from_geojson(document)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("document", [None, [], "map", 3, {}])
def test_what_is_no_document_is_refused(document: object) -> None:
    with pytest.raises(JsonError):
        from_geojson(document)
