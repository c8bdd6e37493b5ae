"""Answers what the topology service is asked: to build, to keep, and for ways and places."""

from collections.abc import Callable

import numpy as np

from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.topology import messages
from pilotage.topology.map_choice import WORK_S, MapChoice
from pilotage.topology.routes.floor_routes import Place
from pilotage.topology.routes.floors import Floor
from pilotage.topology.routes.route import NoRouteError
from pilotage.topology.storage import LibraryError, Stored, packed
from pilotage_schemas import topology as t
from pilotage_schemas.commands import Done, Nothing

FARTHEST = 10.0
"""m from a point to the nearest node beyond which a route would not begin or end there."""


class Queries:
    """Answers queries; whatever is refused leaves everything as it was.

    `build(request)` builds a map anew and returns it.
    """

    def __init__(
        self, node: Node, at: MapChoice, build: Callable[[t.TopologyBuild], Floor]
    ) -> None:
        self._node = node
        self._at = at
        node.answer("topology_build", lambda request: _loaded(build(request)))
        node.answer("topology_save", self.save)
        node.answer("topology_load", self.load)
        node.answer("topology_link", self.link)
        node.answer("topology_route", self.route)
        node.answer("nearest_node", self.nearest)
        node.answer("topology_list", self.list)
        node.answer("topology_delete", self.delete)
        node.answer("topology_fetch", self.fetch)
        node.answer("topology_store", self.store)

    def save(self, request: t.TopologySave) -> t.TopologySaved:
        """Keep the map in use."""
        try:
            path = self._at.save(request.name, request.floor)
        except LibraryError as error:
            raise RefusedError(str(error)) from error
        return _saved(self._at.required, path)

    def load(self, request: t.TopologyLoad) -> t.TopologyLoaded:
        """Use a map of the library."""
        try:
            return _loaded(self._at.load(request.name))
        except LibraryError as error:
            raise RefusedError(str(error)) from error

    def link(self, request: t.TopologyLink) -> Done:
        """Join two maps of the library."""
        ends = [(end.name, end.node) for end in (request.start, request.end)]
        try:
            floors = self._at.library.link(ends[0], ends[1], request.cost)
        except LibraryError as error:
            raise RefusedError(str(error)) from error
        here = self._at.floor
        for floor in floors:
            if here is not None and here.name == floor.name:
                # What was changed since it was saved stays; only the link is new.
                self._at.use(here.linked(floor.links[-1]))
        return Done(detail=f"{request.start.name} and {request.end.name} are joined")

    def route(self, request: t.TopologyRoute) -> t.Route:
        """Return the cheapest way."""
        try:
            found, floors = self._at.route(self._place(request.start), self._place(request.end))
        except NoRouteError as error:
            raise RefusedError(str(error)) from error
        return messages.route_message(found, floors)

    def nearest(self, request: t.NearestNode) -> t.NodeFound:
        """Return the nearest node."""
        try:
            identity, metres = self._at.router.nearest((request.x, request.y))
        except NoRouteError as error:
            raise RefusedError(str(error)) from error
        node = next(node for node in self._at.required.map.nodes if node.id == identity)
        pose = messages.pose_of(node.pose)
        return t.NodeFound(node=identity, name=node.name[:64], pose=pose, distance=metres)

    def list(self, _request: Nothing) -> t.TopologyList:
        """Say what the library has."""
        return t.TopologyList(topologies=tuple(_stored(one) for one in self._at.library.all()))

    def delete(self, request: t.TopologyDelete) -> Done:
        """Delete a map of the library."""
        try:
            self._at.library.delete(request.name)
        except LibraryError as error:
            raise RefusedError(str(error)) from error
        return Done(detail=f"deleted {request.name}")

    def fetch(self, request: t.TopologyFetch) -> t.TopologyFile:
        """Return a map as GeoJSON: one of the library, or without a name the one in use."""
        try:
            name = request.name
            content = self._at.library.read(name) if name else packed(self._at.required)
        except LibraryError as error:
            raise RefusedError(str(error)) from error
        return t.TopologyFile(content=np.frombuffer(content, np.int8))

    def store(self, request: t.TopologyStore) -> t.TopologySaved:
        """Take a map into the library."""
        try:
            with self._node.busy(WORK_S):
                floor = self._at.library.store(request.name, request.content.tobytes())
        except LibraryError as error:
            raise RefusedError(str(error)) from error
        return _saved(floor, f"{floor.name}.geojson")

    def _place(self, wanted: int | t.Point | t.NodeOf) -> Place:
        here = self._at.required
        if isinstance(wanted, t.NodeOf):
            return wanted.name, wanted.node
        if isinstance(wanted, t.Point):
            node, metres = self._at.router.nearest((wanted.x, wanted.y))
            if metres > FARTHEST:
                where = f"({wanted.x:.2f}, {wanted.y:.2f})"
                raise NoRouteError(
                    f"{where} is off the map: node {node}, {metres:.0f} m away, is next"
                )
            return here.name, node
        return here.name, wanted


def _loaded(floor: Floor) -> t.TopologyLoaded:
    world = floor.map
    return t.TopologyLoaded(map_id=world.map_id, nodes=len(world.nodes), edges=len(world.edges))


def _saved(floor: Floor, path: str) -> t.TopologySaved:
    return t.TopologySaved(name=floor.name, map_id=floor.map.map_id, path=path)


def _stored(stored: Stored) -> t.StoredTopology:
    floor = stored.floor
    return t.StoredTopology(
        name=floor.name,
        map_id=floor.map.map_id,
        floor=floor.label,
        nodes=len(floor.map.nodes),
        edges=len(floor.map.edges),
        saved_ns=stored.saved_ns,
    )
