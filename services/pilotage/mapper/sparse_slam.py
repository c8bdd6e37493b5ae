"""Laser SLAM with few beams: many scans together are what one full scan is to LaserSlam."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import OdometryRecord, Record, ScanRecord
from pilotage.mapper.graph_refinement import refine_graph
from pilotage.mapper.graph_upkeep import GraphUpkeep, UpkeepParams
from pilotage.mapper.keyframes import KeyframeGraph
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_scans import draw, drawn_scan
from pilotage.mapper.loop_closure import Agreement, ClosureParams
from pilotage.mapper.method import MappingStep, PoseGraph
from pilotage.mapper.odometry_drift import turned_covariance
from pilotage.mapper.particle_filter import ParticleParams
from pilotage.mapper.pose_graph import GraphParams
from pilotage.mapper.scan_matcher import MatchParams
from pilotage.mapper.scan_tracker import TrackerParams
from pilotage.mapper.slam_memory import Arrays, packed, refusing_misfits, unpack
from pilotage.mapper.smoother import SmootherParams
from pilotage.mapper.sparse_front_end import SparseFrontEnd, SparseFrontEndParams, SparseKeyframe
from pilotage.mapper.sparse_memory import packed_window, unpacked_window
from pilotage.mapper.track import Track

CLOSURES = ClosureParams(
    recent=30,
    company=10,
    doubt=(0.03, 0.01),
    far_agreement=Agreement(explained=0.6, contradicted=0.10, through=0.25, cost=0.5),
)
"""A keyframe holds few points, but spans half a metre; drift is larger, and walls are thicker."""
TRACKER = TrackerParams(match=MatchParams(scales=(0.2, 0.1, 0.08)))
UPKEEP = UpkeepParams(closures=CLOSURES, crowd=(0.5, 0.35, 6))
REFINEMENT = SmootherParams(scales=(0.2, 0.1), iterations=8, share=0.5)
"""Closures have laid the passes over one another already."""


@dataclass(frozen=True)
class SparseSlamParams:
    """How sparse scans become a map."""

    front_end: SparseFrontEndParams = field(default_factory=SparseFrontEndParams)
    graph: GraphParams = field(default_factory=GraphParams)
    tracker: TrackerParams = TRACKER
    """Of the matches that close loops."""
    upkeep: UpkeepParams = UPKEEP
    refinement: SmootherParams = REFINEMENT


WORK, MOST_PARTICLES = 2200, 550
"""Particles times beams, and particles at most: the fewer beams, the more ways are possible."""


def params_for(beams: int) -> SparseSlamParams:
    """Return how scans of so many beams become a map."""
    fewest = ParticleParams().particles
    particles = min(MOST_PARTICLES, max(fewest, WORK // max(1, beams)))
    return SparseSlamParams(SparseFrontEndParams(particles=ParticleParams(particles=particles)))


class SparseSlam:
    """A map from a laser of few beams and odometry, as a MappingMethod."""

    name = "laser"

    def __init__(self, rng: np.random.Generator, params: SparseSlamParams | None = None) -> None:
        self._params = params or SparseSlamParams()
        self._front = SparseFrontEnd(self._params.front_end, rng)
        self._graph = KeyframeGraph(self._params.graph)
        self._upkeep = GraphUpkeep(self._graph, self._params.upkeep, self._params.tracker)
        self._grid: LaserGrid | None = LaserGrid()
        self._track = Track()
        self._odom: NDArray[np.float64] | None = None

    def process(self, record: Record) -> MappingStep | None:
        """Take in odometry or a scan that says where odometry was; other records are of no use."""
        match record:
            case OdometryRecord():
                self._track.add_odometry(record.stamp, np.array(record.pose))
            case ScanRecord(odom_pose=odom) if odom is not None:
                return self._take(record, np.array(odom))
        return None

    def _take(self, record: ScanRecord, odom: NDArray[np.float64]) -> MappingStep | None:
        """Follow the scan; what is some metres back becomes a keyframe of the graph."""
        if not self._front.take(odom, drawn_scan(record)):
            return None
        self._odom = odom
        told = self._front.told()
        relaxed = told is not None and self._add(told)
        return MappingStep(record.stamp, self._pose(), self._covariance(), relaxed)

    def _add(self, told: SparseKeyframe) -> bool:
        """Take a keyframe into the graph; say whether the graph was relaxed."""
        is_due = self._upkeep.append(told.new)
        for one, pose in zip(told.scans, told.poses, strict=True):
            self._track.add_scan(one.stamp, one.odom, self._graph.newest, pose)
        if is_due:
            self._relax()
        elif self._grid is not None:
            for scan in told.new.keyframe.scans:
                draw(self._grid, self._graph.poses[self._graph.newest], scan)
        return is_due

    def _relax(self) -> None:
        self._upkeep.relax()
        recent = self._params.upkeep.closures.recent
        refine_graph(self._graph, self._params.refinement, recent)
        self._grid = None

    def settle(self) -> None:
        """Make keyframes of all scans, and relax the graph if closures wait for it."""
        while told := self._front.told(is_end=True):
            self._add(told)
        if self._upkeep.waiting:
            self._relax()

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last pose (3,) in the map, moved on by odometry since."""
        if self._odom is None:
            return np.zeros(3)
        return se2.compose(self._pose(), se2.between(self._odom, odom_from_base))

    def map(self) -> OccupancyMap:
        """Return the map: what is in keyframes, and the scans since as they look by now."""
        if self._grid is None:
            self._grid = self._graph.drawn()
        grid = LaserGrid.from_state(self._grid.state(), self._grid.params)
        for one, pose in zip(self._front.untold, self._front.recent(), strict=True):
            draw(grid, se2.compose(self._base(), pose), one.scan)
        return grid.map()

    def trajectory(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return stamps (n,) in s and poses (n, 3) in the map, at the rate of the odometry."""
        if not self._graph.keyframes:
            return self._track.poses(self._graph)
        track = Track()
        track.resume(self._track.state())
        for one, pose in zip(self._front.untold, self._front.recent(), strict=True):
            track.add_scan(one.stamp, one.odom, self._graph.newest, pose)
        return track.poses(self._graph)

    def pose_graph(self) -> PoseGraph:
        """Return the keyframes' poses and the edges between them."""
        return self._graph.listed()

    def remember(self) -> Arrays:
        """Return all that `resume` needs, as arrays by name."""
        window = self._front.remembered()
        known = packed(self._graph, self._track) | self._upkeep.state()
        return known | packed_window(window)

    def resume(self, memory: Arrays) -> None:
        """Go on from what an earlier run remembered; ValueError if it does not fit."""
        with refusing_misfits():
            self._resume(memory)

    def _resume(self, memory: Arrays) -> None:
        unpack(memory, self._graph, self._track)
        self._upkeep.resume(memory)
        window = unpacked_window(memory)
        if window.scans:
            self._front.go_on(window)
            self._odom = window.scans[-1].odom
            self._grid = None

    def _base(self) -> NDArray[np.float64]:
        """Return the pose (3,) in the map that the front end sees the robot from."""
        return self._graph.poses[self._graph.newest] if self._graph.keyframes else np.zeros(3)

    def _pose(self) -> NDArray[np.float64]:
        return se2.compose(self._base(), self._front.tracked.pose)

    def _covariance(self) -> NDArray[np.float64]:
        """How well the pose is known on the map around, along the map's axes."""
        return turned_covariance(float(self._base()[2]), self._front.tracked.covariance)
