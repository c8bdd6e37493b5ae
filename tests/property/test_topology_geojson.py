"""Whatever a topological map holds, its GeoJSON gives it back and is GeoJSON."""

import contextlib
import json
import math
from typing import get_args

import numpy as np
from geojson_pydantic import FeatureCollection
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pilotage.topology.features import KINDS, Features
from pilotage.topology.routes.floors import Floor, Link
from pilotage.topology.routes.geojson import floor_from_geojson, floor_to_geojson
from pilotage.topology.routes.strict_json import JsonError
from pilotage.topology.topological_map import Edge, EdgeKind, Node, NodeKind, TopologicalMap

METRES = st.floats(-1e6, 1e6)
ANGLES = st.floats(-math.pi, math.pi)
NODE_KINDS: tuple[NodeKind, ...] = get_args(NodeKind)
EDGE_KINDS: tuple[EdgeKind, ...] = get_args(EdgeKind)
NAMES = st.text(max_size=12)
IDS = st.integers(0, 2**31 - 100)


@st.composite
def poses(draw: st.DrawFn) -> np.ndarray:
    return np.array([draw(METRES), draw(METRES), draw(ANGLES)])


@st.composite
def bound(draw: st.DrawFn) -> Features:
    n = draw(st.integers(0, 3))
    kinds = draw(arrays(np.int64, n, elements=st.integers(0, len(KINDS) - 1)))
    widths = draw(arrays(float, n, elements=st.floats(0.0, 5.0)))
    widths[kinds == 0] = np.nan
    covariances = draw(arrays(float, (n, 2, 2), elements=METRES))
    each = [draw(poses()) for _ in range(n)]
    return Features(kinds, np.array(each).reshape(-1, 3), widths, covariances)


@st.composite
def floors(draw: st.DrawFn) -> Floor:
    ids = draw(st.lists(IDS, unique=True, max_size=8))
    split = draw(st.integers(0, len(ids)))
    kinds = st.sampled_from(NODE_KINDS)
    nodes = tuple(
        Node(i, draw(kinds), draw(NAMES), draw(poses()), draw(bound())) for i in ids[:split]
    )
    edges: tuple[Edge, ...] = ()
    links: tuple[Link, ...] = ()
    if nodes:
        ends = st.sampled_from(ids[:split])
        ways = arrays(float, st.tuples(st.integers(2, 5), st.just(2)), elements=METRES)
        leads = st.sampled_from(EDGE_KINDS)
        lengths = st.floats(0.0, 1e6)
        edges = tuple(
            Edge(i, draw(ends), draw(ends), draw(leads), draw(lengths), draw(ways))
            for i in ids[split:]
        )
        links = tuple(draw(st.lists(st.builds(Link, ends, NAMES, IDS, lengths), max_size=2)))
    return Floor(
        TopologicalMap(draw(NAMES), nodes, edges),
        draw(NAMES),
        draw(NAMES),
        draw(st.sampled_from(("map", "drive"))),
        draw(st.sampled_from(("variable", "equal"))),
        links,
    )


def assert_same(one: TopologicalMap, other: TopologicalMap) -> None:
    """Compare every number of two maps, bit by bit."""
    assert one.map_id == other.map_id
    assert len(one.nodes) == len(other.nodes)
    for a, b in zip(one.nodes, other.nodes, strict=True):
        assert (a.id, a.kind, a.name) == (b.id, b.kind, b.name)
        for name in ("kinds", "poses", "widths", "covariances"):
            np.testing.assert_array_equal(getattr(a.features, name), getattr(b.features, name))
        np.testing.assert_array_equal(a.pose, b.pose)
    assert len(one.edges) == len(other.edges)
    for c, d in zip(one.edges, other.edges, strict=True):
        assert (c.id, c.start, c.end, c.kind, c.length) == (d.id, d.start, d.end, d.kind, d.length)
        np.testing.assert_array_equal(c.way, d.way)


@given(floors())
def test_a_floor_that_was_written_and_read_has_lost_nothing(floor: Floor) -> None:
    text = json.dumps(floor_to_geojson(floor), allow_nan=False)
    read = floor_from_geojson(json.loads(text))
    assert_same(read.map, floor.map)
    assert (read.name, read.label, read.built_from) == (floor.name, floor.label, floor.built_from)
    assert (read.spacing, read.links) == (floor.spacing, floor.links)


@given(floors())
def test_what_is_written_is_geojson_with_unique_ids(floor: Floor) -> None:
    document = floor_to_geojson(floor)
    FeatureCollection.model_validate_json(json.dumps(document))
    ids = [feature["properties"]["id"] for feature in document["features"]]
    assert len(ids) == len(set(ids)) == len(floor.map.nodes) + 2 * len(floor.map.edges)


@given(floors(), st.data())
def test_a_reader_survives_any_hole_in_a_document(floor: Floor, data: st.DataObject) -> None:
    document = floor_to_geojson(floor)
    holes = [document] + [feature["properties"] for feature in document["features"]]
    hole = data.draw(st.sampled_from(holes))
    hole[data.draw(st.sampled_from(sorted(hole)))] = data.draw(
        st.none() | st.integers() | st.floats() | st.text(max_size=3) | st.lists(st.none())
    )
    with contextlib.suppress(JsonError):
        floor_from_geojson(document)
