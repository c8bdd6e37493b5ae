"""Topological maps as GeoJSON, as nav2_route reads it (its GeoJsonGraphFileLoader).

Nodes are Points with `id` and `frame`, edges MultiLineStrings with `id`, `startid`, `endid` and
`cost`; ids are unique. nav2's edges lead one way, so each edge is written twice: the second time
backward, with an id of its own and `reverse_of`. What nav2 does not know it passes over: of the
collection `map_id`, `floor`, `links` and how it was built, of nodes their name, `theta` and bound
`features`, of edges their `class` and `length`. So a file that is read again has lost nothing.
Coordinates are metres in `frame`, not longitude and latitude, as in nav2's own files.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.features import KINDS, Features
from pilotage.topology.routes import geojson_reading
from pilotage.topology.routes.floors import Floor
from pilotage.topology.routes.route import USUAL_COSTS, RouteCosts, edge_cost
from pilotage.topology.topological_map import Edge, Node, TopologicalMap

Json = dict[str, Any]
FRAME = "map"


def to_geojson(world: TopologicalMap, date_generated: str | None = None) -> Json:
    """Return a map as a FeatureCollection; the date is written only if it is given."""
    return floor_to_geojson(Floor(world), date_generated)


def from_geojson(document: object) -> TopologicalMap:
    """Return the map of a FeatureCollection; JsonError names the first fault."""
    return floor_from_geojson(document).map


def floor_to_geojson(
    floor: Floor, date_generated: str | None = None, costs: RouteCosts = USUAL_COSTS
) -> Json:
    """Return a map with its name, its floor and its links as a FeatureCollection."""
    links = [
        {"node": link.node, "name": link.name, "there": link.there, "cost": link.cost}
        for link in floor.links
    ]
    dated = {} if date_generated is None else {"date_generated": date_generated}
    return {
        "type": "FeatureCollection",
        "name": floor.name,
        "map_id": floor.map.map_id,
        "floor": floor.label,
        "built_from": floor.built_from,
        "spacing": floor.spacing,
        "links": links,
        **dated,
        "features": [_node(node) for node in floor.map.nodes] + _edges(floor.map, costs),
    }


def floor_from_geojson(document: object) -> Floor:
    """Return what `floor_to_geojson` wrote, or a graph of nav2's; JsonError."""
    return geojson_reading.floor_of(document)


def _node(node: Node) -> Json:
    x, y, theta = (float(number) for number in node.pose)
    properties = {
        "id": node.id,
        "frame": FRAME,
        "kind": node.kind,
        "name": node.name,
        "theta": theta,
        "features": _features(node.features),
    }
    return _feature({"type": "Point", "coordinates": [x, y]}, properties)


def _features(features: Features) -> list[Json]:
    rows = zip(features.kinds, features.poses, features.widths, features.covariances, strict=True)
    return [
        {
            "kind": KINDS[kind],
            "pose": pose.tolist(),
            "width": None if np.isnan(width) else float(width),
            "covariance": covariance.tolist(),
        }
        for kind, pose, width, covariance in rows
    ]


def _edges(world: TopologicalMap, costs: RouteCosts) -> list[Json]:
    doors = frozenset(node.id for node in world.nodes if node.kind == "door")
    places = {node.id: node.pose[:2] for node in world.nodes}
    taken = [node.id for node in world.nodes] + [edge.id for edge in world.edges]
    backward_id = max(taken, default=-1) + 1
    written = []
    for i, edge in enumerate(world.edges):
        facts = {
            "cost": float(edge_cost(edge, doors, costs)),
            "class": edge.kind,
            "length": float(edge.length),
            # What nav2's SemanticScorer weighs.
            "metadata": {"class": edge.kind},
        }
        way = _drawn(edge, places)
        ends = {"id": edge.id, "startid": edge.start, "endid": edge.end}
        back = {"id": backward_id + i, "startid": edge.end, "endid": edge.start}
        written.append(_feature(_line(way), ends | facts))
        written.append(_feature(_line(way[::-1]), back | facts | {"reverse_of": edge.id}))
    return written


def _drawn(edge: Edge, places: dict[int, NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return a polyline of an edge; a line of GeoJSON has two points at least."""
    if len(edge.way) >= 2:
        return edge.way
    return np.stack([places[edge.start], places[edge.end]])


def _line(way: NDArray[np.float64]) -> Json:
    return {"type": "MultiLineString", "coordinates": [way.tolist()]}


def _feature(geometry: Json, properties: Json) -> Json:
    return {"type": "Feature", "geometry": geometry, "properties": properties}
