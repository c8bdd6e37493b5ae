"""Which map to localize on: the mapper's, or a file that was asked for in its place.

The mapper owns the topic `map`, and another map for everybody is its query `load_map`. `set_map` is
for this service alone: a map to try, or the old one while the mapper draws a new one.
"""

from collections.abc import Callable

from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.core.grid import OccupancyMap
from pilotage.core.map_files import MapFileError, load_map, map_digest
from pilotage.localizer.localization import Localization
from pilotage.localizer.messages import world_of
from pilotage.localizer.takeover import Takeover
from pilotage_schemas.commands import MapLoaded, SetMap
from pilotage_schemas.mapping import OccupancyGrid


class MapChoice:
    """Takes the mapper's maps and answers `set_map`.

    `begin(world, map_id)` begins on a map, or raises ValueError and leaves the old one in use.
    """

    def __init__(
        self,
        node: Node,
        at: Localization,
        takeover: Takeover,
        begin: Callable[[OccupancyMap, str], None],
    ) -> None:
        self._takeover = takeover
        self._node = node
        self._at = at
        self._begin = begin
        self._served: OccupancyGrid | None = None
        node.subscribe("map", self.take)
        node.answer("set_map", self.set_map)
        self._go_on_with_file()

    def take(self, grid: OccupancyGrid) -> None:
        """Begin on the mapper's map; but a chosen file holds until the mapper serves another.

        Nobody localizes on a map in the making.
        """
        if grid.in_progress:
            return
        self._served = grid
        choice = self._at.choice
        if choice.map_file and choice.served_id in ("", grid.map_id):
            self._at.choose_map_file(choice.map_file, grid.map_id)
            return
        try:
            self._begin(world_of(grid), grid.map_id)
        except ValueError as error:
            self._node.warn("map", f"kept the old one: {error}")
        else:
            self._choose("")

    def set_map(self, request: SetMap) -> MapLoaded:
        """Localize on a file, or on the mapper's map again; on any error the old map stays."""
        self._takeover.require_own_pose()
        served = self._served
        try:
            if served is not None and request.map == served.map_id:
                self._begin(world_of(served), served.map_id)
                self._choose("")
            else:
                self._begin_on_file(request.map)
                self._choose(request.map)
        except MapFileError as error:
            raise RefusedError(f"{self._not_served(request.map)}; as a file: {error}") from error
        except ValueError as error:
            raise RefusedError(f"{request.map}: {error}") from error
        return self._loaded()

    def _begin_on_file(self, file: str) -> None:
        world = load_map(file)
        self._begin(world, map_digest(world))

    def _go_on_with_file(self) -> None:
        """Begin on the file that was chosen before a crash; without it wait for the mapper."""
        file = self._at.choice.map_file
        if not file:
            return
        try:
            self._begin_on_file(file)
        except ValueError as error:
            self._node.warn("map", f"the file that was chosen cannot be used any more: {error}")
            self._choose("")

    def _choose(self, file: str) -> None:
        """Note the file to localize on, "" for the mapper's map."""
        if file or self._at.choice.map_file:
            served_id = "" if self._served is None else self._served.map_id
            self._at.choose_map_file(file, served_id if file else "")

    def _not_served(self, asked: str) -> str:
        if self._served is None:
            return "the mapper serves no map"
        return f"the mapper's map is {self._served.map_id}, not '{asked[:64]}'"

    def _loaded(self) -> MapLoaded:
        if self._at.method is None:
            raise RefusedError("there is no map yet")
        rows, cols = self._at.method.world.cells.shape
        return MapLoaded(map_id=self._at.map_id, rows=rows, cols=cols)
