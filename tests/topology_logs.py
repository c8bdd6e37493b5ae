"""Real drives for the topological map: where the robot was at each scan, and its laser."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import Log, ScanRecord, read_log
from pilotage.core.map_files import load_map
from pilotage.localizer.log_run import LogSensors, localize_log
from pilotage.localizer.methods import MethodSetup, make_method
from pilotage.mapper.log_run import LogUse, map_records, records_of
from pilotage.mapper.map_products import finish
from pilotage.mapper.methods import MappingSetup
from pilotage.mapper.methods import make_method as make_mapping
from pilotage.topology.features import Features
from pilotage.topology.from_drive.building import LiveBuilder, LiveParams
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.seeing.seen_features import seen_features

WEAN_START = (40.0, 41.5, -1.7)
"""Where both Wean logs begin, m and rad; see tests/golden/test_localize_wean.py."""
START_COVARIANCE = np.diag([0.25, 0.25, 0.07])
SEED = 0


@dataclass(frozen=True)
class Drive:
    """Scans, the pose (n, 3) of base_link in map at each, and the map."""

    scans: tuple[ScanRecord, ...]
    poses: NDArray[np.float64]
    world: OccupancyMap

    def seen(self) -> Iterator[tuple[float, NDArray[np.float64], Features]]:
        """Yield stamp [s], pose (3,) and the features (base_link) of each scan."""
        for scan, pose in zip(self.scans, self.poses, strict=True):
            view = ScanView.of(
                scan.ranges, (scan.angle_min, scan.angle_increment), scan.laser_mount
            )
            yield scan.stamp, pose, seen_features(view)


def mapped(log: Log) -> Drive:
    """Return a drive with the poses and the map of this project's own SLAM."""
    method = make_mapping("laser", MappingSetup(None, np.random.default_rng(SEED)))
    for _ in map_records(records_of(log, LogUse()), method):
        pass
    made = finish(method)
    inside = [s for s in log.scans if made.stamps[0] <= s.stamp <= made.stamps[-1]]
    return Drive(tuple(inside), poses_at(made.stamps, made.poses, inside), made.world)


def localized(log: Log, map_file: Path, start: tuple[float, float, float]) -> Drive:
    """Return a drive with the poses that the localizer estimates on a map."""
    world = load_map(map_file)
    localizer = make_method("markov", world, MethodSetup(), np.random.default_rng(SEED))
    localizer.start_at(np.array(start), START_COVARIANCE)
    poses = [estimate.pose for estimate in localize_log(log, localizer, LogSensors())]
    return Drive(log.scans, np.array(poses), world)


def poses_at(
    stamps: NDArray[np.float64], poses: NDArray[np.float64], scans: list[ScanRecord]
) -> NDArray[np.float64]:
    """Return the poses (n, 3) at the scans' times, between their neighbours."""
    times = [scan.stamp for scan in scans]
    unwound = np.column_stack([poses[:, :2], np.unwrap(poses[:, 2])])
    return np.column_stack([np.interp(times, stamps, column) for column in unwound.T])


def cut(log: Log, begin: float, end: float) -> Log:
    """Return the records of a log from `begin` to `end` s after its first."""
    first = log.records[0].stamp
    kept = tuple(r for r in log.records if begin <= r.stamp - first < end)
    return Log(log.format, kept, log.skipped_lines)


def built(drive: Drive, params: LiveParams | None = None) -> LiveBuilder:
    """Return what is built along a drive, to its end."""
    builder = LiveBuilder(params)
    for stamp, pose, seen in drive.seen():
        builder.add(stamp, pose, seen)
    builder.finish()
    return builder


def fr079(folder: Path) -> Log:
    """Return the log of Freiburg's building 079."""
    return read_log(folder / "slam" / "fr079.clf.gz")


def wean(folder: Path) -> Log:
    """Return the first log of Wean Hall as long as the localizer is sure of where it is."""
    return cut(read_log(folder / "wean_hall" / "robotdata1.log.gz"), 0.0, 98.0)
