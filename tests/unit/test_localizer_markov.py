"""The whole localizer, without a bus: from measurements to an estimate that is honest."""

import math
from dataclasses import replace

import numpy as np
import pytest

from localizer_world import (
    ANGLE_MIN,
    ANGLE_STEP,
    BEARINGS,
    COARSE,
    ELSEWHERE,
    RANGE_MAX,
    ROUND,
    START,
    error,
    flat,
    look,
    poses_along,
    scan_at,
)
from naive import markov as naive
from pilotage.core import se2
from pilotage.localizer.compass_memory import STALE_NS, CompassMemory
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.measurement import Measurement, ranges_measurement, scan_measurement
from pilotage.localizer.messages import MODES, SAMPLES, belief_message, pose_message

WORLD = flat()
NARROW = np.diag([0.01, 0.01, 0.005])
SECOND = 10**9


class Walk:
    """A robot with exact odometry, whose every pose is measured."""

    def __init__(self, localizer: MarkovLocalizer, start: tuple[float, float, float]) -> None:
        self.localizer = localizer
        self.pose, self.odom = np.array(start), np.zeros(3)
        self.stamp_ns = 0

    def measure(self) -> Estimate:
        self.stamp_ns += SECOND
        measurement = look(self.localizer.world, self.pose)
        return self.localizer.update(self.stamp_ns, self.odom, measurement)

    def go(self, step: tuple[float, float, float]) -> Estimate:
        self.pose, self.odom = se2.compose(self.pose, step), se2.compose(self.odom, step)
        return self.measure()


@pytest.fixture
def walk() -> Walk:
    return Walk(MarkovLocalizer(WORLD, COARSE), START)


def is_right(estimate: Estimate, pose: np.ndarray) -> bool:
    away, turn = error(estimate.pose, pose)
    return away < 0.1 and turn < 0.05


def test_the_way_through_the_flat_is_free() -> None:
    for pose in poses_along(START, ROUND):
        (cell,) = WORLD.geometry.cells_of(pose[None, :2])
        assert WORLD.is_free[tuple(cell)]


def test_from_an_unknown_start_the_robot_is_found_and_followed(walk: Walk) -> None:
    walk.measure()
    estimates = [(walk.go(step), walk.pose) for step in ROUND]
    assert all(e.state != "localized" or is_right(e, pose) for e, pose in estimates)
    for estimate, pose in estimates[8:]:
        assert estimate.state == "localized"
        assert is_right(estimate, pose)
        assert estimate.confidence > 0.8


def test_before_any_measurement_nothing_is_claimed(walk: Walk) -> None:
    estimate = walk.localizer.estimate
    assert (estimate.state, estimate.confidence, estimate.modes) == ("unknown", 0.0, [])
    assert estimate.matched is None
    assert estimate.covariance[0, 0] > 10.0


def test_a_kidnapped_robot_is_not_localized_until_it_is_right_again(walk: Walk) -> None:
    walk.measure()
    for step in ROUND:
        walk.go(step)
    walk.pose = np.array(ELSEWHERE)
    states = []
    for _ in range(14):
        estimate = walk.go((0.1, 0.0, 0.1))
        states.append(estimate.state)
        assert estimate.state != "localized" or is_right(estimate, walk.pose)
    assert states[0] in {"lost", "ambiguous"}
    assert states[-1] == "localized"


def test_m1_does_not_find_a_kidnapped_robot() -> None:
    walk = Walk(MarkovLocalizer(WORLD, replace(COARSE, algorithm="m1")), START)
    walk.localizer.start_at(START, NARROW)
    for _ in range(4):
        walk.measure()
    assert walk.localizer.estimate.state == "localized"
    walk.pose = np.array(ELSEWHERE)
    for _ in range(20):
        estimate = walk.measure()
        assert not any(error(mode.pose, walk.pose)[0] < 0.5 for mode in estimate.modes)


def test_a_given_pose_is_taken_but_must_still_be_earned(walk: Walk) -> None:
    walk.localizer.start_at(START, NARROW)
    estimate = walk.localizer.estimate
    assert estimate.state == "unknown"
    assert error(estimate.pose, START)[0] < 0.05
    assert [walk.measure().state for _ in range(5)][-1] == "localized"


