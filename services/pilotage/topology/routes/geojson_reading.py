"""Reads a topological map from GeoJSON: ours, or a graph that nav2_route would read."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import cast, get_args

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.features import KINDS, FeatureKind, Features
from pilotage.topology.routes.floors import BuiltFrom, Floor, Link
from pilotage.topology.routes.strict_json import JsonError, Value
from pilotage.topology.topological_map import (
    Edge,
    EdgeKind,
    Node,
    NodeKind,
    Spacing,
    TopologicalMap,
)

MOST_NODES, MOST_EDGES = 100_000, 400_000
"""What a message can carry."""

LINES = ("MultiLineString", "LineString")
Places = dict[int, NDArray[np.float64]]
"""Points (2,) of the nodes by id."""


@dataclass(frozen=True)
class Backward:
    """An edge once more, from its end to its start: all else stands with edge `of`."""

    of: int
    start: int
    end: int
    feature: Value


def floor_of(document: object) -> Floor:
    """Return a floor; JsonError if the document is no map that can be used."""
    whole = Value(document)
    whole.member("type").one_of(("FeatureCollection",))
    points, lines = _by_geometry(whole)
    _require_unique_ids([*points, *lines])
    nodes = tuple(_node(feature) for feature in points)
    places = {node.id: node.pose[:2] for node in nodes}
    return Floor(
        map=TopologicalMap(_text(whole, "map_id"), nodes, _edges(lines, places)),
        name=_text(whole, "name"),
        label=_text(whole, "floor"),
        built_from=cast("BuiltFrom", _word(whole, "built_from", get_args(BuiltFrom))),
        spacing=cast("Spacing", _word(whole, "spacing", get_args(Spacing))),
        links=tuple(_links(whole, places)),
    )


def _by_geometry(whole: Value) -> tuple[list[Value], list[Value]]:
    """Return the nodes and the edges."""
    points: list[Value] = []
    lines: list[Value] = []
    for feature in whole.member("features").items():
        feature.member("type").one_of(("Feature",))
        kind = feature.member("geometry").member("type").one_of(("Point", *LINES))
        (points if kind == "Point" else lines).append(feature)
    if len(points) > MOST_NODES or len(lines) > 2 * MOST_EDGES:
        raise JsonError(f"{len(points)} nodes and {len(lines)} edges are too many")
    return points, lines


def _require_unique_ids(features: list[Value]) -> None:
    seen: set[int] = set()
    for feature in features:
        identity = feature.member("properties").member("id")
        if identity.identity() in seen:
            raise JsonError(f"{identity.path}: the id {identity.identity()} is taken already")
        seen.add(identity.identity())


def _node(feature: Value) -> Node:
    properties = feature.member("properties")
    frame = properties.optional("frame")
    if frame is not None:
        frame.one_of(("map",))
    theta, features = properties.optional("theta"), properties.optional("features")
    x, y = _array(feature.member("geometry").member("coordinates"), 2)
    return Node(
        id=properties.member("id").identity(),
        kind=cast("NodeKind", _word(properties, "kind", get_args(NodeKind))),
        name=_text(properties, "name"),
        pose=np.array([x, y, 0.0 if theta is None else theta.angle()]),
        features=Features.none() if features is None else _features(features),
    )


def _features(listed: Value) -> Features:
    parts = []
    for one in listed.items():
        kind = KINDS.index(cast("FeatureKind", one.member("kind").one_of(KINDS)))
        width = one.optional("width")
        covariance = [_array(row, 2) for row in one.member("covariance").items()]
        if len(covariance) != 2:
            raise JsonError(f"{one.path}.covariance must have 2 rows")
        parts.append(
            Features(
                np.array([kind]),
                _pose(one.member("pose"))[None],
                np.array([np.nan if width is None else width.not_negative()]),
                np.array(covariance)[None],
            )
        )
    return Features.joined(parts)


def _pose(value: Value) -> NDArray[np.float64]:
    pose = _array(value, 3)
    [*value.items()][2].angle()
    return pose


def _edge(feature: Value, places: Places) -> Edge:
    properties = feature.member("properties")
    start, end = (_end(properties.member(name), places) for name in ("startid", "endid"))
    way = _way(feature.member("geometry"))
    if way is None:
        way = np.stack([places[start], places[end]])
    length = properties.optional("length")
    metres = float(np.hypot(*np.diff(way, axis=0).T).sum())
    return Edge(
        id=properties.member("id").identity(),
        start=start,
        end=end,
        kind=cast("EdgeKind", _word(properties, "class", get_args(EdgeKind))),
        length=metres if length is None else length.not_negative(),
        way=way,
    )


def _end(value: Value, places: Places) -> int:
    if value.identity() not in places:
        raise JsonError(f"{value.path}: there is no node {value.identity()}")
    return value.identity()


def _way(geometry: Value) -> NDArray[np.float64] | None:
    """Return the polyline (k, 2); None for a straight line: nav2's own files have none."""
    coordinates = geometry.optional("coordinates")
    if coordinates is None:
        return None
    is_single = geometry.member("type").json == "LineString"
    lines = [coordinates] if is_single else [*coordinates.items()]
    points = [_numbers(point, 2) for line in lines for point in line.items()]
    if len(points) == 1:
        raise JsonError(f"{coordinates.path}: a line has two points at least")
    return np.array(points) if points else None


