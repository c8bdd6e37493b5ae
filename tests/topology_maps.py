"""Small topological maps for tests."""

from collections.abc import Iterable

import numpy as np

from pilotage.topology.features import KINDS, FeatureKind, Features
from pilotage.topology.topological_map import Edge, EdgeKind, Node, NodeKind, TopologicalMap

Place = tuple[float, float] | tuple[float, float, NodeKind]
Way = tuple[int, int] | tuple[int, int, EdgeKind]


def features(*each: tuple[FeatureKind, float, float, float]) -> Features:
    """Features of kind, x, y, theta; doors and passages are 0.9 m wide."""
    return Features(
        np.array([KINDS.index(kind) for kind, *_ in each], np.int64),
        np.array([pose for _, *pose in each], float).reshape(-1, 3),
        np.array([np.nan if kind == "corner" else 0.9 for kind, *_ in each]),
        np.tile(0.01 * np.eye(2), (len(each), 1, 1)),
    )


def node(identity: int, x: float, y: float, kind: NodeKind = "node") -> Node:
    """A node that looks along x, with nothing bound to it."""
    return Node(identity, kind, f"{kind} {identity}", np.array([x, y, 0.0]), Features.none())


def graph(places: Iterable[Place], ways: Iterable[Way], map_id: str = "0123") -> TopologicalMap:
    """Nodes 0, 1, 2 ... at places (x, y[, kind]), and straight edges (start, end[, kind])."""
    nodes = [node(i, *place) for i, place in enumerate(places)]
    edges = []
    for i, (start, end, *kind) in enumerate(ways):
        way = np.stack([nodes[start].pose[:2], nodes[end].pose[:2]])
        length = float(np.hypot(*(way[1] - way[0])))
        named: EdgeKind = kind[0] if kind else "corridor"
        edges.append(Edge(len(nodes) + i, start, end, named, length, way))
    return TopologicalMap(map_id, tuple(nodes), tuple(edges))


CORRIDOR = graph(
    [(0.0, 0.0), (4.0, 0.0), (4.0, 2.0, "door"), (4.0, 5.0), (8.0, 0.0)],
    [(0, 1), (1, 2, "door"), (2, 3, "door"), (1, 4)],
)
"""A corridor along x with one room behind a door at x = 4 m."""
