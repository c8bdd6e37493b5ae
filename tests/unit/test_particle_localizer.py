"""Localization by particles, without a bus: the same offer as the Markov grid's."""

from dataclasses import replace

import numpy as np
import pytest

from localizer_world import ELSEWHERE, FEW_PARTICLES, ROUND, START, error, flat, look, poses_along
from pilotage.core import se2
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.measurement import Measurement, ranges_measurement
from pilotage.localizer.method import LocalizationMethod
from pilotage.localizer.particle_localizer import ParticleLocalizer, ParticleParams
from pilotage.localizer.particle_recovery import RecoveryParams

WORLD = flat()
NARROW = np.diag([0.01, 0.01, 0.005])
SECOND = 10**9


def particles(params: ParticleParams = FEW_PARTICLES) -> ParticleLocalizer:
    return ParticleLocalizer(WORLD, params, np.random.default_rng(0))


class Walk:
    """A robot with exact odometry, whose every pose is measured."""

    def __init__(self, localizer: ParticleLocalizer, start: tuple[float, float, float]) -> None:
        self.localizer = localizer
        self.pose, self.odom = np.array(start), np.zeros(3)
        self.stamp_ns = 0

    def measure(self) -> Estimate:
        self.stamp_ns += SECOND
        return self.localizer.update(self.stamp_ns, self.odom, look(WORLD, self.pose))

    def go(self, step: tuple[float, float, float]) -> Estimate:
        self.pose, self.odom = se2.compose(self.pose, step), se2.compose(self.odom, step)
        return self.measure()


@pytest.fixture
def walk() -> Walk:
    return Walk(particles(), START)


def is_right(estimate: Estimate, pose: np.ndarray) -> bool:
    away, turn = error(estimate.pose, pose)
    return away < 0.5 and turn < np.deg2rad(15.0)


def found(walk: Walk) -> Walk:
    walk.measure()
    for step in ROUND:
        walk.go(step)
    return walk


def test_it_offers_what_every_method_offers() -> None:
    method: LocalizationMethod = particles()
    assert method.name == "mcl"
    assert method.params.beams == 60
    assert method.estimate.state == "unknown"


def test_an_unknown_robot_is_found_and_followed(walk: Walk) -> None:
    estimate = found(walk).localizer.estimate
    assert estimate.state == "localized"
    assert is_right(estimate, walk.pose)
    away, turn = error(estimate.pose, walk.pose)
    assert away < 0.05
    assert turn < 0.02
    assert estimate.modes[0].mass > 0.9


def test_fewer_particles_follow_than_search(walk: Walk) -> None:
    searching = len(walk.localizer.filter.poses)
    found(walk)
    assert searching == FEW_PARTICLES.kld.most
    assert len(walk.localizer.filter.poses) <= 2 * FEW_PARTICLES.kld.least


def test_a_known_start_is_believed_but_has_to_be_earned() -> None:
    localizer = particles()
    localizer.start_at(START, NARROW)
    assert localizer.estimate.state == "unknown"
    assert is_right(localizer.estimate, np.array(START))
    walk = Walk(localizer, START)
    states = [walk.measure().state, *(walk.go(step).state for step in ROUND[:5])]
    assert states[-1] == "localized"


def test_a_start_in_a_wall_is_refused_and_changes_nothing(walk: Walk) -> None:
    before = walk.localizer.filter.poses.copy()
    with pytest.raises(ValueError, match="free space"):
        walk.localizer.start_at([-30.0, 0.0, 0.0], NARROW)
    assert (walk.localizer.filter.poses == before).all()


def carried_off(walk: Walk) -> list[tuple[str, bool]]:
    """State and rightness of the estimates after a robot has been carried to ELSEWHERE."""
    walk.pose = np.array(ELSEWHERE)
    told: list[tuple[str, bool]] = []
    for _ in range(14):
        estimate = walk.go((0.1, 0.0, 0.1))
        told.append((estimate.state, is_right(estimate, walk.pose)))
    return told


def test_a_kidnapped_robot_is_lost_before_it_is_found_again(walk: Walk) -> None:
    told = carried_off(found(walk))
    assert told[0][0] != "localized"
    assert ("localized", False) not in told
    assert told[-1] == ("localized", True)


