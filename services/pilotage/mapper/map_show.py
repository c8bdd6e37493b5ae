"""What others are shown: the map and how it grows, the way, who owns the pose, and the pose."""

import numpy as np
from numpy.typing import NDArray

from pilotage.bus.node import Node
from pilotage.core.grid import OccupancyMap
from pilotage.core.map_files import MapFileError
from pilotage.mapper.live_map import LiveMap
from pilotage.mapper.messages import grid_message, path_message, pose_message
from pilotage_schemas.codec import reason
from pilotage_schemas.mapping import GridPatch, MappingStatus, OccupancyGrid
from pilotage_schemas.topics import PATCHES_KEPT

POSE_PERIOD_NS = 90_000_000


class MapShow:
    """The mapper's publishers."""

    def __init__(self, node: Node) -> None:
        self.map_id = ""
        self._clock = node.clock
        self._map = node.publisher("map")
        self._patch = node.publisher("map_patch")
        self._path = node.publisher("mapped_path")
        self._status = node.publisher("mapping_status")
        self._pose = node.publisher("pose")
        self._pose.rest(is_resting=True)
        self._pose_ns = 0
        self._live = LiveMap(PATCHES_KEPT)

    def checked(self, world: OccupancyMap, name: str) -> OccupancyGrid:
        """Return a map as a message; MapFileError if nobody could use it."""
        if not world.is_free.any():
            raise MapFileError(f"{name}: the map has no free cell: a robot can be nowhere on it")
        try:
            return grid_message(world, name, self._clock.now_ns())
        except ValueError as error:
            raise MapFileError(f"{name}: the map cannot be published: {reason(error)}") from error

    def begin(self) -> None:
        """Begin to show another map in the making."""
        self.map_id = ""
        self._live.forget()

    def serve(self, grid: OccupancyGrid) -> None:
        """Publish a map that is finished."""
        self._live.forget()
        self._map.publish(grid)
        self.map_id = grid.map_id

    def grow(self, world: OccupancyMap) -> None:
        """Publish what is new of the map in the making."""
        if world.cells.size == 0:
            return
        stamp_ns = self._clock.now_ns()
        patches = self._live.news(world)
        if patches is None and self._live.said is not None:
            self.map_id = f"growing-{stamp_ns:x}"
            whole = grid_message(self._live.said, "in the making", stamp_ns, self.map_id)
            self._map.publish(whole)
        for patch in patches or ():
            message = GridPatch(
                stamp_ns=stamp_ns,
                frame_id="map",
                map_id=self.map_id,
                row=patch.row,
                col=patch.col,
                cells=patch.cells,
            )
            self._patch.publish(message)

    def path(self, way: tuple[NDArray[np.float64], NDArray[np.float64]]) -> None:
        """Publish the way, stamps (n,) in s and poses (n, 3), that the map was made from."""
        self._path.publish(path_message(self.map_id, way, self._clock.now_ns()))

    def status(self, status: MappingStatus) -> None:
        """Publish who owns the pose, and take it or leave it."""
        is_resting = status.mode == "idle"
        self._pose.rest(is_resting=is_resting)
        if is_resting:
            self._live.forget()
        self._status.publish(status)

    def pose(
        self, pose: NDArray[np.float64], covariance: NDArray[np.float64] | None, stamp_ns: int
    ) -> None:
        """Publish the pose (3,) if that is due."""
        if abs(stamp_ns - self._pose_ns) >= POSE_PERIOD_NS:
            self._pose_ns = stamp_ns
            self._pose.publish(pose_message(pose, covariance, stamp_ns))
