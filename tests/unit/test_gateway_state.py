"""What the gateway remembers: newest messages, trajectory, ages."""

import numpy as np
import pytest

from gateway_world import pose_estimate, scan, status
from pilotage.gateway.latency import KEPT, LatencyStatistics
from pilotage.gateway.live_state import MAX_SOURCES, LiveState, Received
from pilotage.gateway.trajectory import Trajectory
from pilotage_schemas.localization import PoseEstimate
from pilotage_schemas.message import Message

SECOND = 1_000_000_000


def received(
    message: Message, topic: str = "pose", service: str = "localizer", at_ns: int | None = None
) -> Received:
    return Received(topic, service, b"", message, message.stamp_ns if at_ns is None else at_ns)


def test_nothing_is_known_at_first() -> None:
    state = LiveState()
    assert state.newest("pose") is None
    assert state.sources("pose") == {}
    assert list(state.everything()) == []


def test_the_newest_message_is_kept() -> None:
    state = LiveState()
    for x in (1.0, 2.0):
        state.take(received(pose_estimate(5, x)))
    newest = state.newest("pose")
    assert newest is not None
    assert isinstance(newest.message, PoseEstimate)
    assert newest.message.pose.x == 2.0
    assert len(list(state.everything())) == 1


def test_each_service_has_its_own_newest() -> None:
    state = LiveState()
    state.take(received(scan(1), "scan", "b", at_ns=7))
    state.take(received(scan(2), "scan", "a", at_ns=6))
    assert list(state.sources("scan")) == ["a", "b"]
    latest, first = state.newest("scan"), state.newest("scan", "a")
    assert latest is not None
    assert latest.service == "b"
    assert first is not None
    assert first.service == "a"
    assert state.newest("scan", "c") is None


def test_a_flood_of_services_is_bounded() -> None:
    state = LiveState()
    for number in range(2 * MAX_SOURCES):
        state.take(received(scan(1), "scan", f"robot_{number}"))
    assert len(state.sources("scan")) == MAX_SOURCES
    state.take(received(scan(9), "scan", "robot_0"))
    newest = state.newest("scan", "robot_0")
    assert newest is not None
    assert newest.message.stamp_ns == 9


def test_the_age_is_the_time_from_measurement_to_arrival() -> None:
    assert received(scan(1 * SECOND), at_ns=1 * SECOND + 12_500_000).age_ms == 12.5


def test_ages_are_counted_per_topic() -> None:
    state = LiveState()
    state.take(received(scan(SECOND), "scan", "robot", at_ns=SECOND + 4_000_000))
    latency = state.latency.of("scan")
    assert latency is not None
    assert latency.p50_ms == pytest.approx(4.0)
    assert state.latency.of("pose") is None


def test_ages_mean_nothing_when_a_log_runs_faster_than_time() -> None:
    state = LiveState()
    fast = status(1, source="replay", mode="replaying", speed_factor=5.0)
    state.take(received(fast, "status", "robot"))
    state.take(received(scan(1), "scan", "robot"))
    assert state.latency.of("scan") is None


def test_percentiles_are_those_of_numpy() -> None:
    statistics = LatencyStatistics()
    ages = np.random.default_rng(1).exponential(10.0, 300)
    for age in ages.tolist():
        statistics.add("scan", age)
    latency = statistics.all()["scan"]
    assert latency.count == 300
    assert latency.p50_ms == pytest.approx(np.percentile(ages, 50))
    assert latency.p99_ms == pytest.approx(np.percentile(ages, 99))
    assert latency.max_ms == pytest.approx(ages.max())


def test_old_ages_are_forgotten() -> None:
    statistics = LatencyStatistics()
    for age in [1000.0] + [1.0] * KEPT:
        statistics.add("scan", age)
    latency = statistics.of("scan")
    assert latency is not None
    assert latency.max_ms == 1.0


def walked(*steps: tuple[float, float]) -> Trajectory:
    """Return the trajectory of poses at these times (s) and places (x in m)."""
    trajectory = Trajectory()
    for seconds, x in steps:
        trajectory.add(pose_estimate(round(seconds * SECOND), x))
    return trajectory


def test_the_trajectory_holds_stamp_and_pose() -> None:
    assert walked((1.0, 3.0)).poses() == [(1.0, 3.0, 2.0, 0.5)]


def test_the_trajectory_ends_a_minute_ago() -> None:
    trajectory = walked(*((float(s), 0.0) for s in range(100)))
    assert [pose[0] for pose in trajectory.poses()] == [float(s) for s in range(39, 100)]


def test_a_jump_breaks_the_trajectory() -> None:
    assert walked((0.0, 0.0), (0.1, 0.4), (0.2, 0.95), (0.3, 1.0)).breaks() == [2]


def test_a_gap_in_time_breaks_the_trajectory() -> None:
    assert walked((0.0, 0.0), (1.0, 0.0), (3.5, 0.0)).breaks() == [2]


def test_a_break_moves_with_its_pose_and_goes_with_it() -> None:
    trajectory = walked((0.0, 0.0), (1.0, 5.0), (2.0, 5.0))
    assert trajectory.breaks() == [1]
    trajectory.add(pose_estimate(round(60.5 * SECOND), 5.0))
    assert trajectory.breaks() == [2]  # the gap; the pose before the jump is gone


def test_guesses_leave_no_trace() -> None:
    trajectory = walked((0.0, 0.0))
    trajectory.add(pose_estimate(SECOND, 9.0, state="ambiguous"))
    assert len(trajectory.poses()) == 1


def test_a_lost_robot_loses_its_trace_after_a_minute() -> None:
    trajectory = walked((0.0, 0.0))
    trajectory.add(pose_estimate(61 * SECOND, state="lost"))
    assert trajectory.poses() == []


def test_a_log_that_begins_anew_begins_a_new_trajectory() -> None:
    assert walked((50.0, 0.0), (51.0, 0.0), (10.0, 0.0)).poses() == [(10.0, 0.0, 2.0, 0.5)]