def test_without_recovery_a_kidnapped_robot_stays_lost(walk: Walk) -> None:
    found(walk).localizer.choose_algorithm("m1", 0.0)
    assert not any(right for _, right in carried_off(walk))


def test_amcls_memories_of_zero_mean_no_recovery_but_by_surprise() -> None:
    params = replace(FEW_PARTICLES, recovery=RecoveryParams(slow=0.0, fast=0.0, surprised=0.0))
    walk = Walk(particles(params), START)
    assert not any(right for _, right in carried_off(found(walk)))


def test_a_robot_that_stands_measures_again_after_a_while(walk: Walk) -> None:
    localizer, seen = walk.localizer, look(WORLD, START)
    assert localizer.wants(SECOND, walk.odom, seen)
    walk.measure()
    assert not localizer.wants(SECOND + SECOND // 2, walk.odom, seen)
    assert localizer.wants(2 * SECOND, walk.odom, seen)
    assert localizer.wants(SECOND + 1, np.array([0.3, 0.0, 0.0]), seen)
    assert localizer.wants(SECOND - 5, walk.odom, seen), "the clock went back"


def test_the_pose_moves_on_with_odometry(walk: Walk) -> None:
    found(walk)
    step = np.array([0.2, 0.05, 0.3])
    moved = walk.localizer.pose_at(se2.compose(walk.odom, step))
    assert moved == pytest.approx(se2.compose(walk.localizer.estimate.pose, step))
    walk.localizer.restart_odometry()
    assert walk.localizer.pose_at(np.array([9.0, 9.0, 0.0])) == pytest.approx(
        walk.localizer.estimate.pose
    )


def test_a_robot_resumes_where_it_was(walk: Walk) -> None:
    assert walk.localizer.remember() is None
    memory = found(walk).localizer.remember()
    assert memory is not None
    assert memory.was_localized
    again = particles()
    again.resume(memory)
    assert is_right(again.estimate, walk.pose)
    walk.localizer = again
    assert walk.go((0.1, 0.0, 0.0)).state == "localized"


def test_forgetting_begins_anew(walk: Walk) -> None:
    found(walk).localizer.start_anywhere()
    assert walk.localizer.estimate.state == "unknown"
    assert walk.localizer.estimate.modes == []
    assert walk.localizer.remember() is None


def test_the_same_seed_gives_the_same_estimates() -> None:
    one, other = (found(Walk(particles(), START)) for _ in range(2))
    assert (one.localizer.estimate.pose == other.localizer.estimate.pose).all()


def test_few_rangers_and_a_compass_find_a_robot_too() -> None:
    localizer = particles()
    directions = np.linspace(-np.pi, np.pi, 8, endpoint=False)
    mounts = np.column_stack([np.zeros((8, 2)), directions]).astype(np.float32)
    odom, steps = np.zeros(3), [(0.0, 0.0, 0.0), *ROUND]
    for n, (pose, step) in enumerate(zip(poses_along(START, ROUND), steps, strict=True)):
        odom = se2.compose(odom, step)
        ends = look(WORLD, pose).all_ends
        assert ends is not None
        bearings = np.arctan2(ends[:, 1], ends[:, 0])
        nearest = [np.argmin(np.abs(np.angle(np.exp(1j * (bearings - d))))) for d in directions]
        ranges = np.hypot(*ends[nearest].T).astype(np.float32)
        seen = ranges_measurement(ranges, mounts, 6.0).with_compass((float(pose[2]), 0.2))
        estimate = localizer.update(n * SECOND, odom, seen)
    assert is_right(estimate, pose)


def test_a_measurement_of_nothing_changes_no_weights(walk: Walk) -> None:
    walk.localizer.update(SECOND, np.zeros(3), Measurement())
    nothing = Measurement(ends=np.empty((0, 2)), all_ends=np.empty((0, 2)))
    estimate = walk.localizer.update(2 * SECOND, np.zeros(3), nothing)
    assert estimate.state == "unknown"
    weights = walk.localizer.filter.weights
    assert weights == pytest.approx(1.0 / len(weights))
