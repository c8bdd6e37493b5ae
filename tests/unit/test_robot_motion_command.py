"""Motions closed over the odometry, on a robot that does what it is told."""

import numpy as np
import pytest
from numpy.typing import NDArray

from pilotage.core.motion import arc
from pilotage.robot.motion_command import Motion, Progress, Straight, Turn

DT = 0.02


def carried_out(
    motion: Motion,
    begin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    drift: float = 0.0,
    limit: float = 60.0,
) -> tuple[NDArray[np.float64], Progress, float]:
    """Drive until the end; return where, how it ended, and how long it took."""
    pose, now = np.array(begin), 0.0
    while now < limit:
        progress = motion.advance(pose, now)
        if progress.ended is not None:
            return pose, progress, now
        pose = arc(pose, progress.speeds[0], progress.speeds[1] + drift, DT)
        now += DT
    raise AssertionError(f"{motion.name} has not ended after {limit} s at {pose}")


@pytest.mark.parametrize("distance", [0.02, 0.5, 3.0, -0.5, -2.0])
def test_it_stops_after_the_distance(distance: float) -> None:
    pose, progress, _ = carried_out(Straight(distance, 0.4))
    assert pose == pytest.approx([distance, 0.0, 0.0], abs=0.006)
    assert progress.ended is not None
    assert progress.ended.endswith(": done")


@pytest.mark.parametrize("angle", [0.1, 1.0, -2.0, np.pi, 7.0, -13.0])
def test_it_turns_by_the_angle_even_by_more_than_one_turn(angle: float) -> None:
    pose, _, took = carried_out(Turn(angle, 0.8))
    assert np.angle(np.exp(1j * (pose[2] - angle))) == pytest.approx(0.0, abs=0.01)
    assert pose[:2] == pytest.approx([0.0, 0.0])
    assert took >= abs(angle) / 0.8


def test_it_is_never_faster_than_told_and_slower_towards_the_end() -> None:
    motion, pose, speeds = Straight(1.0, 0.4), np.zeros(3), []
    for step in range(500):
        progress = motion.advance(pose, step * DT)
        speeds.append(progress.speeds[0])
        pose = arc(pose, progress.speeds[0], progress.speeds[1], DT)
    assert max(speeds) == pytest.approx(0.4)
    driving = [speed for speed in speeds if speed > 0.0]
    assert driving[-1] < 0.1
    assert speeds[-1] == 0.0


@pytest.mark.parametrize("distance", [2.0, -2.0])
def test_a_drift_of_the_heading_is_steered_against(distance: float) -> None:
    pose, _, _ = carried_out(Straight(distance, 0.4), drift=0.05)
    assert abs(pose[2]) < 0.05
    assert abs(pose[1]) < 0.1


def test_the_start_may_be_anywhere() -> None:
    pose, _, _ = carried_out(Straight(1.0, 0.4), begin=(3.0, 4.0, np.pi / 2.0))
    assert pose == pytest.approx([3.0, 5.0, np.pi / 2.0], abs=0.01)


def test_a_blocked_motion_is_given_up_after_two_seconds() -> None:
    motion = Straight(1.0, 0.4)
    stuck = np.zeros(3)
    assert motion.advance(stuck, 0.0).ended is None
    assert motion.advance(stuck, 1.9).ended is None
    assert motion.advance(stuck, 2.1).ended == "forward 1.00 m: blocked 1.00 m before the end"


def test_a_blocked_turn_is_given_up_too() -> None:
    motion = Turn(1.0, 0.5)
    motion.advance(np.zeros(3), 0.0)
    assert motion.advance(np.zeros(3), 2.1).ended == "turn 57 degrees: blocked"


def test_names_say_what_is_done() -> None:
    names = [Straight(1.0, 0.3).name, Straight(-0.5, 0.3).name, Turn(-np.pi / 2.0, 1.0).name]
    assert names == ["forward 1.00 m", "backward 0.50 m", "turn -90 degrees"]
