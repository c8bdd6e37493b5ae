"""Ways through a topological map: the cheapest one, and the nearest node."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.topology.routes.route_kernels import cheapest_steps, landmark_costs
from pilotage.topology.topological_map import Edge, TopologicalMap

LANDMARKS = 8
"""With so many a search looks at few nodes off the way; each costs a search of all at the start."""


class NoRouteError(ValueError):
    """There is no such way; the text says why."""


@dataclass(frozen=True)
class RouteCosts:
    """What a way costs: its metres, and `door` m for each door on it.

    Two metres are what a slow robot loses by squeezing through at half its speed; a door that has
    to be opened costs more.
    """

    door: float = 2.0


USUAL_COSTS = RouteCosts()


def edge_cost(edge: Edge, doors: frozenset[int], costs: RouteCosts) -> float:
    """Return what an edge costs [m]; `doors`: the ids of the nodes that stand in one.

    Whoever drives through the node of a door pays half of it on each side; an edge through a
    door that has no node pays it whole.
    """
    at_doors = (edge.start in doors) + (edge.end in doors)
    shares = 0.5 * at_doors if at_doors else float(edge.kind == "door")
    return edge.length + costs.door * shares


@dataclass(frozen=True)
class Route:
    """Nodes (n) and edges (n - 1) in order, by id, and what the way costs [m]."""

    nodes: tuple[int, ...]
    edges: tuple[int, ...]
    cost: float


class Graph:
    """Nodes 0 to `count` and ways that lead both ways, (start, end, cost), in compact arrays.

    `landmarks` make searches between two nodes short; who wants all costs needs none.
    """

    def __init__(
        self, count: int, ways: list[tuple[int, int, float]], landmarks: int = LANDMARKS
    ) -> None:
        ends = np.array([(start, end) for start, end, _ in ways], np.int64).reshape(-1, 2)
        costs = np.array([cost for _, _, cost in ways], float)
        sources = np.concatenate([ends[:, 0], ends[:, 1]])
        order = np.argsort(sources, kind="stable")
        counts = np.bincount(sources, minlength=count)
        self._steps = (
            np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            np.concatenate([ends[:, 1], ends[:, 0]])[order],
            np.concatenate([costs, costs])[order],
        )
        self._ways = order % max(1, len(ways))
        self._landmarks = landmark_costs(self._steps, min(landmarks, count))

    def costs_from(self, start: int) -> NDArray[np.float64]:
        """Return what the cheapest way to each node costs (count,), infinite without one."""
        return cheapest_steps(self._steps, np.empty((len(self._steps[0]) - 1, 0)), start, -1)[0]

    def cheapest(self, start: int, end: int) -> tuple[float, list[int], list[int]] | None:
        """Return the cost, the nodes and the ways of the cheapest route; None if there is none."""
        costs, steps = cheapest_steps(self._steps, self._landmarks, start, end)
        if not np.isfinite(costs[end]):
            return None
        nodes = [start, *(int(target) for target in self._steps[1][steps])]
        return float(costs[end]), nodes, [int(way) for way in self._ways[steps]]


class Router:
    """Finds ways through one map."""

    def __init__(self, world: TopologicalMap, costs: RouteCosts = USUAL_COSTS) -> None:
        self._nodes = [node.id for node in world.nodes]
        self._index = {node: index for index, node in enumerate(self._nodes)}
        self._edges = [edge.id for edge in world.edges]
        self._places = world.places[:, :2]
        self._graph = Graph(len(self._nodes), ways_of(world, self._index, costs))

    def route(self, start: int, end: int) -> Route:
        """Return the cheapest way from node to node; NoRouteError."""
        found = self._graph.cheapest(self._required(start), self._required(end))
        if found is None:
            raise NoRouteError(f"no way leads from node {start} to node {end}")
        cost, nodes, edges = found
        by_id = tuple(self._nodes[node] for node in nodes)
        return Route(by_id, tuple(self._edges[edge] for edge in edges), cost)

    def nearest(self, point: ArrayLike) -> tuple[int, float]:
        """Return the node nearest to a point (2,) and how far it is [m]; NoRouteError."""
        if not self._nodes:
            raise NoRouteError("the map has no nodes")
        x, y = np.asarray(point, float)[:2]
        metres = np.hypot(self._places[:, 0] - x, self._places[:, 1] - y)
        index = int(metres.argmin())
        return self._nodes[index], float(metres[index])

    def _required(self, node: int) -> int:
        if node not in self._index:
            raise NoRouteError(f"there is no node {node}")
        return self._index[node]


def ways_of(
    world: TopologicalMap, index: Mapping[int, int], costs: RouteCosts
) -> list[tuple[int, int, float]]:
    """Return the edges of a map as a Graph takes them; `index` numbers the nodes by id."""
    doors = frozenset(node.id for node in world.nodes if node.kind == "door")
    return [
        (index[edge.start], index[edge.end], edge_cost(edge, doors, costs)) for edge in world.edges
    ]


def way_along(world: TopologicalMap, route: Route) -> NDArray[np.float64]:
    """Return the polyline (n, 2) in map of a route, no point twice in a row."""
    edges = {edge.id: edge for edge in world.edges}
    poses = {node.id: node.pose for node in world.nodes}
    pieces = [poses[route.nodes[0]][None, :2]]
    for node, name in zip(route.nodes, route.edges, strict=False):
        edge = edges[name]
        pieces.append(edge.way if edge.start == node else edge.way[::-1])
    pieces.append(poses[route.nodes[-1]][None, :2])
    way = np.concatenate(pieces)
    is_new = np.any(np.diff(way, axis=0) != 0.0, axis=1)
    kept: NDArray[np.float64] = way[np.concatenate([[True], is_new])]
    return kept
