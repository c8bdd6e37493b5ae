"""Laser SLAM: scans followed on a local map, keyframes in a graph, loops closed, maps redrawn."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import OdometryRecord, Record, ScanRecord
from pilotage.mapper.front_end import FrontEnd, FrontEndParams, NewKeyframe
from pilotage.mapper.graph_upkeep import GraphUpkeep, UpkeepParams
from pilotage.mapper.keyframes import KeyframeGraph
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_scans import DrawnScan, draw, drawn_scan
from pilotage.mapper.method import MappingStep, PoseGraph
from pilotage.mapper.odometry_drift import turned_covariance
from pilotage.mapper.pose_graph import GraphParams
from pilotage.mapper.scan_tracker import LocalMap, Tracked, local_map
from pilotage.mapper.slam_memory import Arrays, packed, refusing_misfits, unpack
from pilotage.mapper.track import Track


@dataclass(frozen=True)
class SlamParams:
    """How a laser's scans become a map."""

    front_end: FrontEndParams = field(default_factory=FrontEndParams)
    upkeep: UpkeepParams = field(default_factory=UpkeepParams)
    graph: GraphParams = field(default_factory=GraphParams)
    local: int = 20
    """So many newest keyframes are the local map."""


class LaserSlam:
    """A map from a laser and odometry, as a MappingMethod."""

    name = "laser"

    def __init__(self, params: SlamParams | None = None) -> None:
        self._params = params or SlamParams()
        self._front = FrontEnd(self._params.front_end)
        self._graph = KeyframeGraph(self._params.graph)
        tracker = self._params.front_end.tracker
        self._upkeep = GraphUpkeep(self._graph, self._params.upkeep, tracker)
        self._grid: LaserGrid | None = LaserGrid()
        self._track = Track()
        self._odom: NDArray[np.float64] | None = None

    def process(self, record: Record) -> MappingStep | None:
        """Take in odometry or a scan that says where odometry was; other records are of no use."""
        match record:
            case OdometryRecord():
                self._track.add_odometry(record.stamp, np.array(record.pose))
            case ScanRecord(odom_pose=odom) if odom is not None:
                return self._take(record.stamp, np.array(odom), drawn_scan(record))
        return None

    def _take(self, stamp: float, odom: NDArray[np.float64], scan: DrawnScan) -> MappingStep | None:
        """Follow the scan; make it a keyframe, close loops and relax the graph when that is due."""
        increment = np.zeros(3) if self._odom is None else se2.between(self._odom, odom)
        new = self._front.take(increment, scan)
        if new is None and not self._graph.keyframes:
            return None
        self._odom = odom
        relaxed = new is not None and self._add(new)
        self._track.add_scan(stamp, odom, self._graph.newest, self._front.tracked.pose)
        if self._grid is not None:
            draw(self._grid, self._pose(), scan)
        return MappingStep(stamp, self._pose(), self._covariance(), relaxed)

    def _add(self, new: NewKeyframe) -> bool:
        """Take a keyframe into the graph; say whether the graph was relaxed."""
        is_due = self._upkeep.append(new)
        if is_due:
            self.settle()
        self._front.begin_on(self._local_map())
        return is_due

    def settle(self) -> None:
        """Relax the graph if closures wait for it."""
        if self._upkeep.waiting:
            self._upkeep.relax()
            self._grid = None

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last pose (3,) in the map, moved on by odometry since."""
        if self._odom is None:
            return np.zeros(3)
        return se2.compose(self._pose(), se2.between(self._odom, odom_from_base))

    def map(self) -> OccupancyMap:
        """Return the map, drawn anew from the keyframes if these have moved."""
        if self._grid is None:
            self._grid = self._graph.drawn()
        return self._grid.map()

    def trajectory(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return stamps (n,) in s and poses (n, 3) in the map, at the rate of the odometry."""
        return self._track.poses(self._graph)

    def pose_graph(self) -> PoseGraph:
        """Return the keyframes' poses and the edges between them."""
        return self._graph.listed()

    def remember(self) -> Arrays:
        """Return all that `resume` needs, as arrays by name."""
        odom = np.empty(0) if self._odom is None else self._odom
        own = {
            "odom": odom,
            "pose": self._front.tracked.pose,
            "covariance": self._front.tracked.covariance,
        }
        return own | packed(self._graph, self._track) | self._upkeep.state()

    def resume(self, memory: Arrays) -> None:
        """Go on from what an earlier run remembered; ValueError if it does not fit."""
        with refusing_misfits():
            self._resume(memory)

    def _resume(self, memory: Arrays) -> None:
        unpack(memory, self._graph, self._track)
        self._upkeep.resume(memory)
        if not self._graph.keyframes:
            return
        self._odom = memory["odom"].astype(float)
        self._grid = None
        self._front.begin_on(self._local_map())
        pose, covariance = memory["pose"].astype(float), memory["covariance"].astype(float)
        self._front.tracked = Tracked(pose, covariance, is_matched=True)

    def _local_map(self) -> LocalMap:
        graph, params = self._graph, self._params
        around = graph.points_of(graph.latest(params.local), graph.newest)
        return local_map(around, params.front_end.tracker)

    def _pose(self) -> NDArray[np.float64]:
        return se2.compose(self._graph.poses[self._graph.newest], self._front.tracked.pose)

    def _covariance(self) -> NDArray[np.float64]:
        """How well the pose is known on the map around, along the map's axes."""
        heading = float(self._graph.poses[self._graph.newest][2])
        return turned_covariance(heading, self._front.tracked.covariance)
