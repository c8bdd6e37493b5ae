"""The front end for sparse scans: particles follow, a smoother looks back, keyframes come late.

A keyframe is what the scans of half a metre saw together; it is told when the robot is some metres
on, and what was seen until then has shown how these scans lay.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.mapper.front_end import NewKeyframe
from pilotage.mapper.keyframes import Keyframe
from pilotage.mapper.laser_grid_scans import DrawnScan
from pilotage.mapper.odometry_drift import step_sigmas, turned_covariance
from pilotage.mapper.odometry_sense import OdometrySense, SenseParams
from pilotage.mapper.particle_filter import ParticleFilter, ParticleParams
from pilotage.mapper.pose_edges import inverted
from pilotage.mapper.scan_tracker import HERE, Tracked
from pilotage.mapper.smoother import Chain, SmootherParams, smoothed, views_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SparseFrontEndParams:
    """How sparse scans become keyframes."""

    sense: SenseParams = field(default_factory=SenseParams)
    particles: ParticleParams = field(default_factory=ParticleParams)
    smoother: SmootherParams = field(default_factory=SmootherParams)
    way: tuple[float, float] = (0.5, 2.0)
    """m that the scans of a keyframe span, and that they span at most even if they are few."""
    turn: float = 1.0
    """rad that they span at most."""
    scans: tuple[int, int] = (4, 30)
    """So many at least and at most."""
    lag: tuple[int, float] = (40, 8.0)
    """So many scans, or m, later a keyframe is told."""
    sight: float = 30.0
    """m; farther points are not matched."""
    worth: float = 4.0
    """Points of one keyframe are worth so many independent ones."""
    error: tuple[float, float] = (0.005, 0.002)
    """m and rad that a keyframe seen from the one before is never known better than."""


@dataclass(frozen=True, eq=False)
class SparseScan:
    """A scan, odometry's pose (3,) with it, and the step (3,) since the scan before."""

    odom: Array
    step: Array
    scan: DrawnScan

    @property
    def stamp(self) -> float:
        """When it was taken, s."""
        return self.scan.stamp or 0.0


@dataclass(frozen=True, eq=False)
class SparseKeyframe:
    """A keyframe, and its scans with their poses (n, 3) in its frame."""

    new: NewKeyframe
    scans: list[SparseScan]
    poses: Array


@dataclass(frozen=True, eq=False)
class Window:
    """The scans that are looked back on, and their poses (n, 3) in one frame.

    The first `told` are in keyframes, the newest of which begins with scan `base`; `is_signed` as
    OdometrySense has it.
    """

    scans: list[SparseScan]
    poses: Array
    told: int
    base: int
    is_signed: bool