def test_a_given_pose_off_the_map_is_refused_and_nothing_is_forgotten(walk: Walk) -> None:
    for _ in range(5):
        before = walk.measure()
    belief = walk.localizer.grid.belief.copy()
    with pytest.raises(ValueError, match="free space"):
        walk.localizer.start_at([200.0, 0.0, 0.0], NARROW)
    assert walk.localizer.estimate is before
    assert np.array_equal(walk.localizer.grid.belief, belief)


def test_starting_anywhere_forgets_everything(walk: Walk) -> None:
    for _ in range(5):
        walk.measure()
    walk.localizer.start_anywhere()
    states = walk.localizer.grid.grid.admissible_states
    assert walk.localizer.grid.entropy() == pytest.approx(math.log2(states), abs=2e-3)
    assert walk.localizer.estimate.state == "unknown"
    assert walk.localizer.wants(walk.stamp_ns, walk.odom, Measurement())


def test_a_standing_robot_measures_again_after_a_while_and_a_moving_one_at_once(
    walk: Walk,
) -> None:
    localizer, params = walk.localizer, walk.localizer.params
    assert localizer.wants(0, walk.odom, Measurement())
    walk.measure()
    soon = walk.stamp_ns + round(0.5 * params.update_after * SECOND)
    assert not localizer.wants(soon, walk.odom, Measurement())
    assert localizer.wants(
        walk.stamp_ns + round(params.update_after * SECOND), walk.odom, Measurement()
    )
    assert localizer.wants(
        soon, se2.compose(walk.odom, [1.01 * params.update_way, 0.0, 0.0]), Measurement()
    )
    assert localizer.wants(
        soon, se2.compose(walk.odom, [0.0, 0.0, -1.01 * params.update_turn]), Measurement()
    )
    assert localizer.wants(walk.stamp_ns - 1, walk.odom, Measurement())


def test_between_measurements_the_pose_moves_on_by_odometry(walk: Walk) -> None:
    walk.localizer.start_at(START, NARROW)
    walk.measure()
    step = np.array([0.2, -0.1, 0.3])
    moved = walk.localizer.pose_at(se2.compose(walk.odom, step))
    assert moved == pytest.approx(se2.compose(walk.localizer.estimate.pose, step))


def test_odometry_that_counts_anew_does_not_move_the_belief(walk: Walk) -> None:
    for step in ROUND[:8]:
        walk.go(step)
    walk.localizer.restart_odometry()
    walk.odom = np.array([50.0, -20.0, 2.0])
    estimate = walk.measure()
    assert estimate.state == "localized"
    assert is_right(estimate, walk.pose)


def test_a_memory_resumes_where_the_robot_was_and_follows_how_it_moved_since(walk: Walk) -> None:
    for step in ROUND[:8]:
        walk.go(step)
    memory = walk.localizer.remember()
    assert memory is not None
    assert memory.was_localized
    assert memory.weights.sum() <= 1.0 + 1e-9
    x, y, theta = (float(value) for value in walk.pose)
    again = Walk(MarkovLocalizer(WORLD, COARSE), (x, y, theta))
    again.localizer.resume(memory)
    assert again.localizer.estimate.state == "unknown"
    assert error(again.localizer.estimate.pose, walk.pose)[0] < 0.1
    again.odom, again.stamp_ns = walk.odom, walk.stamp_ns
    for step in ROUND[8:10]:
        estimate = again.go(step)
        assert is_right(estimate, again.pose)
    assert estimate.state == "localized"


def test_a_memory_whose_states_are_all_walls_by_now_resumes_with_nothing(walk: Walk) -> None:
    walk.measure()
    memory = walk.localizer.remember()
    assert memory is not None
    gone = replace(memory, poses=np.array([[99.0, 0.0, 0.0]]), weights=np.ones(1))
    walk.localizer.resume(gone)
    assert walk.localizer.estimate.state == "unknown"
    estimates = [(walk.go(step), walk.pose) for step in ROUND[:8]]
    assert all(e.state != "localized" or is_right(e, pose) for e, pose in estimates)
    assert estimates[-1][0].state == "localized"


