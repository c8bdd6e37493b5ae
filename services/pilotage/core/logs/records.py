"""What a log holds: one frozen record per measurement, stamps in s, everything else SI."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Pose = tuple[float, float, float]
"""x [m], y [m], theta [rad]."""


class LogError(ValueError):
    """A log cannot be read; the message names file, line and reason in one sentence."""


@dataclass(frozen=True)
class OdometryRecord:
    """The pose of base_link in odom, and the speeds in m/s and rad/s if the log has them."""

    stamp: float
    pose: Pose
    linear: float | None = None
    angular: float | None = None


@dataclass(frozen=True, eq=False)
class ScanRecord:
    """One turn of a laser; beam i points to `angle_min + i * angle_increment` of the laser."""

    stamp: float
    ranges: NDArray[np.float32]
    """(n,) m, infinity where nothing came back."""
    angle_min: float
    angle_increment: float
    range_max: float
    odom_pose: Pose | None
    """Pose of base_link in odom at the time of the scan, if the log says it with the scan."""
    laser_mount: Pose
    """Pose of the laser in base_link."""


@dataclass(frozen=True)
class HeadingRecord:
    """What a compass says: the yaw in the map frame and its standard deviation, rad."""

    stamp: float
    yaw: float
    sigma: float


@dataclass(frozen=True)
class TruthRecord:
    """The true pose of base_link in the map, from a simulator or a tracking system."""

    stamp: float
    pose: Pose


@dataclass(frozen=True, eq=False)
class SonarRecord:
    """One round of single-cone rangers (sonar, time of flight), each at its own mount."""

    stamp: float
    ranges: NDArray[np.float32]
    """(n,) m, infinity where no echo came back."""
    mounts: NDArray[np.float64]
    """(n, 3) x, y and direction of each in base_link."""
    cone: float
    """Full opening angle, rad."""
    range_max: float


@dataclass(frozen=True)
class CommandRecord:
    """The twist that the robot was told to drive from then on, m/s and rad/s."""

    stamp: float
    linear: float
    angular: float


Record = OdometryRecord | ScanRecord | HeadingRecord | TruthRecord | SonarRecord | CommandRecord


@dataclass(frozen=True, eq=False)
class Log:
    """A whole log: its records in order of time, its format, and how many lines were damaged."""

    format: str
    records: tuple[Record, ...]
    skipped_lines: int

    @cached_property
    def scans(self) -> tuple[ScanRecord, ...]:
        """The laser scans in order of time."""
        return tuple(record for record in self.records if isinstance(record, ScanRecord))

    @cached_property
    def odometry(self) -> tuple[OdometryRecord, ...]:
        """The odometry in order of time."""
        return tuple(record for record in self.records if isinstance(record, OdometryRecord))

    @property
    def duration(self) -> float:
        """Seconds from the first to the last record."""
        return self.records[-1].stamp - self.records[0].stamp
