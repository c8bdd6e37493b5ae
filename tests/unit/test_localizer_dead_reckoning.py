"""A pose that is only moved on by odometry gets less sure, as its errors do."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from localizer_world import (
    ANGLE_MIN,
    ANGLE_STEP,
    BEAMS,
    COARSE,
    RANGE_MAX,
    ROUND,
    START,
    error,
    flat,
    look,
    scan_at,
)
from pilotage.core import se2
from pilotage.localizer.dead_reckoning import grown, reckoned, says_nothing, within_limits
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.landmark_sightings import Sightings
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.measurement import (
    Measurement,
    landmarks_measurement,
    ranges_measurement,
    scan_measurement,
)
from pilotage.localizer.modes import MODE_RADIUS, MODE_TURN, Mode
from pilotage.localizer.motion_spread import MotionSpread
from pilotage.localizer.verdict import VerdictParams

SPREAD = MotionSpread()
EXACT = np.diag([1e-4, 1e-4, 1e-5])
SILENT = np.full(BEAMS, np.inf, np.float32)


def seen_by_laser(ranges: np.ndarray) -> Measurement:
    return scan_measurement(ranges, (ANGLE_MIN, ANGLE_STEP), np.zeros(3), 60, RANGE_MAX)


def test_what_came_back_from_somewhere_says_something() -> None:
    some = SILENT.copy()
    some[3] = 2.0
    nothing = np.empty(0)
    none = Sightings(nothing, nothing, nothing, nothing, (), ())
    assert not says_nothing(seen_by_laser(some))
    assert not says_nothing(ranges_measurement(SILENT[:1], np.zeros((1, 3), np.float32), 4.0))
    assert not says_nothing(landmarks_measurement(none, np.zeros(3)))


def test_a_covered_laser_or_a_compass_alone_says_nothing_of_a_place() -> None:
    assert says_nothing(Measurement())
    assert says_nothing(seen_by_laser(SILENT))
    assert says_nothing(seen_by_laser(SILENT).with_compass((0.3, 0.1)))


@given(st.floats(0.01, 1.0), st.floats(0.01, 1.0), st.floats(0.01, 1.0), st.floats(-3.0, 3.0))
def test_the_probability_of_a_place_is_the_share_of_drawn_poses_in_it(
    along: float, across: float, turn: float, axis: float
) -> None:
    cos, sin = math.cos(axis), math.sin(axis)
    turned = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    covariance = turned @ np.diag([along, across, turn]) ** 2 @ turned.T
    drawn = np.random.default_rng(1).multivariate_normal(np.zeros(3), covariance, 20_000)
    near = (np.hypot(drawn[:, 0], drawn[:, 1]) <= MODE_RADIUS) & (np.abs(drawn[:, 2]) <= MODE_TURN)
    assert within_limits(covariance) == pytest.approx(near.mean(), abs=0.015)


def test_the_covariance_is_that_of_many_robots_with_noisy_odometry() -> None:
    """Straight on for 4 m in steps of 0.1 m, each with the noise of its own way."""
    rng, count = np.random.default_rng(2), 4_000
    start = np.array([1.0, 2.0, 0.7])
    poses, covariance = np.tile(start, (count, 1)), np.zeros((3, 3))
    step = np.array([0.1, 0.0, 0.0])
    along, around = SPREAD.variances(0.1, 0.0)
    sigmas = np.sqrt([along, along, around])
    pose = start
    for _ in range(40):
        poses = se2.compose(poses, step + sigmas * rng.standard_normal((count, 3)))
        covariance = grown(pose, covariance, step, SPREAD)
        pose = se2.compose(pose, step)
    assert covariance == pytest.approx(np.cov((poses - pose).T), rel=0.15, abs=0.004)


def test_one_long_way_is_as_uncertain_as_its_parts() -> None:
    pose, whole = np.zeros(3), np.array([2.0, 0.0, 0.0])
    at_once = grown(pose, EXACT, whole, SPREAD)
    in_parts = EXACT
    for _ in range(20):
        in_parts = grown(pose, in_parts, whole / 20.0, SPREAD)
        pose = se2.compose(pose, whole / 20.0)
    assert np.diag(in_parts) == pytest.approx(np.diag(at_once), rel=0.25)


def estimate(confidence: float) -> Estimate:
    pose = np.array([2.0, 1.0, 0.5])
    modes = [Mode(0.9, pose, EXACT), Mode(0.1, np.zeros(3), EXACT)]
    return Estimate(pose, EXACT, "localized", confidence, modes, 0.9)


def test_modes_and_pose_move_on_together_and_nothing_is_matched() -> None:
    step = np.array([0.5, 0.1, 0.2])
    moved = reckoned(estimate(0.98), step, SPREAD)
    assert moved.pose == pytest.approx(se2.compose(estimate(0.98).pose, step))
    assert moved.modes[0].pose == pytest.approx(moved.pose)
    assert moved.modes[1].pose == pytest.approx(step)
    assert [mode.mass for mode in moved.modes] == [0.9, 0.1]
    assert moved.matched is None


def test_standing_still_costs_nothing_and_confidence_never_grows() -> None:
    still = reckoned(estimate(0.98), np.zeros(3), SPREAD)
    assert still.confidence == pytest.approx(0.98)
    assert still.covariance == pytest.approx(EXACT)
    confidences = [0.98]
    moved = estimate(0.98)
    for _ in range(30):
        moved = reckoned(moved, np.array([0.5, 0.0, 0.1]), SPREAD)
        confidences.append(moved.confidence)
    assert np.all(np.diff(confidences) <= 0.0)
    assert confidences[-1] < 0.2
    expected = 0.98 * within_limits(moved.covariance) / within_limits(EXACT)
    assert confidences[-1] == pytest.approx(expected)


def test_a_covered_robot_that_drives_on_is_localized_only_while_that_is_likely() -> None:
    world = flat()
    localizer = MarkovLocalizer(world, COARSE)
    pose, odom = np.array(START), np.zeros(3)
    stamp = 0
    for step in ROUND:
        pose, odom, stamp = se2.compose(pose, step), se2.compose(odom, step), stamp + 10**9
        assert localizer.update(stamp, odom, look(world, pose)) is localizer.estimate
    assert localizer.estimate.state == "localized"
    states, uncertain = [], [localizer.estimate.covariance[2, 2]]
    step = (0.1, 0.0, 0.3)
    for _ in range(160):
        pose, odom, stamp = se2.compose(pose, step), se2.compose(odom, step), stamp + 10**9
        now = localizer.update(stamp, odom, seen_by_laser(SILENT))
        states.append(now.state)
        uncertain.append(now.covariance[2, 2])
        assert now.state != "localized" or within_limits(now.covariance) > VerdictParams().stay
    assert states[:5] == ["localized"] * 5
    assert states[-1] == "unknown"
    assert np.all(np.diff(uncertain) > 0.0)
    for _ in range(3):
        pose, odom, stamp = se2.compose(pose, step), se2.compose(odom, step), stamp + 10**9
        ranges = scan_at(world, pose)
        localizer.update(stamp, odom, seen_by_laser(ranges))
    assert localizer.estimate.state == "localized"
    assert error(localizer.estimate.pose, pose)[0] < 0.1
