"""Ways through several floors, from lift to lift."""

from collections.abc import Mapping
from dataclasses import dataclass

from pilotage.topology.routes.floors import Floor
from pilotage.topology.routes.route import (
    USUAL_COSTS,
    Graph,
    NoRouteError,
    Route,
    RouteCosts,
    ways_of,
)

Place = tuple[str, int]
"""The name of a floor, and the id of one of its nodes."""


@dataclass(frozen=True)
class Leg:
    """The part of a way that lies on one floor; `cost` of its route is without the links."""

    floor: str
    route: Route


@dataclass(frozen=True)
class FloorRoute:
    """The legs of a way in order, and what it costs [m] with the links between them."""

    legs: tuple[Leg, ...]
    cost: float


class FloorRouter:
    """Finds ways through floors by name; links to floors or nodes that are not there lead nowhere.

    A link may be driven both ways, whichever floor it is kept with.
    """

    def __init__(self, floors: Mapping[str, Floor], costs: RouteCosts = USUAL_COSTS) -> None:
        self._places = [
            (name, node.id) for name, floor in floors.items() for node in floor.map.nodes
        ]
        self._index = {place: index for index, place in enumerate(self._places)}
        self._edges: list[int | None] = []
        self._ways: list[tuple[int, int, float]] = []
        for name, floor in floors.items():
            index = {node.id: self._index[name, node.id] for node in floor.map.nodes}
            self._edges += [edge.id for edge in floor.map.edges]
            self._ways += ways_of(floor.map, index, costs)
        links = self._links(floors)
        self._edges += [None] * len(links)
        self._ways += links
        self._graph = Graph(len(self._places), self._ways)

    def route(self, start: Place, end: Place) -> FloorRoute:
        """Return the cheapest way; NoRouteError."""
        found = self._graph.cheapest(self._required(start), self._required(end))
        if found is None:
            raise NoRouteError(f"no way leads from {_called(start)} to {_called(end)}")
        cost, nodes, ways = found
        cuts = [i + 1 for i, way in enumerate(ways) if self._edges[way] is None]
        spans = zip([0, *cuts], [*cuts, len(nodes)], strict=True)
        legs = [self._leg(nodes[first:last], ways[first : last - 1]) for first, last in spans]
        return FloorRoute(tuple(legs), cost)

    def _leg(self, nodes: list[int], ways: list[int]) -> Leg:
        edges = [edge for edge in (self._edges[way] for way in ways) if edge is not None]
        cost = sum(self._ways[way][2] for way in ways)
        names = tuple(self._places[node][1] for node in nodes)
        return Leg(self._places[nodes[0]][0], Route(names, tuple(edges), cost))

    def _links(self, floors: Mapping[str, Floor]) -> list[tuple[int, int, float]]:
        found = []
        for name, floor in floors.items():
            for link in floor.links:
                here, there = (name, link.node), (link.name, link.there)
                if here in self._index and there in self._index:
                    found.append((self._index[here], self._index[there], link.cost))
        return found

    def _required(self, place: Place) -> int:
        if place not in self._index:
            raise NoRouteError(f"there is no {_called(place)}")
        return self._index[place]


def _called(place: Place) -> str:
    name, node = place
    return f"node {node} of {name}" if name else f"node {node}"
