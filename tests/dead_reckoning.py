"""A way of mapping for tests: it believes the odometry and draws what the scans hit."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.logs import OdometryRecord, Record, ScanRecord, SonarRecord
from pilotage.core.scans import scan_points
from pilotage.mapper.method import MappingStep, PoseGraph

STEPS = np.arange(0.0, 1.0, 0.02)


class DeadReckoning:
    """Records in, a map of 0.1 m cells out."""

    def __init__(self, name: str = "laser") -> None:
        self.name = name
        self.records: list[Record] = []
        self._poses: list[tuple[float, NDArray[np.float64]]] = []
        self._scans: list[tuple[float, NDArray[np.float64]]] = []
        self._hits: list[NDArray[np.float64]] = [np.zeros((0, 2))]
        self._free: list[NDArray[np.float64]] = [np.zeros((0, 2))]

    def process(self, record: Record) -> MappingStep | None:
        self.records.append(record)
        if isinstance(record, OdometryRecord):
            self._poses.append((record.stamp, np.array(record.pose)))
        if isinstance(record, ScanRecord | SonarRecord):
            return self._draw(record)
        return None

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        return odom_from_base

    def settle(self) -> None:
        pass

    def map(self) -> OccupancyMap:
        hits, free = np.concatenate(self._hits), np.concatenate(self._free)
        points = np.concatenate([hits, free, np.zeros((1, 2))])
        low = np.floor(points.min(axis=0)) - 1.0
        rows, cols = (np.ceil((points.max(axis=0) + 1.0 - low) / 0.1).astype(int) + 1)[::-1]
        geometry = GridGeometry(int(rows), int(cols), 0.1, (float(low[0]), float(low[1]), 0.0))
        cells = np.full(geometry.shape, -1, np.int8)
        cells[tuple(geometry.cells_of(free).T)] = 5
        cells[tuple(geometry.cells_of(hits).T)] = 95
        return OccupancyMap(geometry, cells)

    def trajectory(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        stamps = np.array([stamp for stamp, _ in self._poses])
        return stamps, np.array([pose for _, pose in self._poses]).reshape(-1, 3)

    def pose_graph(self) -> PoseGraph:
        stamps = np.array([stamp for stamp, _ in self._scans])
        poses = np.array([pose for _, pose in self._scans]).reshape(-1, 3)
        count = max(len(poses) - 1, 0)
        edges = np.stack([np.arange(count), np.arange(1, count + 1)], axis=1)
        relative = se2.between(poses[:-1], poses[1:]).reshape(-1, 3)
        information = np.tile(np.eye(3), (count, 1, 1))
        return PoseGraph(stamps, poses, edges, relative, information, np.zeros(count, bool))

    def remember(self) -> dict[str, NDArray[Any]]:
        return {}

    def resume(self, memory: dict[str, NDArray[Any]]) -> None:
        if memory:
            raise ValueError("dead reckoning remembers nothing")

    def _draw(self, record: ScanRecord | SonarRecord) -> MappingStep:
        if isinstance(record, ScanRecord):
            assert record.odom_pose is not None
            pose = np.array(record.odom_pose)
            ends = scan_points(record.ranges, record.angle_min, record.angle_increment)
            origin = se2.compose(pose, record.laser_mount)
        else:
            pose = origin = self._poses[-1][1]
            heard = np.isfinite(record.ranges)
            x, y, along = record.mounts[heard].T
            away = record.ranges[heard]
            ends = np.stack([x + away * np.cos(along), y + away * np.sin(along)], axis=1)
        rays = (ends[:, None] * STEPS[None, :, None]).reshape(-1, 2)
        self._hits.append(se2.transform_points(origin, ends))
        self._free.append(se2.transform_points(origin, rays))
        self._scans.append((record.stamp, pose))
        return MappingStep(record.stamp, pose, np.eye(3))
