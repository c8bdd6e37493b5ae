"""Notices that odometry has been counted anew: a driver restarted, or the clock was set back."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FASTEST = 5.0
"""Odometry that moves faster than this [m/s] has been started anew."""

SHORTEST = 0.05
"""Two samples are taken to be at least so many seconds apart: stamps are not exact."""


@dataclass(frozen=True)
class OdometrySample:
    """One message of odometry: its number, its stamp [Unix ns] and its pose (3,) in odom."""

    seq: int
    stamp_ns: int
    pose: NDArray[np.float64]


def restart_between(before: OdometrySample, after: OdometrySample) -> str | None:
    """Say why odometry must have been counted anew between two samples, None if it went on."""
    seconds = (after.stamp_ns - before.stamp_ns) / 1e9
    way = float(np.hypot(*(after.pose[:2] - before.pose[:2])))
    if after.seq < before.seq or seconds < 0.0 or way > FASTEST * max(seconds, SHORTEST):
        return f"jumped {way:.2f} m in {seconds:.2f} s: counting anew"
    return None
