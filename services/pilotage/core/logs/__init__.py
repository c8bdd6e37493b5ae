"""Recorded runs of robots as records in SI units, whatever program wrote them."""

from pilotage.core.logs.reading import read_log
from pilotage.core.logs.records import (
    CommandRecord,
    HeadingRecord,
    Log,
    LogError,
    OdometryRecord,
    Pose,
    Record,
    ScanRecord,
    SonarRecord,
    TruthRecord,
)

__all__ = [
    "CommandRecord",
    "HeadingRecord",
    "Log",
    "LogError",
    "OdometryRecord",
    "Pose",
    "Record",
    "ScanRecord",
    "SonarRecord",
    "TruthRecord",
    "read_log",
]