def _edges(lines: list[Value], places: Places) -> tuple[Edge, ...]:
    """Return the edges, each of which must be there in both directions, as one each."""
    forward: dict[int, tuple[Edge, Value]] = {}
    backward: list[Backward] = []
    for feature in lines:
        properties = feature.member("properties")
        reverse_of = properties.optional("reverse_of")
        if reverse_of is None:
            edge = _edge(feature, places)
            forward[edge.id] = (edge, feature)
        else:
            start, end = (_end(properties.member(name), places) for name in ("startid", "endid"))
            backward.append(Backward(reverse_of.identity(), start, end, feature))
    unpaired = dict(forward)
    for one in backward:
        known = unpaired.pop(one.of, None)
        if known is None or (one.start, one.end) != (known[0].end, known[0].start):
            raise JsonError(f"{one.feature.path}: it is not edge {one.of} backward")
    doubles = _doubles(list(unpaired.values()))
    return tuple(edge for edge, _ in forward.values() if edge.id not in doubles)


def _doubles(edges: list[tuple[Edge, Value]]) -> set[int]:
    """Return the edges that are others backward, where the file does not say so itself."""
    waiting: dict[tuple[int, int], list[Value]] = {}
    found: set[int] = set()
    for edge, feature in edges:
        if waiting.get((edge.end, edge.start)):
            waiting[edge.end, edge.start].pop(0)
            found.add(edge.id)
        elif edge.start != edge.end:
            waiting.setdefault((edge.start, edge.end), []).append(feature)
    for (start, end), lonely in waiting.items():
        for feature in lonely:
            raise JsonError(
                f"{feature.path}: no edge leads back from node {end} to {start}; "
                "ways must lead both ways"
            )
    return found


def _links(whole: Value, places: Places) -> Iterable[Link]:
    listed = whole.optional("links")
    for link in () if listed is None else listed.items():
        yield Link(
            _end(link.member("node"), places),
            link.member("name").text(),
            link.member("there").identity(),
            link.member("cost").not_negative(),
        )


def _array(value: Value, length: int) -> NDArray[np.float64]:
    """Return an array (length,); a point may have a height, which is passed over."""
    return np.array(_numbers(value, length))


def _numbers(value: Value, length: int) -> list[float]:
    numbers = [item.number() for item in value.items()]
    if len(numbers) != length and not (length == 2 and len(numbers) == 3):
        raise JsonError(f"{value.path} must have {length} numbers")
    return numbers[:length]


def _text(value: Value, name: str) -> str:
    found = value.optional(name)
    return "" if found is None else found.text()


def _word(value: Value, name: str, words: tuple[str, ...]) -> str:
    """Return a word of a member, the first one where there is none."""
    found = value.optional(name)
    return words[0] if found is None else found.one_of(words)
