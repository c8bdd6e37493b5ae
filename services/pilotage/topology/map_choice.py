"""Which topological map is in use: one that is kept, one built from the map, or one that grows."""

from dataclasses import replace

from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.core.grid import OccupancyMap
from pilotage.topology import messages
from pilotage.topology.config import TopologySettings
from pilotage.topology.drive import Plan
from pilotage.topology.from_map.building import BuildParams, build_topology
from pilotage.topology.from_map.nodes import NodeParams
from pilotage.topology.routes.floor_routes import FloorRoute, FloorRouter, Leg, Place
from pilotage.topology.routes.floors import Floor
from pilotage.topology.routes.route import Router
from pilotage.topology.storage import RunFolder, TopologyLibrary
from pilotage_schemas.mapping import OccupancyGrid
from pilotage_schemas.topology import TopologicalMap

WORK_S = 60.0
"""Limit for building a map: that of a large building takes some seconds."""


class MapChoice:
    """The topological map in use and all that is made from it; publishes each new one."""

    def __init__(
        self, node: Node, settings: TopologySettings, library: TopologyLibrary, kept: RunFolder
    ) -> None:
        self.library = library
        self.floor: Floor | None = None
        self.grid: OccupancyGrid | None = None
        self._node = node
        self._kept = kept
        self._costs = settings.costs
        self._router: Router | None = None
        self._house: tuple[dict[str, Floor], FloorRouter] | None = None
        self._publisher = node.publisher("topology")

    def take_map(self, grid: OccupancyGrid, plan: Plan) -> None:
        """Use the topological map of a finished map: the one of this run, the kept one, or a new.

        The library may hold one that people gave names and links.
        """
        self.grid = grid
        if self.floor is None:
            self.floor = self._kept.load()
            self._show_if_of(grid)
        if self.floor is None or self.floor.map.map_id != grid.map_id:
            self.use(self.library.of_map(grid.map_id) or self.built(plan))

    def built(self, plan: Plan) -> Floor:
        """Return a topological map built from the map in use; RefusedError without one."""
        if self.grid is None:
            raise RefusedError("there is no map yet")
        params = BuildParams(nodes=NodeParams(spacing=plan.spacing, distance=plan.metres))
        with self._node.busy(WORK_S):
            world = build_topology(messages.world_of(self.grid), self.grid.map_id, params)
        return Floor(world, built_from="map", spacing=plan.spacing)

    def use(self, floor: Floor) -> None:
        """Use a map from now on, and keep it for a restart."""
        self.show(floor)
        self.keep()

    def show(self, floor: Floor) -> None:
        """Use a map from now on and publish it."""
        self.floor, self._router = floor, None
        self._publisher.publish(self._message(floor))

    def keep(self) -> None:
        """Let the map outlive a crash."""
        if self.floor is not None:
            self._kept.save(self.floor)

    def load(self, name: str) -> Floor:
        """Use a map of the library; RefusedError if it is of another map than the one in use."""
        floor = self.library.load(name)
        if self.grid is not None and floor.map.map_id != self.grid.map_id:
            raise RefusedError(
                f"'{name}' is of map {floor.map.map_id}, and {self.grid.map_id} is in use: load "
                "that map first"
            )
        self.use(floor)
        return floor

    def save(self, name: str, label: str | None) -> str:
        """Keep the map in use under a name in the library; return its file."""
        floor = replace(self.required, name=name)
        floor = floor if label is None else replace(floor, label=label)
        path = self.library.save(floor)
        self.use(floor)
        return str(path)

    @property
    def cells(self) -> OccupancyMap | None:
        """The occupancy map in use, None without one."""
        return None if self.grid is None else messages.world_of(self.grid)

    @property
    def required(self) -> Floor:
        """The map in use; RefusedError without one."""
        if self.floor is None:
            raise RefusedError("there is no topological map yet")
        return self.floor

    @property
    def router(self) -> Router:
        """Ways through the map in use, made when first asked for; RefusedError without one."""
        if self._router is None:
            self._router = Router(self.required.map, self._costs)
        return self._router

    def route(self, start: Place, end: Place) -> tuple[FloorRoute, dict[str, Floor]]:
        """Return a way, and the floors it may lead over, by name; NoRouteError."""
        here = self.required
        if start[0] == end[0] == here.name and not here.links:
            found = self.router.route(start[1], end[1])
            return FloorRoute((Leg(here.name, found),), found.cost), {here.name: here}
        floors = {stored.floor.name: stored.floor for stored in self.library.all()}
        floors[here.name] = here
        if self._house is None or not _are_same(self._house[0], floors):
            self._house = floors, FloorRouter(floors, self._costs)
        return self._house[1].route(start, end), floors

    def _show_if_of(self, grid: OccupancyGrid) -> None:
        if self.floor is not None and self.floor.map.map_id == grid.map_id:
            self.show(self.floor)

    def _message(self, floor: Floor) -> TopologicalMap:
        return messages.map_message(floor, self._node.clock.now_ns(), self._costs)


def _are_same(one: dict[str, Floor], other: dict[str, Floor]) -> bool:
    """Say whether these are the very same floors: to compare what they hold would take longer."""
    return one.keys() == other.keys() and all(one[name] is other[name] for name in one)