def test_who_stands_still_earns_no_more_by_looking_again(walk: Walk) -> None:
    """The same walls, seen again and again, hardly count."""
    standing = [walk.measure() for _ in range(8)]
    walking = [walk.go(step) for step in ROUND[:8]]
    assert is_right(standing[-1], np.array(START))
    assert standing[-1].confidence < walking[-1].confidence
    assert walking[-1].state == "localized"


def test_before_the_first_measurement_there_is_nothing_to_remember(walk: Walk) -> None:
    assert walk.localizer.remember() is None


def test_a_compass_tells_alike_headings_apart() -> None:
    localizer = MarkovLocalizer(WORLD, COARSE)
    localizer.update(SECOND, np.zeros(3), Measurement(compass=(1.0, 0.1)))
    masses = localizer.grid.belief.sum(axis=(1, 2), dtype=np.float64)
    best = localizer.grid.headings[int(np.argmax(masses))]
    assert best == pytest.approx(1.0, abs=math.radians(5.0))


def test_a_scan_without_any_return_says_nothing(walk: Walk) -> None:
    silent = scan_measurement(
        np.full(90, np.inf, np.float32), (ANGLE_MIN, ANGLE_STEP), np.zeros(3), 60, RANGE_MAX
    )
    estimate = walk.localizer.update(SECOND, walk.odom, silent)
    states = walk.localizer.grid.grid.admissible_states
    assert walk.localizer.grid.entropy() == pytest.approx(math.log2(states), abs=2e-3)
    assert estimate.state == "unknown"


def test_a_scan_is_thinned_evenly_and_keeps_what_came_back() -> None:
    ranges = scan_at(WORLD, START)
    ranges[::3] = np.inf
    measurement = scan_measurement(ranges, (ANGLE_MIN, ANGLE_STEP), (0.1, 0.0, 0.2), 20, RANGE_MAX)
    assert measurement.ends is not None
    assert measurement.all_ends is not None
    assert len(measurement.ends) == 20
    assert len(measurement.all_ends) == 60
    first = ranges[1] * np.array([math.cos(BEARINGS[1]), math.sin(BEARINGS[1])])
    expected = se2.transform_points((0.1, 0.0, 0.2), first[None])
    assert measurement.ends[:1] == pytest.approx(expected, abs=1e-5)
    assert measurement.ends[-1:] == pytest.approx(measurement.all_ends[-1:])


def test_fewer_returns_than_beams_are_all_used() -> None:
    ranges = np.full(90, np.inf, np.float32)
    ranges[[4, 50]] = 2.0
    measurement = scan_measurement(ranges, (ANGLE_MIN, ANGLE_STEP), np.zeros(3), 60, RANGE_MAX)
    assert measurement.ends is not None
    assert len(measurement.ends) == 2


def test_a_ring_of_rangers_measures_from_the_robots_centre() -> None:
    mounts = np.array([[0.2, 0.0, 0.0], [0.0, 0.15, math.pi / 2.0], [0.1, 0.0, math.pi]])
    ranges = np.array([1.0, 2.0, np.inf], np.float32)
    seen = ranges_measurement(ranges, mounts.astype(np.float32), 4.0).ranges
    assert seen is not None
    assert seen.ranges[:2] == pytest.approx([1.2, 2.15])
    assert np.isinf(seen.ranges[2])
    assert seen.bearings == pytest.approx(mounts[:, 2])


def test_rangers_alone_find_the_robot_too() -> None:
    localizer = MarkovLocalizer(WORLD, COARSE)
    mounts = np.zeros((12, 3), np.float32)
    mounts[:, 2] = np.arange(12) * math.tau / 12
    pose, odom = np.array(START), np.zeros(3)
    every = BEARINGS[:, None] - mounts[:, 2]
    beams = np.argmin(np.abs(np.angle(np.exp(1j * every))), axis=0)
    for count, step in enumerate([(0.0, 0.0, 0.0), *ROUND]):
        pose, odom = se2.compose(pose, step), se2.compose(odom, step)
        ranges = scan_at(WORLD, pose)[beams]
        # The nearest laser beam stands for each ranger, so their bearings agree to 2 degrees.
        measurement = ranges_measurement(ranges, mounts, RANGE_MAX)
        compass = (float(pose[2]), 0.1)
        stamp = (count + 1) * SECOND
        estimate = localizer.update(stamp, odom, measurement.with_compass(compass))
    assert error(estimate.pose, pose)[0] < 0.25
    assert estimate.matched is None


