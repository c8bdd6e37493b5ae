"""Routes by networkx, and a graph of nav2's read as its route server reads it."""

from typing import Any

import networkx as nx

from pilotage.topology.routes.route import RouteCosts, edge_cost
from pilotage.topology.topological_map import TopologicalMap


def networkx_of(world: TopologicalMap, costs: RouteCosts) -> "nx.MultiGraph[int]":
    """Return a map as networkx has it."""
    graph: nx.MultiGraph[int] = nx.MultiGraph()
    graph.add_nodes_from(node.id for node in world.nodes)
    doors = frozenset(node.id for node in world.nodes if node.kind == "door")
    for edge in world.edges:
        graph.add_edge(edge.start, edge.end, edge.id, cost=edge_cost(edge, doors, costs))
    return graph


def route_cost(world: TopologicalMap, start: int, end: int, costs: RouteCosts) -> float | None:
    """Return what the cheapest way costs; None if there is none."""
    try:
        return float(nx.dijkstra_path_length(networkx_of(world, costs), start, end, "cost"))
    except nx.NetworkXNoPath:
        return None


def read_as_nav2_route(document: dict[str, Any]) -> "nx.DiGraph[int]":
    """Return the directed graph that nav2's GeoJsonGraphFileLoader would make of a file."""
    graph: nx.DiGraph[int] = nx.DiGraph()
    features = document["features"]
    for feature in features:
        if feature["geometry"]["type"] == "Point":
            x, y = feature["geometry"]["coordinates"][:2]
            properties = feature["properties"]
            graph.add_node(properties["id"], x=x, y=y, frame=properties.get("frame"))
    for feature in features:
        if feature["geometry"]["type"] in ("MultiLineString", "LineString"):
            edge = feature["properties"]
            assert edge["startid"] in graph
            assert edge["endid"] in graph
            graph.add_edge(edge["startid"], edge["endid"], id=edge["id"], cost=edge["cost"])
    return graph
