"""A recorded log as a driver: it measures what was measured then, and cannot be driven."""

from bisect import bisect_right
from collections.abc import Iterator
from itertools import islice
from types import TracebackType
from typing import Literal, Self

import numpy as np

from pilotage.core.logs import (
    CommandRecord,
    HeadingRecord,
    Log,
    OdometryRecord,
    Pose,
    ScanRecord,
    SonarRecord,
    TruthRecord,
)
from pilotage.robot.driver import LOG_REFUSAL, DriverError, Measurement
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.message import Message
from pilotage_schemas.sensors import (
    GroundTruth,
    Heading,
    LaserScan,
    Odometry,
    RobotDescription,
    SensorMount,
    SonarScan,
)

RECORDS_A_LOOK = 50
"""At speed `max`: how many records are played each time the service looks, 50 times a second."""
FOOTPRINT = 0.25 * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)], np.float32)
"""Logs do not say the robot's size; half a metre square is that of the robots that made them."""

Speed = float | Literal["max"]
Played = OdometryRecord | ScanRecord | HeadingRecord | TruthRecord | SonarRecord
"""Records that become messages."""


class Replay:
    """Plays a log at `speed` times its own pace, once or in a loop.

    Stamps are those of the log moved to begin when the playback begins, so at a speed above 1
    they run ahead of the wall clock. In a loop the robot is back at its start without having
    driven there, as if it had been kidnapped, and its odometry begins anew.
    """

    def __init__(self, log: Log, name: str, speed: Speed = 1.0, *, loop: bool = False) -> None:
        # What the robot was told then is no measurement, and on the bus it would be obeyed.
        self._records = [r for r in log.records if not isinstance(r, CommandRecord)]
        self._times = [record.stamp - log.records[0].stamp for record in self._records]
        # After the last record a pause of the mean interval, so that stamps go on increasing.
        self._length = log.duration * (1.0 + 1.0 / max(len(self._times) - 1, 1)) or 1.0
        self._name, self._speed, self._loop = name, speed, loop
        self._mount = log.scans[0].laser_mount if log.scans else None
        self._start_ns: int | None = None
        self._round_start_ns = 0
        self._played = 0
        self._rounds = 0

    def __enter__(self) -> Self:
        """There is nothing to open: the log is in memory."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """There is nothing to close."""

    @property
    def speed_factor(self) -> float:
        """Log seconds per second; of speed `max` what the pace of the service comes to."""
        if self._speed != "max":
            return float(self._speed)
        return max(1.0, self._length / max(len(self._times), 1) * RECORDS_A_LOOK * 50.0)

    @property
    def progress(self) -> float:
        """Part of the log that has been played in this round."""
        return self._played / len(self._records)

    @property
    def is_finished(self) -> bool:
        """Say whether nothing more will come."""
        return self._played == len(self._records) and not self._loop

    @property
    def account(self) -> str:
        """Where the playback is."""
        if self.is_finished:
            return f"{self._name}: the log has ended"
        if self._rounds:
            return f"{self._name}: round {self._rounds + 1}, back at the start of the log"
        return f"{self._name}: playing"

    def describe(self) -> RobotDescription:
        """Return what the log tells of its robot."""
        mounts = []
        if self._mount is not None:
            mounts.append(SensorMount(frame_id="laser", kind="laser", pose=_pose(self._mount)))
        return RobotDescription(
            stamp_ns=0,
            frame_id="base_link",
            name=f"Log {self._name}"[:64],
            driver="replay",
            footprint=FOOTPRINT,
            mounts=tuple(mounts),
            max_linear=0.0,
            max_angular=0.0,
            commands=(),
        )

    def sense(self, now_ns: int) -> Iterator[Measurement]:
        """Return what the log holds up to now."""
        if self._start_ns is None:
            self._start_ns = self._round_start_ns = now_ns
        played: list[Measurement] = []
        for record, time in islice(self._due(now_ns), 10 * RECORDS_A_LOOK):
            measurement = _measurement(record, self._round_start_ns + round(time * 1e9))
            played.append(measurement)
        return iter(played)

    def drive(self, twist: Twist2) -> None:  # noqa: ARG002 - the protocol's signature
        """Refuse."""
        raise DriverError(LOG_REFUSAL)

    def stop(self) -> None:
        """Refuse."""
        raise DriverError(LOG_REFUSAL)

    def _due(self, now_ns: int) -> Iterator[tuple[Played, float]]:
        """Yield records that are due, with their time in s since the start of the round."""
        if self._speed == "max":
            upto = min(self._played + RECORDS_A_LOOK, len(self._records))
        else:
            elapsed = (now_ns - (self._start_ns or 0)) / 1e9 * self._speed
            upto = bisect_right(self._times, elapsed - self._rounds * self._length)
        while self._played < upto:
            self._played += 1
            yield self._records[self._played - 1], self._times[self._played - 1]
        if self._played == len(self._records) and self._loop:
            self._rewind()

    def _rewind(self) -> None:
        self._rounds += 1
        self._round_start_ns += round(self._length * 1e9)
        self._played = 0


def _measurement(record: Played, stamp_ns: int) -> Measurement:
    """Return a record as the message of its topic."""
    match record:
        case OdometryRecord():
            return Measurement("odometry", _odometry(record, stamp_ns))
        case ScanRecord():
            return Measurement("scan", _scan(record, stamp_ns))
        case HeadingRecord():
            return Measurement("heading", _heading(record, stamp_ns))
        case TruthRecord():
            return Measurement("ground_truth", _truth(record, stamp_ns))
        case SonarRecord():
            return Measurement("sonar", _sonar(record, stamp_ns))


def _odometry(record: OdometryRecord, stamp_ns: int) -> Message:
    return Odometry(
        stamp_ns=stamp_ns,
        frame_id="odom",
        pose=_pose(record.pose),
        twist=Twist2(vx=record.linear or 0.0, vy=0.0, omega=record.angular or 0.0),
        covariance=np.zeros((3, 3)),
    )


def _scan(record: ScanRecord, stamp_ns: int) -> Message:
    return LaserScan(
        stamp_ns=stamp_ns,
        frame_id="laser",
        angle_min=record.angle_min,
        angle_increment=record.angle_increment,
        range_min=0.0,
        range_max=record.range_max,
        ranges=record.ranges,
    )


def _heading(record: HeadingRecord, stamp_ns: int) -> Message:
    return Heading(stamp_ns=stamp_ns, frame_id="map", yaw=record.yaw, sigma=record.sigma)


def _truth(record: TruthRecord, stamp_ns: int) -> Message:
    at_rest = Twist2(vx=0.0, vy=0.0, omega=0.0)
    return GroundTruth(stamp_ns=stamp_ns, frame_id="map", pose=_pose(record.pose), twist=at_rest)


def _sonar(record: SonarRecord, stamp_ns: int) -> Message:
    return SonarScan(
        stamp_ns=stamp_ns,
        frame_id="base_link",
        mounts=record.mounts.astype(np.float32),
        ranges=record.ranges,
        cone=record.cone,
        range_min=0.0,
        range_max=record.range_max,
    )


def _pose(pose: Pose) -> Pose2:
    return Pose2(x=pose[0], y=pose[1], theta=pose[2])
