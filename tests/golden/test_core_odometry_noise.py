from pathlib import Path

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.logs import read_log
from pilotage.core.motion import OdometryNoise, sample_odometry

pytestmark = pytest.mark.data


def motions(data_dir: Path, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Motions (n, 3) from scan to scan, by GMapping's poses and by odometry."""
    log = read_log(data_dir / "slam" / f"{name}.clf.gz")
    reference = np.loadtxt(data_dir / "slam" / f"{name}.reference.txt")
    stamps = np.array([scan.stamp for scan in log.scans])
    poses = np.array([scan.odom_pose for scan in log.scans])
    odometry = poses[np.abs(stamps[None] - reference[:, :1]).argmin(axis=1)]
    true = reference[:, 1:4]
    return se2.between(true[:-1], true[1:]), se2.between(odometry[:-1], odometry[1:])


@pytest.mark.parametrize("name", ["aces", "seattle", "acapulco"])
def test_default_noise_covers_what_real_odometry_errs(data_dir: Path, name: str) -> None:
    """True motions lie within three standard deviations of the sampled ones."""
    rng = np.random.default_rng(1)
    start = np.zeros((200, 3))
    within = []
    for true, odometry in zip(*motions(data_dir, name), strict=True):
        sampled = sample_odometry(start, odometry, OdometryNoise(), rng)
        # GMapping's own poses are only good to a centimetre and a third of a degree.
        spread = sampled.std(axis=0) + np.array([0.01, 0.01, 0.006])
        error = true - odometry
        error[2] = wrap(float(error[2]))
        within.append(np.abs(error) < 3.0 * spread)
    # The reference poses are the laser's, which swings aside when the robot turns: hence y.
    assert (np.mean(within, axis=0) > np.array([0.98, 0.9, 0.98])).all()
