from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.logs import Log, read_log
from pilotage.core.scans import scan_points

pytestmark = pytest.mark.data

FACTS = {
    "wean_hall/robotdata1.log.gz": ("wean", 713, 180, 41.2, 134.8),
    "wean_hall/robotdata3.log.gz": ("wean", 1241, 180, 42.5, 132.3),
    "slam/fr079.clf.gz": ("carmen", 4791, 360, 392.9, 1061.1),
    "slam/aces.clf.gz": ("carmen", 440, 180, 322.1, 1318.1),
    "slam/seattle.clf.gz": ("carmen", 241, 361, 190.0, 1165.3),
    "slam/acapulco.clf.gz": ("carmen", 861, 181, 806.6, 1363.9),
}
"""Format, scans, beams, metres driven and seconds from the first to the last scan."""


@cache
def recorded(file: Path) -> Log:
    """Return a log, read but once."""
    return read_log(file)


@pytest.mark.parametrize("name", FACTS)
def test_recorded_run_has_the_known_figures(data_dir: Path, name: str) -> None:
    log = recorded(data_dir / name)
    poses = np.array([scan.odom_pose for scan in log.scans])
    driven = np.hypot(*np.diff(poses[:, :2], axis=0).T).sum()
    seconds = log.scans[-1].stamp - log.scans[0].stamp
    facts = (log.format, len(log.scans), len(log.scans[0].ranges))
    assert facts == FACTS[name][:3]
    assert driven == pytest.approx(FACTS[name][3], abs=0.1)
    assert seconds == pytest.approx(FACTS[name][4], abs=0.1)
    assert log.skipped_lines == 0


@pytest.mark.parametrize("name", FACTS)
def test_stamps_rise_and_ranges_are_plausible(data_dir: Path, name: str) -> None:
    log = recorded(data_dir / name)
    assert (np.diff([record.stamp for record in log.records]) >= 0.0).all()
    ranges = np.concatenate([scan.ranges for scan in log.scans])
    seen = np.isfinite(ranges)
    assert seen.mean() > 0.85
    assert ranges[seen].min() > 0.1
    assert ranges[seen].max() < log.scans[0].range_max


@pytest.mark.parametrize("name", ["wean_hall/robotdata1.log.gz", "wean_hall/robotdata3.log.gz"])
def test_wean_laser_sits_a_quarter_metre_ahead(data_dir: Path, name: str) -> None:
    log = recorded(data_dir / name)
    assert log.scans[0].laser_mount == pytest.approx((0.25, 0.0, 0.0), abs=1e-6)


def overlap(log: Log, sense: float) -> float:
    """Median gap in m between points of a scan and the nearest of a scan a few steps on."""
    gaps = []
    for first, second in zip(log.scans[:-40:40], log.scans[10:-30:40], strict=True):
        clouds = []
        for scan in (first, second):
            points = scan_points(scan.ranges, sense * scan.angle_min, sense * scan.angle_increment)
            near = points[np.hypot(*points.T) < 8.0]
            pose = se2.compose(scan.odom_pose or (0.0, 0.0, 0.0), scan.laser_mount)
            clouds.append(se2.transform_points(pose, near))
        apart = np.linalg.norm(clouds[0][:, None] - clouds[1][None], axis=2)
        gaps.append(np.median(apart.min(axis=1)))
    return float(np.mean(gaps))


@pytest.mark.parametrize("name", ["wean_hall/robotdata1.log.gz", "slam/fr079.clf.gz"])
def test_beams_run_from_right_to_left(data_dir: Path, name: str) -> None:
    """Scans laid on each other by odometry fit; mirrored they do not."""
    log = recorded(data_dir / name)
    assert overlap(log, 1.0) < 0.6 * overlap(log, -1.0)
