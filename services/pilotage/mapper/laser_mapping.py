"""Mapping with a laser of any number of beams: the first scan says which way is right for it."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import OdometryRecord, Record, ScanRecord
from pilotage.mapper.laser_slam import LaserSlam
from pilotage.mapper.method import MappingMethod, MappingStep, PoseGraph
from pilotage.mapper.slam_memory import Arrays
from pilotage.mapper.sparse_memory import is_of_sparse, most_points
from pilotage.mapper.sparse_slam import SparseSlam, params_for

FEW_BEAMS = 60
"""Scans with fewer are too sparse to be matched one by one (Freiburg 079: of 30 of its beams the
heading is off by 1.2 degrees after ten scans, of 60 by half a degree)."""


class LaserMapping:
    """LaserSlam for full scans, SparseSlam for sparse ones, as a MappingMethod."""

    name = "laser"

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._method: MappingMethod = LaserSlam()
        self._before: list[OdometryRecord] | None = []
        """What came before the first scan; None after it."""

    def process(self, record: Record) -> MappingStep | None:
        """Take in a record; the first scan with odometry decides."""
        if self._before is not None:
            match record:
                case OdometryRecord():
                    self._before.append(record)
                case ScanRecord(odom_pose=odom) if odom is not None:
                    self._decide(len(record.ranges))
        return self._method.process(record)

    def _decide(self, beams: int) -> None:
        if beams < FEW_BEAMS:
            self._method = SparseSlam(self._rng, params_for(beams))
            for record in self._before or ():
                self._method.process(record)
        self._before = None

    def settle(self) -> None:
        """Work off what waits for more measurements."""
        self._method.settle()

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last pose (3,) in the map, moved on by odometry since."""
        return self._method.pose_at(odom_from_base)

    def map(self) -> OccupancyMap:
        """Return the map as it is now."""
        return self._method.map()

    def trajectory(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return stamps (n,) in s and poses (n, 3) in the map, at the rate of the odometry."""
        return self._method.trajectory()

    def pose_graph(self) -> PoseGraph:
        """Return the keyframes' poses and the edges between them."""
        return self._method.pose_graph()

    def remember(self) -> Arrays:
        """Return all that `resume` needs, as arrays by name."""
        return self._method.remember()

    def resume(self, memory: Arrays) -> None:
        """Go on from what an earlier run remembered; ValueError if it does not fit."""
        self._method = LaserSlam()
        if is_of_sparse(memory):
            self._method = SparseSlam(self._rng, params_for(most_points(memory)))
        self._method.resume(memory)
        if self._method.pose_graph().stamps.size or is_of_sparse(memory):
            self._before = None
