"""Pose tracking on the walls of a map, without a bus: what the other methods offer, and honesty."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from localizer_world import COARSE, ELSEWHERE, ROUND, START, error, flat, look, poses_along
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.experiments.clutter import CONDITIONS, altered
from pilotage.experiments.tracks import drive_through
from pilotage.localizer.ekf_belief import GaussianBelief, NoBelief
from pilotage.localizer.ekf_localizer import EkfLocalizer, EkfParams
from pilotage.localizer.ekf_trust import TrustParams
from pilotage.localizer.estimate import Estimate, Memory
from pilotage.localizer.line_ekf import GaussianPose
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.measurement import Measurement, scan_measurement
from pilotage.localizer.method import LocalizationMethod
from pilotage.localizer.methods import known
from pilotage.localizer.particle_start import free_space

Array = NDArray[np.float64]

WORLD = flat()
BEARINGS = np.linspace(-0.75 * np.pi, 0.75 * np.pi, 271)
STEP = float(BEARINGS[1] - BEARINGS[0])
NEAR = np.diag([0.01, 0.01, 0.003])
BY_HAND = np.diag([0.25, 0.25, np.deg2rad(15.0) ** 2])
SECOND = 10**9
NOTHING = Measurement()


def scan(pose: Array, world: OccupancyMap = WORLD) -> Measurement:
    ranges = cast_scan(world, pose, BEARINGS, 12.0).astype(np.float32)
    return scan_measurement(ranges, (float(BEARINGS[0]), STEP), np.zeros(3), 60, 12.0)


class Walk:
    """A robot with exact odometry, whose every pose is measured."""

    def __init__(self, localizer: EkfLocalizer, start: tuple[float, float, float] = START) -> None:
        self.localizer = localizer
        self.pose, self.odom = np.array(start), np.array([5.0, -2.0, 1.0])
        self.stamp_ns = 0

    def measure(self, seen: Measurement | None = None) -> Estimate:
        self.stamp_ns += SECOND
        return self.localizer.update(self.stamp_ns, self.odom, seen or scan(self.pose))

    def go(self, step: tuple[float, float, float], seen: Measurement | None = None) -> Estimate:
        self.pose, self.odom = se2.compose(self.pose, step), se2.compose(self.odom, step)
        return self.measure(seen)

    def is_right(self) -> bool:
        away, turn = error(self.localizer.estimate.pose, self.pose)
        return away < 0.1 and turn < 0.03


@pytest.fixture(scope="module")
def made() -> EkfLocalizer:
    return EkfLocalizer(WORLD)


@pytest.fixture
def localizer(made: EkfLocalizer) -> EkfLocalizer:
    made.start_anywhere()
    return made


@pytest.fixture
def walk(localizer: EkfLocalizer) -> Walk:
    localizer.start_at(START, NEAR)
    return Walk(localizer)


def followed(walk: Walk) -> Walk:
    walk.measure()
    for step in ROUND:
        walk.go(step)
    assert walk.localizer.estimate.state == "localized"
    return walk


def test_it_offers_what_every_method_offers(localizer: EkfLocalizer) -> None:
    method: LocalizationMethod = localizer
    assert method.name == "ekf"
    assert method.params.beams == 60
    assert method.sight is None
    assert method.estimate.state == "unknown"


def test_a_robot_that_starts_anywhere_stays_unknown_and_says_so(localizer: EkfLocalizer) -> None:
    walk = Walk(localizer)
    states = [walk.go(step).state for step in ROUND]
    assert set(states) == {"unknown"}
    assert localizer.estimate.confidence == 0.0
    assert localizer.estimate.modes == []
    assert len(localizer.matched) == 0
    assert isinstance(localizer.belief, NoBelief)


def test_a_known_start_is_followed_but_has_to_be_earned(walk: Walk) -> None:
    assert walk.localizer.estimate.state == "unknown"
    states = [walk.measure().state, *(walk.go(step).state for step in ROUND)]
    assert states[0] == "unknown"
    assert states[-10:] == ["localized"] * 10
    assert walk.is_right()
    assert walk.localizer.estimate.matched is not None
    assert walk.localizer.estimate.matched > 0.8


def test_a_start_given_by_hand_may_be_off_by_half_a_metre(localizer: EkfLocalizer) -> None:
    for away in ([0.4, 0.2, 0.15], [-0.3, 0.3, -0.2], [0.0, -0.45, 0.25]):
        localizer.start_at(np.array(START) + away, BY_HAND)
        walk = Walk(localizer)
        for step in ROUND:
            walk.go(step)
        assert walk.is_right()
        assert localizer.estimate.state == "localized"


def test_a_start_in_a_wall_or_that_is_none_is_refused_and_changes_nothing(walk: Walk) -> None:
    before = followed(walk).localizer.estimate
    for pose, covariance, reason in (
        ([-30.0, 0.0, 0.0], NEAR, "free space"),
        (START, np.diag([-1.0, 1.0, 1.0]), "not symmetric and positive"),
        (START, np.array([[1.0, 5.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), "not symmetric"),
    ):
        with pytest.raises(ValueError, match=reason):
            walk.localizer.start_at(pose, covariance)
    assert walk.localizer.estimate is before


def test_a_start_known_exactly_is_one_too(localizer: EkfLocalizer) -> None:
    localizer.start_at(START, np.zeros((3, 3)))
    assert Walk(localizer).measure().pose == pytest.approx(START, abs=0.02)


def test_a_robot_that_was_carried_off_is_lost_at_once_and_never_localized_elsewhere(
    walk: Walk,
) -> None:
    followed(walk).pose = np.array(ELSEWHERE)
    told = [walk.go((0.1, 0.0, 0.1)) for _ in range(20)]
    assert told[0].state == "lost"
    assert all(one.state != "localized" for one in told)
    assert told[0].confidence < 0.45
    assert len(walk.localizer.matched) <= 4


def test_it_is_localized_again_from_where_somebody_finds_it(walk: Walk) -> None:
    followed(walk).pose = np.array(ELSEWHERE)
    walk.go((0.0, 0.0, 0.3))
    walk.localizer.start_at(walk.pose + np.array([0.2, -0.1, 0.1]), BY_HAND)
    for _ in range(8):
        walk.go((0.1, 0.0, 0.2))
    assert walk.localizer.estimate.state == "localized"
    assert walk.is_right()


def test_without_pairs_for_long_it_is_lost(localizer: EkfLocalizer) -> None:
    """In the middle of a hall, beyond the reach of its laser, nothing is matched."""
    params = EkfParams(trust=TrustParams(starved=4.0))
    starving = EkfLocalizer(WORLD, params)
    starving.start_at(START, NEAR)
    walk = followed(Walk(starving))
    short = np.where(np.arange(271) % 40 == 0, 1.0, np.inf).astype(np.float32)
    seen = scan_measurement(short, (float(BEARINGS[0]), STEP), np.zeros(3), 60, 12.0)
    states = [walk.go((0.25, 0.0, 0.0), seen).state for _ in range(6)]
    assert states[-1] == "lost"
    assert localizer.estimate.state == "unknown", "another localizer has nothing to do with it"


def test_driving_blind_it_gets_less_sure_until_it_is_unknown(walk: Walk) -> None:
    followed(walk)
    told = [walk.go((0.2, 0.0, 0.3), NOTHING) for _ in range(60)]
    spread = [one.covariance[2, 2] for one in told]
    assert (np.diff(spread) > 0.0).all()
    assert told[0].state == "localized"
    assert told[-1].state != "localized"
    assert told[-1].confidence < 0.77
    assert walk.localizer.pose_at(walk.odom) == pytest.approx(told[-1].pose)


def test_a_covered_laser_tells_nothing(walk: Walk) -> None:
    followed(walk)
    covered = scan_measurement(
        np.full(271, np.inf, np.float32), (float(BEARINGS[0]), STEP), np.zeros(3), 60, 12.0
    )
    before = walk.localizer.estimate
    after = walk.go((0.1, 0.0, 0.0), covered)
    assert after.matched is None
    assert after.covariance[0, 0] > before.covariance[0, 0]
    assert after.state == "localized"


def test_a_robot_that_stands_measures_again_after_a_while_and_grows_no_surer(walk: Walk) -> None:
    localizer = followed(walk).localizer
    odom, now = walk.odom, walk.stamp_ns
    assert not localizer.wants(now + SECOND // 10, odom, NOTHING)
    assert localizer.wants(now + SECOND // 5, odom, NOTHING)
    assert localizer.wants(now + 1, se2.compose(odom, [0.11, 0.0, 0.0]), NOTHING)
    assert localizer.wants(now - 5, odom, NOTHING), "the clock went back"
    before = np.sqrt(np.diag(localizer.estimate.covariance))
    for _ in range(30):
        walk.measure()
    after = np.sqrt(np.diag(localizer.estimate.covariance))
    assert (after > 0.5 * before).all()


def test_pairs_are_shown_where_they_lie(walk: Walk) -> None:
    matched = followed(walk).localizer.matched
    assert matched.lines >= 3
    assert np.abs(matched.seen - matched.expected).max() < 0.4
    away = np.hypot(*(matched.seen - matched.expected).reshape(-1, 2).T)
    assert np.median(away) < 0.05
    corners = matched.seen[matched.lines :]
    assert (corners[:, 0] == corners[:, 1]).all()


def test_a_robot_resumes_where_it_was(walk: Walk) -> None:
    assert walk.localizer.remember() is None
    memory = followed(walk).localizer.remember()
    assert memory is not None
    assert memory.was_localized
    walk.localizer.start_anywhere()
    walk.localizer.resume(memory)
    assert walk.is_right()
    assert walk.localizer.estimate.state == "unknown", "a scan has to confirm it"
    assert walk.go((0.1, 0.0, 0.0)).state == "localized"
    assert walk.is_right()


def test_a_memory_of_several_places_is_none(localizer: EkfLocalizer) -> None:
    poses = np.array([START, ELSEWHERE, [6.0, 5.0, 0.0]])
    memory = Memory(poses, np.array([0.4, 0.35, 0.25]), np.zeros(3), SECOND, was_localized=False)
    localizer.resume(memory)
    assert localizer.estimate.modes == []
    assert isinstance(localizer.belief, NoBelief)


def test_another_methods_knowledge_is_gone_on_from() -> None:
    """Markov finds the robot; the filter takes over, and hands back what it knows."""
    markov, odom = MarkovLocalizer(WORLD, COARSE), np.zeros(3)
    truth = list(poses_along(START, ROUND))
    for count, pose in enumerate(truth):
        odom = se2.between(truth[0], pose)
        markov.update(count * SECOND, odom, look(WORLD, pose))
    memory = known(markov, odom, len(truth) * SECOND)
    assert memory is not None
    ekf = EkfLocalizer(WORLD)
    ekf.resume(memory)
    walk = Walk(ekf)
    walk.pose, walk.odom, walk.stamp_ns = truth[-1], odom, len(truth) * SECOND
    assert [walk.go((0.05, 0.0, 0.1)).state for _ in range(4)][-1] == "localized"
    assert walk.is_right()
    back = known(ekf, walk.odom, walk.stamp_ns)
    assert back is not None
    assert back.weights.sum() == pytest.approx(1.0)


def test_what_is_not_known_is_not_handed_over(localizer: EkfLocalizer) -> None:
    assert known(localizer, np.zeros(3), 0) is None


def test_the_pose_moves_on_with_odometry_until_that_begins_anew(walk: Walk) -> None:
    localizer = followed(walk).localizer
    step = np.array([0.2, 0.05, 0.3])
    moved = localizer.pose_at(se2.compose(walk.odom, step))
    assert moved == pytest.approx(se2.compose(localizer.estimate.pose, step))
    localizer.restart_odometry()
    assert localizer.pose_at(np.array([9.0, 9.0, 0.0])) == pytest.approx(localizer.estimate.pose)
    walk.odom = np.array([0.0, 0.0, 2.0])
    assert walk.measure().state == "localized"
    assert walk.is_right()


def test_choosing_m1_or_m2_changes_nothing(walk: Walk) -> None:
    walk.localizer.choose_algorithm("m1", 0.0)
    followed(walk)
    assert walk.is_right()


def test_a_map_without_floor_is_refused_and_one_without_walls_is_not() -> None:
    full = OccupancyMap(GridGeometry(4, 4, 0.1), np.full((4, 4), 100, np.int8))
    with pytest.raises(ValueError, match="no free cell"):
        EkfLocalizer(full)
    bare = EkfLocalizer(OccupancyMap(GridGeometry(40, 40, 0.1), np.zeros((40, 40), np.int8)))
    bare.start_at([2.0, 2.0, 0.0], NEAR)
    assert bare.update(SECOND, np.zeros(3), scan(np.array(START))).state == "unknown"


@pytest.mark.parametrize("condition", ["clean", "hard"])
def test_tracks_through_a_cluttered_flat_are_followed(condition: str) -> None:
    """What is said to be localized is right, and most of the way it is said."""
    rng, cluttered = np.random.default_rng(4), CONDITIONS[condition]
    track = drive_through(altered(WORLD, cluttered, rng), cluttered, (60,), rng)
    localizer = EkfLocalizer(WORLD)
    localizer.start_at(track.truth[0], BY_HAND)
    angles = float(track.laser.bearings[0]), float(np.diff(track.laser.bearings[:2])[0])
    mount, reach = np.array([track.laser.mount_x, 0.0, 0.0]), track.laser.range_max
    states, right = [], []
    for index in range(60):
        seen = scan_measurement(track.ranges[index], angles, mount, 60, reach)
        estimate = localizer.update(index * SECOND, track.odometry[index], seen)
        away, turn = error(estimate.pose, track.truth[index])
        states.append(estimate.state == "localized")
        right.append(away < 0.5 and turn < np.deg2rad(15.0))
    assert np.mean(states) > 0.7
    assert all(right[k] for k in range(60) if states[k])


def test_a_belief_shows_where_its_mass_lies() -> None:
    geometry = replace(WORLD.geometry, origin=(1.0, 2.0, 0.5))
    mean = se2.compose(geometry.origin, [3.0, 2.0, 0.1])
    belief = GaussianBelief(GaussianPose(mean, np.diag([0.04, 0.01, 0.01])), geometry)
    marginal = belief.marginal()
    assert marginal.sum() == pytest.approx(1.0, abs=1e-4)
    heaviest = np.unravel_index(int(np.argmax(marginal)), marginal.shape)
    assert geometry.centres_of(np.array([heaviest]))[0] == pytest.approx(mean[:2], abs=0.08)


def test_a_belief_off_the_map_has_a_marginal_too() -> None:
    pose = GaussianPose(np.array([-50.0, 3.0, 0.0]), NEAR)
    assert GaussianBelief(pose, WORLD.geometry).marginal().shape == WORLD.geometry.shape


def test_entropy_grows_with_what_is_not_known() -> None:
    nothing = NoBelief(free_space(WORLD))
    sure, less = (
        GaussianBelief(GaussianPose(np.zeros(3), NEAR * factor), WORLD.geometry).entropy()
        for factor in (1.0, 64.0)
    )
    assert less == pytest.approx(sure + 9.0, abs=1e-6), (
        "64 = 2^6 in each of three directions: 9 bit"
    )
    assert nothing.entropy() > less
    exact = GaussianBelief(GaussianPose(np.zeros(3), np.eye(3) * 1e-9), WORLD.geometry)
    assert exact.entropy() == 0.0


def test_a_belief_in_nothing_lies_evenly_over_the_floor() -> None:
    free = free_space(WORLD)
    nothing = NoBelief(free)
    poses, weights = nothing.heaviest(2000)
    assert len(poses) <= 2000
    assert free.holds(poses).all()
    assert weights.sum() < 0.5
    assert nothing.marginal().sum() == pytest.approx(1.0, abs=1e-4)
    assert len(np.unique(poses[:, 2])) == 8
