"""A recorded log in place of a robot."""

from itertools import pairwise

import numpy as np
import pytest

from pilotage.core.logs import (
    HeadingRecord,
    Log,
    OdometryRecord,
    Record,
    ScanRecord,
    SonarRecord,
    TruthRecord,
)
from pilotage.robot.driver import DriverError, Playback
from pilotage.robot.replay import Replay, Speed
from pilotage_schemas.geometry import Twist2
from pilotage_schemas.topics import TOPICS

START_NS = 1_700_000_000_000_000_000
SECOND = 1_000_000_000
ORIGIN = (0.0, 0.0, 0.0)


def odometry_at(stamp: float) -> OdometryRecord:
    return OdometryRecord(stamp, (stamp - 100.0, 0.0, 0.0), 1.0, 0.0)


def scan_at(stamp: float) -> ScanRecord:
    ranges = np.array([1.0, np.inf], np.float32)
    return ScanRecord(stamp, ranges, -0.5, 1.0, 8.0, None, (0.25, 0.0, 0.0))


def log_of(*records: Record) -> Log:
    return Log("carmen", records, 0)


STEADY = log_of(*(odometry_at(100.0 + 0.1 * i) for i in range(101)))
"""Ten a second for ten seconds."""


def replay_of(log: Log = STEADY, speed: Speed = 1.0, *, loop: bool = False) -> Replay:
    replay = Replay(log, "run.log", speed, loop=loop)
    replay.sense(START_NS)
    return replay


def played(replay: Replay, seconds: float) -> list[int]:
    """The stamps of what is due that long after the start, in ns since then."""
    found = replay.sense(START_NS + round(seconds * 1e9))
    return [measurement.message.stamp_ns - START_NS for measurement in found]


def test_stamps_begin_with_the_playback_and_keep_their_distances() -> None:
    replay = Replay(STEADY, "run.log")
    (first,) = replay.sense(START_NS)
    assert first.message.stamp_ns == START_NS
    stamps = played(replay, 0.35)
    assert stamps == pytest.approx([0.1 * SECOND, 0.2 * SECOND, 0.3 * SECOND], abs=1000)


def test_what_is_not_due_waits() -> None:
    replay = replay_of()
    assert played(replay, 0.05) == []
    assert len(played(replay, 0.1001)) == 1


def test_at_double_speed_twice_as_much_is_due_and_stamps_run_ahead() -> None:
    replay = replay_of(speed=2.0)
    stamps = played(replay, 1.01)
    assert len(stamps) == 20
    assert stamps[-1] == pytest.approx(2.0 * SECOND, abs=1000)
    assert replay.speed_factor == 2.0


def test_the_log_ends_once() -> None:
    replay = replay_of()
    finished = [replay.is_finished]
    played(replay, 20.0)
    finished.append(replay.is_finished)
    assert finished == [False, True]
    assert replay.progress == 1.0
    assert replay.account == "run.log: the log has ended"
    assert played(replay, 30.0) == []


def test_a_loop_begins_anew_and_its_stamps_go_on() -> None:
    replay = replay_of(loop=True)
    stamps = [stamp for look in range(1, 250) for stamp in played(replay, 0.1 * look)]
    assert len(stamps) > 200
    assert all(later > earlier for earlier, later in pairwise(stamps))
    assert np.diff(stamps) == pytest.approx(0.1 * SECOND, rel=0.01)
    assert replay.account == "run.log: round 3, back at the start of the log"
    assert not replay.is_finished


def test_at_full_speed_it_plays_as_much_as_it_may_each_time() -> None:
    replay = Replay(STEADY, "run.log", "max")
    assert len(list(replay.sense(START_NS))) == 50
    assert len(list(replay.sense(START_NS))) == 50
    assert len(list(replay.sense(START_NS))) == 1
    assert replay.speed_factor > 1.0


def test_a_long_pause_is_made_up_for_in_portions() -> None:
    replay = replay_of(speed=1000.0)
    long = log_of(*(odometry_at(100.0 + 0.001 * i) for i in range(3000)))
    replay = replay_of(long)
    portions = [len(played(replay, 3.0)) for _ in range(7)]
    assert max(portions) == 500
    assert sum(portions) == 2999


def test_every_kind_of_record_goes_out_by_its_topic() -> None:
    log = log_of(
        odometry_at(100.0),
        scan_at(100.0),
        HeadingRecord(100.0, 0.5, 0.1),
        TruthRecord(100.0, (1.0, 2.0, 3.0)),
        SonarRecord(100.0, np.ones(2, np.float32), np.zeros((2, 3)), 0.4, 5.0),
    )
    measurements = list(Replay(log, "all.log").sense(START_NS))
    topics = [measurement.topic for measurement in measurements]
    assert topics == ["odometry", "scan", "heading", "ground_truth", "sonar"]
    for measurement in measurements:
        assert isinstance(measurement.message, TOPICS[measurement.topic].message)
        assert measurement.message.stamp_ns == START_NS


def test_values_are_passed_on_as_they_were() -> None:
    replay = Replay(log_of(odometry_at(100.5), scan_at(100.5)), "x")
    odometry, scan = (measurement.message for measurement in replay.sense(0))
    assert odometry.model_dump(include={"pose", "twist"}) == {
        "pose": {"x": 0.5, "y": 0.0, "theta": 0.0},
        "twist": {"vx": 1.0, "vy": 0.0, "omega": 0.0},
    }
    assert scan.model_dump(include={"angle_min", "angle_increment", "range_max", "frame_id"}) == {
        "angle_min": -0.5,
        "angle_increment": 1.0,
        "range_max": 8.0,
        "frame_id": "laser",
    }


def test_the_description_tells_where_the_laser_sat_and_that_it_obeys_nothing() -> None:
    description = Replay(log_of(scan_at(1.0)), "run.log").describe()
    (mount,) = description.mounts
    assert (mount.frame_id, mount.pose.x) == ("laser", 0.25)
    assert description.commands == ()
    assert Replay(STEADY, "run.log").describe().mounts == ()


def test_a_log_cannot_be_driven() -> None:
    replay = replay_of()
    with pytest.raises(DriverError, match="a recorded log cannot be driven"):
        replay.drive(Twist2(vx=0.1, vy=0.0, omega=0.0))
    with pytest.raises(DriverError, match="a recorded log cannot be driven"):
        replay.stop()


def test_it_is_a_playback_that_opens_and_closes() -> None:
    with replay_of() as replay:
        assert isinstance(replay, Playback)


def test_a_log_of_one_record_is_no_special_case() -> None:
    replay = Replay(log_of(odometry_at(5.0)), "one.log")
    assert len(list(replay.sense(START_NS))) == 1
    assert replay.is_finished