class SparseFrontEnd:
    """The last scans, and where the robot is seen from the newest keyframe told."""

    def __init__(self, params: SparseFrontEndParams, rng: np.random.Generator) -> None:
        self._params = params
        self._sense = OdometrySense(params.sense)
        self._filter = ParticleFilter(params.particles, rng)
        self._window: list[SparseScan] = []
        self._told = 0
        """So many scans of the window are in keyframes already."""
        self._base = 0
        """The first scan of the newest of these."""
        self.tracked: Tracked = HERE
        """Where the robot is, seen from the newest keyframe, or from the first scan before one."""

    @property
    def untold(self) -> list[SparseScan]:
        """The scans not yet in keyframes, oldest first."""
        return self._window[self._told :]

    def take(self, odom: Array, scan: DrawnScan) -> bool:
        """Take in a scan with odometry (3,); say whether it shows anything new."""
        step = self._sense.step(scan.stamp or 0.0, odom)
        if step is None:
            return False
        taken = SparseScan(odom, step.increment, scan)
        if self._window:
            self._filter.take(step, self._points(taken))
        else:
            self._filter.begin(self._points(taken), np.zeros(3))
        self._window.append(taken)
        self._forget()
        self.tracked = self._where()
        return True

    def told(self, *, is_end: bool = False) -> SparseKeyframe | None:
        """Return the next keyframe if enough came after it, or if there will be no more scans."""
        last = self._group_end()
        if self._told == len(self._window) or not (is_end or self._is_late(last)):
            return None
        poses, known = self._smoothed()
        mine = range(self._told, last)
        base = poses[self._told]
        relative = se2.between(poses[self._base], base) if self._told else np.zeros(3)
        edge = self._covariance(poses, known, mine) if self._told else 1e-6 * np.eye(3)
        seen = se2.between(base, poses[self._told : last])
        scans = self._window[self._told : last]
        drawn = tuple(one.scan.moved(pose) for one, pose in zip(scans, seen, strict=True))
        points = [
            se2.transform_points(pose, self._points(one))
            for one, pose in zip(scans, seen, strict=True)
        ]
        keyframe = Keyframe(scans[0].stamp, np.concatenate(points), drawn)
        self._base, self._told = self._told, last
        self.tracked = self._where()
        return SparseKeyframe(NewKeyframe(keyframe, relative, edge), scans, seen)

    def recent(self) -> Array:
        """Return the poses (n, 3) of the scans `untold`, seen from the newest keyframe."""
        if self._told == len(self._window):
            return np.empty((0, 3))
        poses, _ = self._smoothed()
        return se2.between(poses[self._base], poses[self._told :])

    def remembered(self) -> Window:
        """Return all that `go_on` needs."""
        poses = self._smoothed()[0] if self._window else np.empty((0, 3))
        return Window(list(self._window), poses, self._told, self._base, self._sense.is_signed)

    def go_on(self, window: Window) -> None:
        """Begin where another front end was."""
        if not window.scans:
            return
        self._window, self._told, self._base = window.scans, window.told, window.base
        for one, pose in zip(window.scans, window.poses, strict=True):
            self._filter.begin(self._points(one), pose)
        last = window.scans[-1]
        self._sense.go_on(last.stamp, last.odom, is_signed=window.is_signed)
        self.tracked = self._where()

    def _points(self, taken: SparseScan) -> Array:
        hits = taken.scan.ends[taken.scan.is_hit]
        near = np.hypot(hits[:, 0], hits[:, 1]) < self._params.sight
        return np.ascontiguousarray(hits[near])

    def _forget(self) -> None:
        """Keep no more scans than the particles do."""
        over = len(self._window) - self._params.particles.scans
        if over > 0:
            del self._window[:over]
            self._told, self._base = self._told - over, self._base - over

    def _is_late(self, last: int) -> bool:
        """Say whether enough scans follow from scan number `last` on."""
        scans, way = self._params.lag
        after = self._window[last:]
        steps = np.array([one.step for one in after]).reshape(-1, 3)
        return len(after) >= scans or float(np.hypot(steps[:, 0], steps[:, 1]).sum()) >= way

    def _group_end(self) -> int:
        """Return the number of the scan after those that make the next keyframe."""
        params, way, turn = self._params, 0.0, 0.0
        least, most = params.scans
        for number in range(self._told + 1, len(self._window)):
            step = self._window[number].step
            way += float(np.hypot(step[0], step[1]))
            turn += abs(float(step[2]))
            count = number - self._told
            is_wide = way > params.way[0] or turn > params.turn
            if count >= most or way > params.way[1] or (count >= least and is_wide):
                return number
        return len(self._window)

    def _smoothed(self) -> tuple[Array, Array]:
        """Return poses (n, 3) of the window and what its points say of each (n, 3, 3)."""
        way, senses = self._filter.way(len(self._window))
        steps = np.array([one.step for one in self._window[1:]]).reshape(-1, 3)
        steps[:, :2] *= senses[1:, None]
        sigmas = self._sigmas(steps)
        information = np.zeros((len(steps), 3, 3))
        for axis, column in enumerate((0, 0, 1)):
            information[:, axis, axis] = 1.0 / sigmas[:, column] ** 2
        views = views_of([self._points(one) for one in self._window])
        return smoothed(Chain(way, steps, information), views, self._params.smoother)

    def _sigmas(self, steps: Array) -> Array:
        drift = self._params.particles.drift
        sigmas: Array = step_sigmas(steps, drift) * np.array(self._filter.scale)
        return sigmas

    def _covariance(self, poses: Array, known: Array, mine: range) -> Array:
        """Return what odometry and points say of a new keyframe seen from the one before."""
        params, base = self._params, self._told
        steps = np.array([one.step for one in self._window[self._base + 1 : base + 1]])
        way, turn = np.sum(self._sigmas(steps) ** 2, axis=0).tolist()
        length = float(np.hypot(steps[:, 0], steps[:, 1]).sum())
        # The heading errs all along the way.
        odometry = np.diag([way, way + turn * length**2 / 3.0, turn])
        count = sum(len(self._points(self._window[number])) for number in mine)
        share = min(1.0, params.worth / max(1, count))
        points = share * known[mine.start : mine.stop].sum(axis=0)
        seen = turned_covariance(-float(poses[base, 2]), points)
        way_error, turn_error = params.error
        floor = np.diag([way_error**2, way_error**2, turn_error**2])
        both: Array = inverted(inverted(odometry) + seen) + floor
        return both

    def _where(self) -> Tracked:
        """Return the robot seen from the newest keyframe, the mean of the particles."""
        before, now = self._filter.spread(len(self._window) - self._base)
        seen = se2.between(before, now)
        turn = np.arctan2(np.sin(seen[:, 2]).mean(), np.cos(seen[:, 2]).mean())
        mean = np.array([seen[:, 0].mean(), seen[:, 1].mean(), turn])
        off = seen - mean
        off[:, 2] = wrap(off[:, 2])
        covariance = off.T @ off / len(off) + 1e-6 * np.eye(3)
        return Tracked(mean, covariance, is_matched=True)
