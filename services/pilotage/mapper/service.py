"""The mapper on the bus: a map file in, the topic `map` out."""

from pathlib import Path

from pilotage.bus.deployment import ConfigError, Deployment
from pilotage.bus.fabric import RefusedError
from pilotage.bus.node import Node
from pilotage.core.angles import wrap
from pilotage.core.grid import OccupancyMap
from pilotage.core.map_files import MapFileError, load_map, map_digest
from pilotage.mapper.config import MapperSettings
from pilotage_schemas.codec import reason
from pilotage_schemas.commands import LoadMap, MapLoaded
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.mapping import OccupancyGrid


class MapperService:
    """Publishes the map of its settings and, on request, another one."""

    def __init__(self, settings: MapperSettings, node: Node, _deployment: Deployment) -> None:
        self._node = node
        self._map = node.publisher("map")
        node.answer("load_map", self.load)
        if settings.map is not None:
            try:
                self._publish(settings.map)
            except MapFileError as error:
                raise ConfigError(str(error)) from error

    def load(self, request: LoadMap) -> MapLoaded:
        """Use the map of this path from now on; a damaged file leaves the old map in use."""
        if not request.path.strip():
            raise RefusedError("the path is empty: name a map file")
        try:
            grid = self._publish(Path(request.path))
        except MapFileError as error:
            raise RefusedError(str(error)) from error
        rows, cols = grid.cells.shape
        return MapLoaded(map_id=grid.map_id, rows=rows, cols=cols)

    def _publish(self, path: Path) -> OccupancyGrid:
        grid = _grid_of_file(path, self._node.clock.now_ns())
        self._map.publish(grid)
        return grid


def _grid_of_file(path: Path, stamp_ns: int) -> OccupancyGrid:
    """Return the map of a file as a message; MapFileError if nobody could use it."""
    world = load_map(path)
    if not world.is_free.any():
        raise MapFileError(f"{path}: the map has no free cell: a robot can be nowhere on it")
    try:
        return grid_message(world, path.name, stamp_ns)
    except ValueError as error:
        raise MapFileError(f"{path}: the map cannot be published: {reason(error)}") from error


def grid_message(world: OccupancyMap, name: str, stamp_ns: int) -> OccupancyGrid:
    """Return a map as a message; `name` is what people call it."""
    x, y, theta = world.geometry.origin
    return OccupancyGrid(
        stamp_ns=stamp_ns,
        frame_id="map",
        map_id=map_digest(world),
        name=name[:64],
        resolution=world.geometry.resolution,
        origin=Pose2(x=x, y=y, theta=wrap(theta)),
        cells=world.cells,
    )
