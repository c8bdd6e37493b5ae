"""The recorded logs of other robots: read whole, and played as valid messages."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from pilotage.core.logs import Log, SonarRecord, read_log
from pilotage.robot.replay import Replay

pytestmark = pytest.mark.data


@dataclass(frozen=True)
class Known:
    """What is known of a log; `way` in m where it is, `sonars` how many rounds of them."""

    path: str
    format: str
    scans: int
    sonars: int
    odometry: int
    duration: float
    way: float


LOGS = [
    Known("birmingham/trace0.bag", "rosbag", 958, 0, 958, 96.0, 0.0),
    Known("sonar/ev3/ev3-101.log", "ev3", 0, 101, 303, 1008.0, 0.0),
    Known("sonar/ring8", "ring8", 0, 413, 413, 92.8, 25.0),
    Known("sonar/nanodrone/rice.csv", "nanodrone", 0, 3150, 3150, 314.7, 193.0),
    Known("slam/aces.clf.gz", "carmen", 440, 0, 7374, 1365.5, 0.0),
]


def sonars(log: Log) -> list[SonarRecord]:
    return [record for record in log.records if isinstance(record, SonarRecord)]


@pytest.mark.parametrize("known", LOGS, ids=lambda known: known.path)
def test_log_is_told_by_its_content_and_read_whole(data_dir: Path, known: Known) -> None:
    log = read_log(data_dir / known.path)
    assert (log.format, log.skipped_lines) == (known.format, 0)
    counts = len(log.scans), len(sonars(log)), len(log.odometry)
    assert counts == (known.scans, known.sonars, known.odometry)
    assert log.duration == pytest.approx(known.duration, abs=0.1)
    poses = np.array([record.pose for record in log.odometry])
    if known.way:
        way = np.hypot(*np.diff(poses[:, :2], axis=0).T).sum()
        assert way == pytest.approx(known.way, rel=0.02)


@pytest.mark.parametrize("known", LOGS[:4], ids=lambda known: known.path)
def test_log_plays_as_valid_messages(data_dir: Path, known: Known) -> None:
    replay = Replay(read_log(data_dir / known.path), known.path, "max")
    topics = {m.topic for _ in range(5) for m in replay.sense(1)}
    assert topics == {"odometry", "scan" if known.scans else "sonar"}


def test_laser_of_the_bag_sits_where_its_transforms_say(data_dir: Path) -> None:
    scan = read_log(data_dir / "birmingham" / "trace0.bag").scans[0]
    assert scan.laser_mount == pytest.approx((0.135, 0.0, 0.0))
    assert len(scan.ranges) == 726
    assert scan.angle_min == pytest.approx(-2.356, abs=1e-3)
    assert scan.range_max == pytest.approx(5.6)


def test_bearings_of_the_ring_fit_the_corridor(data_dir: Path) -> None:
    """Along a corridor the outermost sonars look at its walls: their echoes hardly change."""
    ranges = np.array([sonar.ranges for sonar in sonars(read_log(data_dir / "sonar" / "ring8"))])
    sides = ranges[:150, [0, 7]]
    heard = np.isfinite(sides)
    assert heard.mean() > 0.5
    assert np.ptp(np.nanpercentile(np.where(heard, sides, np.nan)[:, 1], [25, 75])) < 0.3
