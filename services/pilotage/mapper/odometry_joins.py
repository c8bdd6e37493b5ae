"""Joins odometry of a log where it jumps: the driver restarted, or a line is wrong.

The service sees such jumps as they come; a log has them with coarse stamps and rare scans, so only
what leads far counts. Smaller ones are left to the scans.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.logs import OdometryRecord, Pose, Record, ScanRecord
from pilotage.core.odometry_watch import FASTEST, SHORTEST

LEAST_JUMP = 5.0
"""m; scans at key frames with stamps of whole seconds are nearer to each other."""

FEW_JUMPS, FEW_SHARE = 10, 0.02
"""So many jumps, or this share of the poses, are restarts. Where there are more, scans and
odometry are told in frames of their own, which take turns."""


def without_jumps(records: list[Record]) -> list[Record]:
    """Return records in order of time with odometry that goes on where it had jumped to."""
    told = {i: pose for i, record in enumerate(records) if (pose := _pose_of(record)) is not None}
    stamps = np.array([records[i].stamp for i in told])
    poses = np.array(list(told.values())).reshape(-1, 3)
    jumps = _jumps(stamps, poses)
    if not 0 < len(jumps) <= max(FEW_JUMPS, FEW_SHARE * len(told)):
        return records
    joined = list(records)
    for i, pose in zip(told, _joined(poses, jumps), strict=True):
        joined[i] = _with_pose(records[i], pose)
    return joined


def _pose_of(record: Record) -> Pose | None:
    match record:
        case OdometryRecord(pose=pose):
            return pose
        case ScanRecord(odom_pose=pose):
            return pose
    return None


def _with_pose(record: Record, pose: NDArray[np.float64]) -> Record:
    x, y, theta = pose.tolist()
    match record:
        case OdometryRecord():
            return replace(record, pose=(x, y, theta))
        case ScanRecord():
            return replace(record, odom_pose=(x, y, theta))
    return record


def _jumps(stamps: NDArray[np.float64], poses: NDArray[np.float64]) -> list[int]:
    """Return the poses that no robot can have reached from the one before."""
    way = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    reach = FASTEST * np.maximum(np.diff(stamps), SHORTEST)
    return (np.flatnonzero(way > np.maximum(reach, LEAST_JUMP)) + 1).tolist()


def _joined(poses: NDArray[np.float64], jumps: list[int]) -> NDArray[np.float64]:
    """Return poses (n, 3) of which each that jumped is where the one before is."""
    joined = poses.copy()
    for start, end in zip(jumps, [*jumps[1:], len(poses)], strict=True):
        shift = se2.compose(joined[start - 1], se2.inverse(poses[start]))
        joined[start:end] = se2.compose(shift, poses[start:end])
    return joined
