"""From belief and scan to an estimate: alike places, compass, no laser, other buildings."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from drawing import draw
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
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.judge import CONFIRMED, DOUBT, LEAST_BEAMS, NO_RIVAL, Judge
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.measurement import Measurement, Ranges, scan_measurement
from pilotage.localizer.modes import Mode
from pilotage.localizer.place_modes import BELIEF_COUNTS, LEAST_BELIEF
from pilotage.localizer.verdict import VerdictParams

Array = NDArray[np.float64]
States = tuple[Array, Array]

WORLD = flat()
WAY = list(poses_along(START, ROUND))
ORIGIN = np.zeros(3)


def cloud(*places: tuple[Array, float]) -> States:
    """States about places, each with its mass."""
    rng = np.random.default_rng(2)
    poses = [pose + rng.normal(0.0, [0.05, 0.05, 0.03], (60, 3)) for pose, _ in places]
    weights = [np.full(60, mass / 60) for _, mass in places]
    return np.concatenate(poses), np.concatenate(weights)


def rangers(pose: Array) -> Measurement:
    """Few single ranges: no scan."""
    return Measurement(ranges=Ranges(np.zeros(1), np.array([2.0]), 4.0), compass=(pose[2], 0.1))


def blown_up(plan: str, marks: int = 4) -> OccupancyMap:
    """A plan whose marks are `marks` cells of 0.1 m wide."""
    cells = np.kron(draw(plan).cells, np.ones((marks, marks), np.int8))
    return OccupancyMap(GridGeometry(cells.shape[0], cells.shape[1], 0.1), cells)


def judged_along(judge: Judge, poses: list[Array], mass: float = 0.9) -> list[Estimate]:
    """What is said along poses while the belief is where the robot is."""
    return [
        judge.judge(pose, cloud((pose, mass)), look(WORLD, pose), surprise=False) for pose in poses
    ]


# A scan to tell by


def test_before_any_scan_nothing_is_said_but_where_the_map_lies() -> None:
    estimate = Judge(WORLD).estimate
    assert (estimate.state, estimate.confidence, estimate.modes) == ("unknown", 0.0, [])
    assert estimate.pose[:2] == pytest.approx([6.0, 3.2])
    assert estimate.covariance[0, 0] > 10.0


def test_a_belief_that_the_scans_confirm_is_localized_and_says_why() -> None:
    *_, last = judged_along(Judge(WORLD), WAY[:8])
    assert last.state == "localized"
    assert error(last.pose, WAY[7])[0] < 0.05
    assert last.confidence > 0.95
    assert last.matched == pytest.approx(1.0, abs=0.05)
    assert last.signs is not None
    assert last.signs.mass > 0.8
    assert last.signs.ahead > 3.0
    assert last.signs.support > 0.3
    assert last.modes[0].mass > 0.95
    assert (np.linalg.eigvalsh(last.covariance) > 0.0).all()


def test_the_more_of_the_belief_lies_there_the_surer() -> None:
    little, much = (judged_along(Judge(WORLD), WAY[:3], mass)[-1] for mass in (0.1, 0.9))
    assert much.confidence > little.confidence


def test_masses_of_the_modes_are_shares_of_one() -> None:
    judge = Judge(WORLD)
    everywhere = cloud(*((pose, 0.2) for pose in (WAY[0], WAY[9], np.array(ELSEWHERE))))
    for pose in WAY[:4]:
        estimate = judge.judge(pose, everywhere, look(WORLD, pose), surprise=False)
        masses = [mode.mass for mode in estimate.modes]
        assert sum(masses) <= 1.0 + 1e-9
        assert masses == sorted(masses, reverse=True)


def test_a_scan_that_contradicts_where_the_robot_should_be_is_a_surprise() -> None:
    judge = Judge(WORLD)
    judged_along(judge, WAY[:8])
    assert not judge.is_surprised(WAY[8], look(WORLD, WAY[8]))
    assert judge.is_surprised(WAY[8], look(WORLD, ELSEWHERE))


def test_only_a_localized_robot_with_a_scan_can_be_surprised() -> None:
    judge = Judge(WORLD)
    assert not judge.is_surprised(WAY[0], look(WORLD, ELSEWHERE))
    judged_along(judge, WAY[:8])
    assert not judge.is_surprised(WAY[8], Measurement())
    assert not judge.is_surprised(WAY[8], rangers(WAY[8]))


def test_a_surprise_is_lost_at_once() -> None:
    judge = Judge(WORLD)
    judged_along(judge, WAY[:8])
    elsewhere = np.array(ELSEWHERE)
    estimate = judge.judge(WAY[8], cloud((elsewhere, 0.5)), look(WORLD, elsewhere), surprise=True)
    assert estimate.state == "lost"


def test_after_a_surprise_the_old_place_may_prove_right_after_all() -> None:
    """A door was shut for a moment: the place where odometry puts the robot still competes."""
    judge = Judge(WORLD)
    judged_along(judge, WAY[:8])
    nothing = cloud((np.array(ELSEWHERE), 0.01))
    judge.judge(WAY[8], nothing, look(WORLD, WAY[8]), surprise=True)
    for pose in WAY[9:15]:
        estimate = judge.judge(pose, nothing, look(WORLD, pose), surprise=False)
    assert error(estimate.pose, WAY[14])[0] < 0.05


def test_a_belief_without_states_says_nothing() -> None:
    nothing = np.empty((0, 3)), np.empty(0)
    judge = Judge(WORLD)
    for seen in (look(WORLD, WAY[0]), rangers(WAY[0])):
        estimate = judge.judge(ORIGIN, nothing, seen, surprise=False)
        assert (estimate.state, estimate.confidence, estimate.modes) == ("unknown", 0.0, [])


def test_beginning_anew_forgets_the_places() -> None:
    judge = Judge(WORLD)
    judged_along(judge, WAY[:8])
    judge.begin([])
    assert (judge.estimate.state, judge.estimate.modes) == ("unknown", [])
    (estimate,) = judged_along(judge, [np.array(ELSEWHERE)])
    assert estimate.state == "unknown"
    assert error(estimate.pose, ELSEWHERE)[0] < 0.05


def test_what_is_told_at_the_beginning_is_the_best_of_the_given_modes() -> None:
    judge = Judge(WORLD)
    given = Mode(0.7, np.array(START), np.eye(3))
    judge.begin([given])
    assert judge.estimate.pose == pytest.approx(START)
    assert (judge.estimate.state, judge.estimate.confidence) == ("unknown", 0.0)


# Alike places

TWO_FOLD = blown_up("""
    ########################
    #...........#..........#
    #...........#..........#
    #......................#
    #......................#
    #..........#...........#
    #..........#...........#
    ########################
    """)
"""Half a turn about the middle takes this hall to itself."""


def alike(pose: Array) -> Array:
    """The other pose in the hall from which everything looks the same."""
    return se2.compose([*TWO_FOLD.geometry.size_m, math.pi], pose)


def walked_in_the_hall(*, has_compass: bool) -> tuple[list[Estimate], list[Array]]:
    localizer = MarkovLocalizer(TWO_FOLD, COARSE)
    poses = list(poses_along((1.5, 1.6, 0.1), [(0.25, 0.0, 0.0)] * 10))
    estimates = []
    for count, pose in enumerate(poses):
        compass = (float(pose[2]), 0.1) if has_compass else None
        seen = look(TWO_FOLD, pose).with_compass(compass)
        estimates.append(localizer.update((count + 1) * 10**9, pose, seen))
    return estimates, poses


def test_a_hall_that_looks_the_same_from_both_ends_is_ambiguous_all_the_way() -> None:
    estimates, poses = walked_in_the_hall(has_compass=False)
    for estimate, pose in zip(estimates[3:], poses[3:], strict=True):
        assert estimate.state == "ambiguous"
        assert [mode.mass for mode in estimate.modes[:2]] == pytest.approx([0.5, 0.5], rel=0.05)
        for twin in (pose, alike(pose)):
            assert min(error(mode.pose, twin)[0] for mode in estimate.modes[:2]) < 0.1


@pytest.mark.parametrize("is_twin", [False, True], ids=["here", "twin"])
def test_of_like_places_the_one_where_the_belief_is_comes_first(*, is_twin: bool) -> None:
    """The belief saw something that told them apart; by its power, not by its whole mass."""
    judge = Judge(TWO_FOLD)
    here = np.array([1.5, 1.6, 0.1])
    held, other = (alike(here), here) if is_twin else (here, alike(here))
    states = cloud((held, 0.8), (other, 0.2))
    estimate = judge.judge(ORIGIN, states, look(TWO_FOLD, here), surprise=False)
    assert error(estimate.pose, held)[0] < 0.1
    assert estimate.modes[0].mass / estimate.modes[1].mass == pytest.approx(
        (0.8 / 0.2) ** BELIEF_COUNTS, rel=0.1
    )


def test_a_place_that_the_belief_has_left_is_not_forgotten_but_hardly_likely() -> None:
    judge = Judge(TWO_FOLD)
    here = np.array([1.5, 1.6, 0.1])
    both = cloud((here, 0.5), (alike(here), 0.5))
    judge.judge(ORIGIN, both, look(TWO_FOLD, here), surprise=False)
    estimate = judge.judge(ORIGIN, cloud((here, 1.0)), look(TWO_FOLD, here), surprise=False)
    assert error(estimate.pose, here)[0] < 0.1
    assert estimate.modes[0].mass == pytest.approx(
        1.0 / (1.0 + LEAST_BELIEF**BELIEF_COUNTS), abs=2e-3
    )
    again = judge.judge(ORIGIN, both, look(TWO_FOLD, here), surprise=False)
    assert [mode.mass for mode in again.modes] == pytest.approx([0.5, 0.5], abs=0.05)


def test_with_a_compass_only_the_right_end_is_left() -> None:
    estimates, poses = walked_in_the_hall(has_compass=True)
    assert estimates[-1].state == "localized"
    assert len(estimates[-1].modes) == 1
    assert error(estimates[-1].pose, poses[-1])[0] < 0.1
    for estimate, pose in zip(estimates, poses, strict=True):
        assert estimate.state != "localized" or error(estimate.pose, pose)[0] < 0.1


# Where the robot is not on the map

MIRRORED = OccupancyMap(WORLD.geometry, WORLD.cells[:, ::-1].copy())
OTHER_FLAT = blown_up("""
    ########################
    #......#.......#.......#
    #......#.......#.......#
    #......#.......#.......#
    #......#...............#
    #..............#.......#
    #......#.......#.......#
    #####.####.#####.......#
    #......................#
    #..........#...........#
    #......................#
    ########################
    """)


@pytest.mark.parametrize(
    ("building", "start", "step"),
    [
        (OTHER_FLAT, (1.2, 2.2, 0.2), (0.1, 0.0, 0.3)),
        (OTHER_FLAT, (7.0, 1.0, 1.2), (0.06, 0.0, 0.25)),
        (MIRRORED, (10.0, 4.6, 1.0), (0.1, 0.0, 0.3)),
        (MIRRORED, (6.0, 1.2, 0.1), (0.12, 0.0, 0.2)),
    ],
    ids=["other room", "other hall", "mirrored room", "mirrored hall"],
)
def test_a_robot_in_another_building_is_never_called_localized(
    building: OccupancyMap, start: tuple[float, float, float], step: tuple[float, float, float]
) -> None:
    localizer = MarkovLocalizer(WORLD, COARSE)
    for count, pose in enumerate(poses_along(start, [step] * 24)):
        (cell,) = building.geometry.cells_of(pose[None, :2])
        assert building.is_free[tuple(cell)]
        estimate = localizer.update((count + 1) * 10**9, pose, look(building, pose))
        assert estimate.state != "localized"


def test_a_scan_of_rubbish_is_never_called_localized() -> None:
    localizer, rng = MarkovLocalizer(WORLD, COARSE), np.random.default_rng(5)
    for count in range(20):
        ranges = rng.uniform(0.3, 9.0, len(BEARINGS)).astype(np.float32)
        seen = scan_measurement(ranges, (ANGLE_MIN, ANGLE_STEP), np.zeros(3), 60, RANGE_MAX)
        odom = np.array([0.3 * count, 0.0, 0.0])
        assert localizer.update((count + 1) * 10**9, odom, seen).state != "localized"


# Carried off


@pytest.mark.parametrize("target", [ELSEWHERE, (9.8, 5.0, -1.2), (5.9, 3.9, 2.0)])
def test_a_kidnapped_robot_is_lost_before_it_is_found_where_it_is(
    target: tuple[float, float, float],
) -> None:
    localizer = MarkovLocalizer(WORLD, COARSE)
    for count, pose in enumerate(WAY):
        estimate = localizer.update((count + 1) * 10**9, pose, look(WORLD, pose))
    assert estimate.state == "localized"
    states = []
    carried = se2.compose(target, se2.inverse(WAY[-1]))
    for count, odom in enumerate(poses_along(WAY[-1], [(0.08, 0.0, 0.25)] * 12)):
        truth = se2.compose(carried, odom)
        estimate = localizer.update((count + 30) * 10**9, odom, look(WORLD, truth))
        states.append(estimate.state)
        assert estimate.state != "localized" or error(estimate.pose, truth)[0] < 0.2
    assert states[0] == "lost"
    assert states[-1] == "localized"


# Without a laser


def test_without_a_laser_the_mass_decides_once_it_stayed_where_it_should() -> None:
    judge = Judge(WORLD)
    said = [
        judge.judge(pose, cloud((pose, 0.99)), rangers(pose), surprise=False)
        for pose in WAY[: CONFIRMED + 3]
    ]
    first = [estimate.state for estimate in said].index("localized")
    assert first == CONFIRMED + VerdictParams().earned_by - 1
    assert said[0].confidence == 0.0
    assert said[-1].confidence == pytest.approx(0.99, abs=0.01)
    assert said[-1].matched is None
    assert said[-1].signs is None


def test_without_a_laser_too_little_mass_never_suffices() -> None:
    judge = Judge(WORLD)
    for pose in WAY:
        estimate = judge.judge(pose, cloud((pose, 0.8)), rangers(pose), surprise=False)
        assert estimate.state == "unknown"


def test_without_a_laser_a_mass_that_jumps_has_to_be_confirmed_anew() -> None:
    judge = Judge(WORLD)
    for pose in WAY[:6]:
        judge.judge(pose, cloud((pose, 0.99)), rangers(pose), surprise=False)
    assert judge.estimate.state == "localized"
    elsewhere = cloud((np.array(ELSEWHERE), 0.99))
    words = [
        judge.judge(WAY[6], elsewhere, rangers(WAY[6]), surprise=False).state
        for _ in range(CONFIRMED + VerdictParams().earned_by)
    ]
    assert words[0] == "lost"
    assert "localized" not in words[:-1]
    assert words[-1] == "localized"


def test_without_a_laser_two_masses_are_ambiguous() -> None:
    judge = Judge(WORLD)
    two = cloud((WAY[0], 0.5), (np.array(ELSEWHERE), 0.5))
    assert judge.judge(ORIGIN, two, rangers(WAY[0]), surprise=False).state == "ambiguous"


def test_a_scan_with_hardly_any_return_is_judged_by_mass() -> None:
    ranges = np.full(len(BEARINGS), np.inf, np.float32)
    ranges[: LEAST_BEAMS - 1] = scan_at(WORLD, WAY[0])[: LEAST_BEAMS - 1]
    seen = scan_measurement(ranges, (ANGLE_MIN, ANGLE_STEP), np.zeros(3), 60, RANGE_MAX)
    estimate = Judge(WORLD).judge(ORIGIN, cloud((WAY[0], 0.9)), seen, surprise=False)
    assert estimate.signs is None
    assert estimate.matched is None


def test_odometry_that_counts_anew_is_no_jump() -> None:
    judge = Judge(WORLD)
    judged_along(judge, WAY[:8])
    judge.restart_odometry()
    far = np.array([80.0, -3.0, 1.0])
    estimate = judge.judge(far, cloud((WAY[7], 0.9)), look(WORLD, WAY[7]), surprise=False)
    assert estimate.state == "localized"
    assert error(estimate.pose, WAY[7])[0] < 0.05


def test_where_a_twin_fits_as_well_neither_is_better() -> None:
    *_, last = walked_in_the_hall(has_compass=False)[0]
    assert last.signs is not None
    assert last.signs.better == pytest.approx(0.0, abs=0.03)


def test_a_place_that_a_compass_told_from_its_twin_need_not_be_told_again() -> None:
    localizer = MarkovLocalizer(TWO_FOLD, COARSE)
    for count, pose in enumerate(poses_along((1.5, 1.6, 0.1), [(0.25, 0.0, 0.0)] * 10)):
        compass = (float(pose[2]), 0.1) if count < 7 else None
        seen = look(TWO_FOLD, pose).with_compass(compass)
        last = localizer.update((count + 1) * 10**9, pose, seen)
    assert last.state == "localized"
    assert last.signs is not None
    assert last.signs.better == NO_RIVAL


def test_a_place_that_the_last_scans_contradict_is_doubted() -> None:
    """Beams go through its walls."""
    judge = Judge(WORLD)
    *_, before = judged_along(judge, WAY[:8])
    for pose in WAY[8:10]:
        seen = look(WORLD, pose)
        assert seen.beams is not None
        through = replace(seen.beams, ranges=seen.beams.ranges + 3.0)
        after = judge.judge(pose, cloud((pose, 0.9)), replace(seen, beams=through), surprise=False)
    assert before.confidence > 0.9
    assert after.confidence <= DOUBT
    assert after.state != "localized"
