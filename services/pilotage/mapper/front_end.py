"""The front end of laser SLAM: scan after scan on the local map, until a keyframe is due."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.mapper.keyframes import Keyframe
from pilotage.mapper.laser_grid_scans import DrawnScan
from pilotage.mapper.odometry_drift import turned_covariance
from pilotage.mapper.scan_tracker import (
    HERE,
    LocalMap,
    Tracked,
    TrackerParams,
    corrected,
    predicted,
)
from pilotage.mapper.surfel_kernels import thin_points


@dataclass(frozen=True)
class FrontEndParams:
    """How scans become keyframes."""

    tracker: TrackerParams = field(default_factory=TrackerParams)
    way: float = 0.3
    """m after which a scan becomes a keyframe."""
    turn: float = 0.26
    """rad after which it does too."""
    thin: float = 0.05
    """m; points as near as this are matched as one."""
    sight: float = 30.0
    """m; farther points are not matched: they lie thinly."""
    kept: int = 4
    """So many of the scans since the last keyframe are kept with it, for drawing."""
    error: tuple[float, float] = (0.005, 0.002)
    """m and rad that a keyframe seen from the one before is never known better than."""


@dataclass(frozen=True, eq=False)
class NewKeyframe:
    """A keyframe, its pose (3,) from the one before, and the covariance (3, 3) as of an Edge."""

    keyframe: Keyframe
    relative: NDArray[np.float64]
    covariance: NDArray[np.float64]


class FrontEnd:
    """Where the robot is, seen from the newest keyframe."""

    def __init__(self, params: FrontEndParams) -> None:
        self._params = params
        self._map: LocalMap | None = None
        self._since: list[tuple[NDArray[np.float64], DrawnScan]] = []
        self.tracked: Tracked = HERE

    def begin_on(self, here: LocalMap) -> None:
        """Go on from a new keyframe, with the map around it in its frame."""
        self._map, self.tracked = here, HERE
        self._since.clear()

    def take(self, increment: NDArray[np.float64], scan: DrawnScan) -> NewKeyframe | None:
        """Take in a scan and the odometry (3,) since the last; return a keyframe if it is due.

        A scan of nothing is none: a map of such keyframes could not be matched.
        """
        params = self._params
        points = self._points(scan)
        if self._map is None:
            return self._keyframe(points, scan) if len(points) else None
        self.tracked = predicted(self.tracked, increment, params.tracker.drift)
        if not len(points):
            return None
        self.tracked = corrected(self.tracked, points, self._map, params.tracker)
        pose = self.tracked.pose
        if np.hypot(pose[0], pose[1]) > params.way or abs(pose[2]) > params.turn:
            return self._keyframe(points, scan)
        self._since.append((pose, scan))
        return None

    def _points(self, scan: DrawnScan) -> NDArray[np.float64]:
        """Return the points (n, 2) of a scan that are matched."""
        hits = scan.ends[scan.is_hit]
        near = np.hypot(hits[:, 0], hits[:, 1]) < self._params.sight
        return thin_points(np.ascontiguousarray(hits[near]), self._params.thin)

    def _keyframe(self, points: NDArray[np.float64], scan: DrawnScan) -> NewKeyframe:
        pose = self.tracked.pose
        every = max(1, -(-len(self._since) // max(1, self._params.kept - 1)))
        between = [seen.moved(se2.between(pose, at)) for at, seen in self._since[::every]]
        keyframe = Keyframe(scan.stamp or 0.0, points, (*between, scan))
        way, turn = self._params.error
        covariance = turned_covariance(-float(pose[2]), self.tracked.covariance)
        return NewKeyframe(keyframe, pose, covariance + np.diag([way**2, way**2, turn**2]))
