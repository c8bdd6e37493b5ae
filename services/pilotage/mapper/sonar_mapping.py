"""Mapping with a sonar ring: corrected dead reckoning, then a grid from cones (Li 2008)."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import (
    CommandRecord,
    HeadingRecord,
    OdometryRecord,
    Record,
    SonarRecord,
)
from pilotage.mapper.method import MappingStep, PoseGraph
from pilotage.mapper.pose_correction import PoseCorrection, PoseCorrectionParams
from pilotage.mapper.sonar_grid import SonarGrid, SonarGridParams, nothing_known
from pilotage.mapper.sonar_models import SonarModel
from pilotage.mapper.sonar_ring import SonarRing
from pilotage.mapper.trajectory import Trajectory

DEFAULT_MODEL: SonarModel = "improved_atm"
"""What measures best: the sharpest maps of two real rings, the least noise in simulated halls."""


@dataclass(frozen=True)
class SonarMappingParams:
    """How a sonar robot maps."""

    turning_rate: float = 0.5
    """A robot that turns faster (rad/s) hears nothing of use (Li 2008, chapter 6)."""
    longest_step: float = 0.5
    """Odometry poses farther apart (s) do not say whether the robot turns now."""
    keyframe_travel: float = 0.25
    """Way in m between two poses that stand for the trajectory."""
    keyframe_turn: float = 0.25
    """Turn in rad, likewise."""
    grid: SonarGridParams = field(default_factory=SonarGridParams)
    correction: PoseCorrectionParams = field(default_factory=PoseCorrectionParams)


class SonarMapping:
    """Records in the order of their stamps in; a grid and the robot's way out."""

    name = "sonar"

    def __init__(
        self, params: SonarMappingParams | None = None, model: SonarModel = DEFAULT_MODEL
    ) -> None:
        self._params = params or SonarMappingParams()
        self._model = model
        self._correction = PoseCorrection(self._params.correction)
        self._grid: SonarGrid | None = None
        self._trajectory = Trajectory()
        self._keyframes: list[int] = []
        self._odometry: OdometryRecord | None = None
        self._command: tuple[float, float] | None = None
        self._heading: tuple[float, float] | None = None
        self._is_turning = False

    def process(self, record: Record) -> MappingStep | None:
        """Take in a measurement; return a step if the grid heard something."""
        match record:
            case OdometryRecord():
                self._move(record)
            case CommandRecord():
                self._command = record.linear, record.angular
            case HeadingRecord():
                self._heading = record.yaw, record.sigma
            case SonarRecord() if self._odometry is not None:
                return self._hear(record)
            case _:
                pass
        return None

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last pose (3,) in the map, moved on by odometry since."""
        if self._odometry is None:
            return self._correction.pose
        since = se2.between(self._odometry.pose, odom_from_base)
        return se2.compose(self._correction.pose, since)

    def settle(self) -> None:
        """Do nothing: every measurement is drawn as it comes."""

    def map(self) -> OccupancyMap:
        """Return the map as it is now: unknown cells stay unknown."""
        if self._grid is None:
            return nothing_known(self._params.grid.resolution)
        return self._grid.map()

    def trajectory(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return stamps (n,) in s and poses (n, 3) in the map, at the rate of the odometry."""
        return self._trajectory.stamps, self._trajectory.poses

    def pose_graph(self) -> PoseGraph:
        """Return poses along the way; dead reckoning ties none of them together."""
        stamps, poses = self.trajectory()
        kept = np.array(self._keyframes, np.int64)
        return PoseGraph(
            stamps=stamps[kept],
            poses=poses[kept],
            edges=np.zeros((0, 2), np.int64),
            relative=np.zeros((0, 3)),
            information=np.zeros((0, 3, 3)),
            is_closure=np.zeros(0, bool),
        )

    def remember(self) -> dict[str, NDArray[np.generic]]:
        """Return all that `resume` needs, as arrays by name."""
        stamps, poses = self.trajectory()
        memory: dict[str, NDArray[np.generic]] = {"stamps": stamps, "poses": poses}
        memory["keyframes"] = np.array(self._keyframes, np.int64)
        memory |= {f"correction_{k}": v for k, v in self._correction.remember().items()}
        if self._odometry is not None:
            memory["odometry"] = np.array([self._odometry.stamp, *self._odometry.pose])
        if self._grid is not None:
            ring = self._grid.ring
            memory["mounts"], memory["beam"] = ring.mounts, np.array([ring.cone, ring.range_max])
            memory |= {f"grid_{name}": array for name, array in self._grid.remember().items()}
        return memory

    def resume(self, memory: dict[str, NDArray[np.generic]]) -> None:
        """Go on from what an earlier run remembered; ValueError if it does not fit."""
        if not {"stamps", "poses", "keyframes"} <= memory.keys():
            raise ValueError("the memory is not one of mapping by sonar")
        self._correction.resume(_part(memory, "correction_"))
        self._trajectory.restore(_floats(memory, "stamps"), _floats(memory, "poses"))
        self._keyframes = np.asarray(memory["keyframes"]).tolist()
        if "odometry" in memory:
            stamp, x, y, theta = _floats(memory, "odometry").tolist()
            self._odometry = OdometryRecord(stamp, (x, y, theta))
        if "mounts" in memory and "beam" in memory:
            cone, range_max = _floats(memory, "beam").tolist()
            ring = SonarRing(_floats(memory, "mounts"), cone, range_max)
            self._grid = SonarGrid(self._params.grid, ring, self._model)
            self._grid.resume(_part(memory, "grid_"))

    def _move(self, odometry: OdometryRecord) -> None:
        """Take the pose along."""
        if self._odometry is None:
            self._correction = PoseCorrection(self._params.correction, odometry.pose)
        else:
            step = se2.between(self._odometry.pose, odometry.pose)
            dt = max(0.0, odometry.stamp - self._odometry.stamp)
            self._correction.step(step, dt, self._command, self._heading)
            self._is_turning = self._turns(odometry, float(step[2]), dt)
        self._heading = None
        self._odometry = odometry
        self._keep(odometry.stamp, self._correction.pose)

    def _keep(self, stamp: float, pose: NDArray[np.float64]) -> None:
        """Add a pose (3,) to the way, and to the keyframes if it is far from the last of them."""
        params, way = self._params, self._trajectory
        way.add(stamp, pose)
        last = way.pose(self._keyframes[-1]) if self._keyframes else np.full(3, np.inf)
        travel, turn = math.dist(pose[:2], last[:2]), abs(wrap(float(pose[2] - last[2])))
        if not (travel < params.keyframe_travel and turn < params.keyframe_turn):
            self._keyframes.append(len(way) - 1)

    def _turns(self, odometry: OdometryRecord, turned: float, dt: float) -> bool:
        """Say whether the robot turns, after a turn of `turned` rad in `dt` s."""
        if odometry.angular is not None:
            return abs(odometry.angular) > self._params.turning_rate
        is_known = 0.0 < dt <= self._params.longest_step
        return is_known and abs(turned) > self._params.turning_rate * dt

    def _hear(self, sonar: SonarRecord) -> MappingStep | None:
        """Draw a round, at the pose of now."""
        if self._is_turning:
            return None
        grid = self._grid_of(sonar)
        grid.insert(self._correction.pose, sonar.ranges)
        return MappingStep(sonar.stamp, self._correction.pose, self._correction.covariance)

    def _grid_of(self, sonar: SonarRecord) -> SonarGrid:
        """Return the grid, made ready for the ring of this round."""
        if self._grid is None:
            self._grid = SonarGrid(self._params.grid, _ring_of(sonar), self._model)
        elif not _is_ring_of(self._grid.ring, sonar):
            self._grid.use_ring(_ring_of(sonar))
        return self._grid


def cone_of(sonar: SonarRecord) -> float:
    """Return the opening angle in rad: nothing behind a sonar is heard, whatever it says."""
    return min(sonar.cone, math.pi)


def _ring_of(sonar: SonarRecord) -> SonarRing:
    return SonarRing(np.asarray(sonar.mounts, float), cone_of(sonar), sonar.range_max)


def _is_ring_of(ring: SonarRing, sonar: SonarRecord) -> bool:
    is_same = (ring.cone, ring.range_max) == (cone_of(sonar), sonar.range_max)
    return is_same and np.array_equal(ring.mounts, sonar.mounts)


def _part(memory: dict[str, NDArray[np.generic]], prefix: str) -> dict[str, Any]:
    """Return what is remembered under names with a prefix."""
    return {name.removeprefix(prefix): a for name, a in memory.items() if name.startswith(prefix)}


def _floats(memory: dict[str, NDArray[np.generic]], name: str) -> NDArray[np.float64]:
    return np.array(memory[name], float)
