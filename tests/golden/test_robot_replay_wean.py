"""A recorded run through Wean Hall, played on the bus."""

from itertools import pairwise
from pathlib import Path

import pytest

from pilotage.core.logs import read_log
from pilotage.robot.config import RobotSettings
from pilotage.robot.replay import Replay
from pilotage_schemas.codec import decode, encode
from robot_world import Bench

pytestmark = pytest.mark.data

START_NS = 1_700_000_000_000_000_000


def test_the_whole_run_goes_out_in_order(data_dir: Path) -> None:
    log = read_log(data_dir / "wean_hall" / "robotdata1.log.gz")
    replay = Replay(log, "robotdata1", speed=1.0)
    looks = range(START_NS, START_NS + 140 * 10**9, 10**8)
    heard = [measurement for now_ns in looks for measurement in replay.sense(now_ns)]
    scans = [m.message for m in heard if m.topic == "scan"]
    assert replay.is_finished
    assert len(scans) == 713
    assert all(a.stamp_ns < b.stamp_ns for a, b in pairwise(scans))
    assert (scans[-1].stamp_ns - scans[0].stamp_ns) / 1e9 == pytest.approx(134.8, abs=0.1)


def test_every_message_of_the_run_is_valid(data_dir: Path) -> None:
    log = read_log(data_dir / "wean_hall" / "robotdata1.log.gz")
    replay = Replay(log, "robotdata1", speed=10.0)
    replay.sense(START_NS)
    for tenth in range(1, 20):
        for measurement in replay.sense(START_NS + tenth * 100_000_000):
            message = measurement.message
            assert decode(type(message), encode(message)).stamp_ns == message.stamp_ns


def test_the_service_says_what_it_plays(data_dir: Path) -> None:
    log = data_dir / "wean_hall" / "robotdata1.log.gz"
    bench = Bench(RobotSettings(driver="replay", log=log, speed=20.0))
    status, scans = bench.listen("status"), bench.listen("scan")
    (description,) = bench.listen("description")
    bench.advance(2.0)
    assert description.mounts[0].pose.x == pytest.approx(0.25)
    assert (status[-1].mode, status[-1].speed_factor) == ("replaying", 20.0)
    assert 0.2 < status[-1].progress < 0.5
    assert len(scans[-1].ranges) == 180
