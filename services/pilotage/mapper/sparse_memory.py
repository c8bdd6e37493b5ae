"""The recent scans that the front end of sparse SLAM looks back on, as arrays by name, and back."""

import numpy as np

from pilotage.mapper.laser_grid_scans import DrawnScan
from pilotage.mapper.slam_memory import Arrays
from pilotage.mapper.sparse_front_end import SparseScan, Window


def is_of_sparse(memory: Arrays) -> bool:
    """Say whether a memory is that of sparse SLAM."""
    return "window.counts" in memory


def most_points(memory: Arrays) -> int:
    """Return how many points the fullest of the recent scans has: about its beams."""
    return int(max(memory["window.end_counts"].tolist(), default=0))


def packed_window(window: Window) -> Arrays:
    """Return the scans with their poses, and how far they were told."""
    scans = [one.scan for one in window.scans]
    return {
        "window.stamps": np.array([one.stamp for one in window.scans]),
        "window.odoms": np.array([one.odom for one in window.scans]).reshape(-1, 3),
        "window.steps": np.array([one.step for one in window.scans]).reshape(-1, 3),
        "window.lasers": np.array([scan.laser for scan in scans]).reshape(-1, 2),
        "window.ends": np.concatenate([np.empty((0, 2)), *(scan.ends for scan in scans)]),
        "window.is_hit": np.concatenate([np.empty(0, np.bool_), *(s.is_hit for s in scans)]),
        "window.end_counts": np.array([len(scan.ends) for scan in scans], np.int64),
        "window.poses": window.poses,
        "window.counts": np.array([window.told, window.base, window.is_signed], np.int64),
    }


def unpacked_window(memory: Arrays) -> Window:
    """Return it again; KeyError or ValueError if the arrays are not those of a window."""
    cuts = np.cumsum(memory["window.end_counts"])[:-1]
    columns = (
        memory["window.stamps"].tolist(),
        memory["window.odoms"].astype(float),
        memory["window.steps"].astype(float),
        memory["window.lasers"].astype(float),
        np.split(memory["window.ends"].astype(float), cuts),
        np.split(memory["window.is_hit"].astype(np.bool_), cuts),
    )
    told, base, is_signed = memory["window.counts"].tolist()
    if not len(columns[0]):
        return Window([], np.empty((0, 3)), told, base, bool(is_signed))
    scans = [
        SparseScan(odom, step, DrawnScan(stamp, laser, ends, is_hit))
        for stamp, odom, step, laser, ends, is_hit in zip(*columns, strict=True)
    ]
    poses = memory["window.poses"].astype(float)
    return Window(scans, poses, told, base, bool(is_signed))
