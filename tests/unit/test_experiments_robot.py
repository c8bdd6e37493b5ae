"""The paper's robot: its actions, its sensors, and how it follows a way."""

import math

import numpy as np
import pytest

from drawing import draw
from pilotage.experiments.ranger_robot import (
    BEARINGS,
    FORWARD,
    TURN,
    RobotParams,
    carried_out,
    is_at,
    next_action,
    on_a_bin,
    random_goals,
    read_sensors,
)

EXACT = RobotParams(forward=0.0, turn=0.0, range=0.0, compass=0.0, range_max=10.0)
ROOM = draw("""
    #########
    #.......#
    #.......#
    #.......#
    #########
    """)


def rng() -> np.random.Generator:
    return np.random.default_rng(1)


def test_exact_actions_lead_where_they_say() -> None:
    pose = carried_out(np.array([1.0, 2.0, math.pi / 2.0]), np.array([0.1, 0.0, 0.0]), EXACT, rng())
    assert pose == pytest.approx([1.0, 2.1, math.pi / 2.0])


def test_a_step_errs_in_its_way_and_not_in_its_heading() -> None:
    noisy = RobotParams(forward=0.01, turn=0.1)
    pose = carried_out(np.zeros(3), np.array([FORWARD, 0.0, 0.0]), noisy, rng())
    assert pose[0] != FORWARD
    assert pose[1:] == pytest.approx([0.0, 0.0])


def test_a_turn_errs_in_its_heading_and_not_in_its_place() -> None:
    noisy = RobotParams(forward=0.01, turn=0.1)
    pose = carried_out(np.zeros(3), np.array([0.0, 0.0, TURN]), noisy, rng())
    assert pose[:2] == pytest.approx([0.0, 0.0])
    assert pose[2] != TURN


def test_rangers_look_to_the_front_left_right_and_back() -> None:
    reading = read_sensors(ROOM, np.array([3.0, 1.5, 0.0]), EXACT, rng())
    assert reading.ranges == pytest.approx([5.0, 2.5, 0.5, 2.0])
    assert reading.yaw == 0.0


def test_a_ranger_that_meets_nothing_says_infinity() -> None:
    short = RobotParams(range_max=1.0)
    reading = read_sensors(ROOM, np.array([4.5, 2.5, 0.0]), short, rng())
    assert np.isinf(reading.ranges).tolist() == [True] * len(BEARINGS)


def test_noise_never_makes_a_range_negative() -> None:
    noisy = RobotParams(range=5.0)
    ranges = [
        read_sensors(ROOM, np.array([1.1, 2.0, 0.0]), noisy, np.random.default_rng(seed)).ranges
        for seed in range(20)
    ]
    assert np.min(ranges) >= 0.0


@pytest.mark.parametrize(
    ("goal", "action"),
    [
        ((1.0, 0.0), (FORWARD, 0.0, 0.0)),
        ((0.0, 1.0), (0.0, 0.0, TURN)),
        ((0.0, -1.0), (0.0, 0.0, -TURN)),
        ((1.0, 0.04), (FORWARD, 0.0, 0.0)),
    ],
)
def test_the_next_action_turns_to_the_goal_and_then_goes(
    goal: tuple[float, float], action: tuple[float, float, float]
) -> None:
    assert next_action(np.zeros(3), goal) == pytest.approx(action)


def test_following_actions_reaches_every_goal() -> None:
    pose, goals = np.array([3.0, 3.0, 0.0]), random_goals((0.0, 0.0), (6.0, 6.0), rng())
    for _, goal in zip(range(5), goals, strict=False):
        for _ in range(200):
            if is_at(pose, goal):
                break
            pose = carried_out(pose, next_action(pose, goal), EXACT, rng())
        assert is_at(pose, goal)


@pytest.mark.parametrize("heading", [-3.1, -0.02, 0.0, 0.7, 3.14])
def test_a_start_lies_on_a_bin_near_what_was_asked(heading: float) -> None:
    theta = on_a_bin(1.0, 2.0, heading)[2]
    assert theta / TURN == pytest.approx(round(theta / TURN))
    assert abs(math.remainder(theta - heading, math.tau)) <= TURN / 2.0 + 1e-9