def test_the_compass_is_carried_to_the_scan_by_odometry_and_forgotten_when_old() -> None:
    compass = CompassMemory()
    assert compass.at(0, 0.0) is None
    compass.keep(5 * SECOND, (3.0, 0.1), 0.5)
    yaw, sigma = compass.at(5 * SECOND + 1000, 0.9) or (0.0, 0.0)
    assert yaw == pytest.approx(3.4 - math.tau)
    assert sigma == 0.1
    assert compass.at(5 * SECOND + STALE_NS + 1, 0.9) is None


def test_belief_message_tells_samples_modes_and_marginal(walk: Walk) -> None:
    for _ in range(3):
        walk.measure()
    message = belief_message(walk.localizer, "abcd", walk.stamp_ns)
    assert message.samples.shape[1] == 4
    assert len(message.samples) <= SAMPLES
    assert message.samples[:, 3].sum() == pytest.approx(1.0, abs=1e-5)
    assert message.marginal is not None
    assert message.marginal.mass.sum() == pytest.approx(1.0, abs=1e-3)
    assert 1 <= len(message.modes) <= MODES
    assert message.modes[0].mass == max(mode.mass for mode in message.modes)
    assert message.matched == pytest.approx(1.0, abs=0.02)
    expected = naive.entropy_bits(walk.localizer.grid.belief.astype(float))
    assert message.entropy == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (-3.0, 7.0, 2.0)], ids=["plain", "turned"])
def test_marginal_is_cut_to_where_the_belief_is_and_lies_there(
    origin: tuple[float, float, float],
) -> None:
    localizer = MarkovLocalizer(flat(origin), COARSE)
    pose = se2.compose(origin, START)
    localizer.start_at(pose, np.diag([0.02, 0.02, 0.01]))
    marginal = belief_message(localizer, "abcd", 0).marginal
    assert marginal is not None
    corner = np.array([marginal.origin.x, marginal.origin.y, marginal.origin.theta])
    assert marginal.origin.theta == pytest.approx(origin[2])
    x, y = se2.between(corner, pose)[:2] / marginal.resolution
    rows, cols = marginal.mass.shape
    assert rows * cols < 150
    share = marginal.mass / marginal.mass.sum()
    assert (np.arange(cols) + 0.5) @ share.sum(axis=0) == pytest.approx(x, abs=0.6)
    assert (np.arange(rows) + 0.5) @ share.sum(axis=1) == pytest.approx(y, abs=0.6)


def test_an_even_belief_is_told_too(walk: Walk) -> None:
    message = belief_message(walk.localizer, "abcd", 0)
    assert message.modes == ()
    assert message.matched is None
    assert len(message.samples) == SAMPLES
    assert message.marginal is not None
    assert message.marginal.mass.sum() == pytest.approx(1.0, abs=1e-3)


def test_an_excluded_belief_is_told_as_nothing(walk: Walk) -> None:
    walk.localizer.grid.belief[:] = 0.0
    walk.localizer.grid.settle()
    message = belief_message(walk.localizer, "abcd", 0)
    assert len(message.samples) == 0
    assert message.entropy == 0.0


def test_pose_message_carries_the_estimate_and_the_moved_pose(walk: Walk) -> None:
    estimate = walk.measure()
    message = pose_message(estimate, np.array([1.0, 2.0, -3.0]), 77)
    assert (message.pose.x, message.pose.y, message.pose.theta) == (1.0, 2.0, -3.0)
    assert (message.stamp_ns, message.frame_id) == (77, "map")
    assert message.state == estimate.state
    assert np.array_equal(message.covariance, estimate.covariance)
