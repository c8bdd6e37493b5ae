"""A way of mapping that believes odometry: for tests of what is around the methods."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import OdometryRecord, Record, ScanRecord
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_scans import draw, drawn_scan
from pilotage.mapper.method import MappingStep, PoseGraph

COVARIANCE = np.diag([0.01, 0.01, 0.001])


class DeadReckoningMapping:
    """Draws each scan where odometry says that it was taken; the first odometry is the origin.

    `redraws_at`: numbers of the scans after which it pretends to have closed a loop.
    """

    name = "laser"

    def __init__(self, redraws_at: tuple[int, ...] = ()) -> None:
        self.records: list[Record] = []
        self._redraws_at = redraws_at
        self._grid = LaserGrid()
        self._map_from_odom: NDArray[np.float64] | None = None
        self._stamps: list[float] = []
        self._poses: list[NDArray[np.float64]] = []
        self._scans = 0

    def process(self, record: Record) -> MappingStep | None:
        self.records.append(record)
        if isinstance(record, OdometryRecord):
            if self._map_from_odom is None:
                self._map_from_odom = se2.inverse(record.pose)
            self._stamps.append(record.stamp)
            self._poses.append(self.pose_at(np.array(record.pose)))
        if not isinstance(record, ScanRecord) or self._map_from_odom is None:
            return None
        pose = self.pose_at(np.array(record.odom_pose))
        draw(self._grid, pose, drawn_scan(record))
        self._scans += 1
        return MappingStep(record.stamp, pose, COVARIANCE, self._scans in self._redraws_at)

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        if self._map_from_odom is None:
            return np.zeros(3)
        return se2.compose(self._map_from_odom, odom_from_base)

    def settle(self) -> None:
        pass

    def map(self) -> OccupancyMap:
        return self._grid.map()

    def trajectory(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return np.array(self._stamps), np.array(self._poses).reshape(-1, 3)

    def pose_graph(self) -> PoseGraph:
        stamps, poses = self.trajectory()
        none = np.zeros((0, 2), np.int64)
        return PoseGraph(
            stamps, poses, none, np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(0, bool)
        )

    def remember(self) -> dict[str, NDArray[np.generic]]:
        stamps, poses = self.trajectory()
        origin = np.zeros(0) if self._map_from_odom is None else self._map_from_odom
        own = {"stamps": stamps, "poses": poses, "origin": origin}
        return own | {f"grid.{name}": array for name, array in self._grid.state().items()}

    def resume(self, memory: dict[str, NDArray[np.generic]]) -> None:
        if "origin" not in memory:
            raise ValueError("there is no origin")
        origin = memory["origin"].astype(float)
        self._map_from_odom = origin if len(origin) else None
        self._stamps = memory["stamps"].astype(float).tolist()
        self._poses = list(memory["poses"].astype(float))
        grid = {k.removeprefix("grid."): v for k, v in memory.items() if k.startswith("grid.")}
        self._grid = LaserGrid.from_state(grid)
