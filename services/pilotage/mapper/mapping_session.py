"""One mapping run: measurements as they come in, to a method in the order of their stamps.

Sensors and odometry reach the mapper by different ways, a scan often later than the odometry of
its moment. So everything waits `PATIENCE_NS` before the method gets it, and a scan is told where
odometry was just then. The pose does not wait: it is the method's last, moved on by odometry.

Odometry that is counted anew (a driver restarted) is joined to where the old one ended: for the
method it never jumps.
"""

import heapq
import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.logs import OdometryRecord, Record, ScanRecord
from pilotage.core.motion import OdometryNoise
from pilotage.core.odometry_buffer import OdometryBuffer
from pilotage.core.odometry_watch import OdometrySample, restart_between
from pilotage.mapper.method import MappingMethod, MappingStep

PATIENCE_NS = 100_000_000
"""A measurement may come so much later than the odometry of its moment."""

MOST_WAITING = 256
"""Records that wait at most: without odometry they would wait for ever."""

Arrays = dict[str, NDArray[np.generic]]
Waiting = tuple[int, int, int, Record]
"""Stamp in ns, odometry first, count, record: in the order in which the method gets them."""


class LateError(ValueError):
    """A measurement came after later ones had been used; the text says by how much."""


class MappingSession:
    """A method at work.

    Attributes:
        steps: measurements that went into the map.
        redraws: how often the map was drawn anew.
        newest: the newest odometry as the robot said it, None before the first.
    """

    def __init__(self, method: MappingMethod, noise: OdometryNoise | None = None) -> None:
        self.method = method
        self.steps = 0
        self.redraws = 0
        self.newest: OdometrySample | None = None
        self._noise = noise or OdometryNoise()
        self._joined_from_odom = np.zeros(3)
        self._odometry = OdometryBuffer()
        self._waiting: list[Waiting] = []
        self._count = 0
        self._given_ns = 0
        self._newest_of: dict[str, int] = {}
        self._last: MappingStep | None = None
        self._odom_of_last = np.zeros(3)

    def take_odometry(self, now: OdometrySample) -> str | None:
        """Take in odometry, and all that has waited long enough; say why if it began anew."""
        before, self.newest = self.newest, now
        restart = None if before is None else restart_between(before, now)
        if before is not None and restart is not None:
            self._join(before, now)
        joined = self._joined(now)
        if self._odometry.append(now.stamp_ns, joined):
            x, y, theta = joined.tolist()
            self._keep(now.stamp_ns, 0, OdometryRecord(now.stamp_ns / 1e9, (x, y, theta)))
            self._give(now.stamp_ns - PATIENCE_NS)
        return restart

    def take(self, source: str, stamp_ns: int, record: Record) -> None:
        """Take in a measurement of a sensor.

        Raises:
            LateError: it was measured before what the method has already, or not after the last
                one of this source.
        """
        if stamp_ns <= self._newest_of.get(source, -1):
            raise LateError("measured no later than the one before it")
        if stamp_ns < self._given_ns:
            late = (self._given_ns - stamp_ns) / 1e9
            raise LateError(f"measured {late:.3f} s before what is in the map already")
        self._newest_of[source] = stamp_ns
        self._keep(stamp_ns, 1, record)

    def finish(self) -> None:
        """Let the method have all that waits for no more odometry."""
        if self.newest is not None:
            self._give(self.newest.stamp_ns)

    def pose(self) -> NDArray[np.float64] | None:
        """Return the pose (3,) in the map at the newest odometry, None before the first."""
        return None if self.newest is None else self.method.pose_at(self._joined(self.newest))

    def covariance(self) -> NDArray[np.float64] | None:
        """Return the covariance (3, 3) of `pose`: the last step's, and odometry's since then."""
        if self._last is None or self.newest is None:
            return None
        moved = se2.between(self._odom_of_last, self._joined(self.newest))
        return self._last.covariance + _spread(moved, self._noise)

    def go_on_at(self, map_from_base: NDArray[np.float64]) -> None:
        """Go on from another pose (3,): where the robot is now, whatever odometry said since."""
        if self.newest is None:
            raise ValueError("there has been no odometry yet")
        joined = self._joined(self.newest)
        shift = se2.between(self.method.pose_at(joined), map_from_base)
        here = se2.compose(joined, shift)
        self._joined_from_odom = se2.compose(here, se2.inverse(self.newest.pose))
        self._forget_waiting()

    def remember(self) -> Arrays:
        """Return all that `resume` needs, as arrays by name."""
        newest, last = self.newest, self._last
        own: Arrays = {
            "session.counts": np.array([self.steps, self.redraws, self._given_ns]),
            "session.joined_from_odom": self._joined_from_odom,
            "session.odom_of_last": self._odom_of_last,
        }
        if newest is not None:
            own["session.newest"] = np.array([newest.seq, newest.stamp_ns])
            own["session.newest_pose"] = newest.pose
        if last is not None:
            own["session.last"] = np.array(
                [last.stamp, *last.map_from_base.tolist(), *last.covariance.ravel().tolist()]
            )
        return own | {f"method.{name}": array for name, array in self.method.remember().items()}

    def resume(self, memory: Arrays) -> None:
        """Go on from what an earlier run remembered; ValueError if it does not fit."""
        methods = {
            name.removeprefix("method."): array
            for name, array in memory.items()
            if name.startswith("method.")
        }
        self.method.resume(methods)
        try:
            self._resume_own(memory)
        except (KeyError, IndexError, TypeError) as error:
            raise ValueError(f"the session's own memory does not fit: {error}") from error

    def _resume_own(self, memory: Arrays) -> None:
        counts = memory["session.counts"].astype(np.int64).tolist()
        self.steps, self.redraws, self._given_ns = counts
        self._joined_from_odom = memory["session.joined_from_odom"].astype(float)
        self._odom_of_last = memory["session.odom_of_last"].astype(float)
        if "session.newest" in memory:
            seq, stamp_ns = memory["session.newest"].astype(np.int64).tolist()
            pose = memory["session.newest_pose"].astype(float)
            self.newest = OdometrySample(seq, stamp_ns, pose)
        if "session.last" in memory:
            last = memory["session.last"].astype(float)
            self._last = MappingStep(float(last[0]), last[1:4], last[4:13].reshape(3, 3))

    def _keep(self, stamp_ns: int, order: int, record: Record) -> None:
        self._count += 1
        heapq.heappush(self._waiting, (stamp_ns, order, self._count, record))
        if len(self._waiting) > MOST_WAITING:
            heapq.heappop(self._waiting)

    def _give(self, until_ns: int) -> None:
        """Let the method have what was measured until then."""
        while self._waiting and self._waiting[0][0] <= until_ns:
            stamp_ns, _, _, record = heapq.heappop(self._waiting)
            self._given_ns = stamp_ns
            placed = self._placed(stamp_ns, record)
            step = None if placed is None else self.method.process(placed)
            if step is not None:
                self._note(step, stamp_ns)

    def _placed(self, stamp_ns: int, record: Record) -> Record | None:
        """Return a scan with odometry's pose of its moment, None if odometry began later."""
        if not isinstance(record, ScanRecord):
            return record
        pose = self._odometry.pose_at(stamp_ns)
        if pose is None:
            return None
        x, y, theta = pose.tolist()
        return replace(record, odom_pose=(x, y, theta))

    def _note(self, step: MappingStep, stamp_ns: int) -> None:
        self._last = step
        self.steps += 1
        self.redraws += step.redrawn
        odom = self._odometry.pose_at(stamp_ns)
        self._odom_of_last = self._odom_of_last if odom is None else odom

    def _joined(self, sample: OdometrySample) -> NDArray[np.float64]:
        return se2.compose(self._joined_from_odom, sample.pose)

    def _join(self, before: OdometrySample, now: OdometrySample) -> None:
        """Let the new odometry begin where the old one ended."""
        ended = self._joined(before)
        self._joined_from_odom = se2.compose(ended, se2.inverse(now.pose))
        if now.stamp_ns <= before.stamp_ns:
            self._given_ns = 0
            self._newest_of.clear()
        self._forget_waiting()

    def _forget_waiting(self) -> None:
        """Drop what waits for odometry that will not come any more."""
        self._waiting.clear()
        self._odometry.clear()


def _spread(moved: NDArray[np.float64], noise: OdometryNoise) -> NDArray[np.float64]:
    """Return what odometry's errors over a motion (3,) add to a covariance (3, 3), at most."""
    way, turn = float(np.hypot(moved[0], moved[1])), abs(float(moved[2]))
    along = (
        noise.translation_noise_from_translation * way**2
        + noise.translation_noise_from_rotation * turn**2
    )
    turning = (
        noise.rotation_noise_from_rotation * turn**2
        + noise.rotation_noise_from_translation * way**2
    )
    across = along + min(turning, math.pi**2) * way**2
    return np.diag([across, across, turning])
