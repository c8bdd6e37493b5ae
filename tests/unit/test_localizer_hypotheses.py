"""Places followed from scan to scan: their probabilities, newcomers, and who is dropped."""

import math
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from drawing import draw
from localizer_world import BEARINGS, RANGE_MAX, ROUND, START, error, flat, look, poses_along
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.localizer.hypotheses import (
    FLOOR,
    HOPELESS,
    LATE,
    MOST_PLACES,
    Hypotheses,
)
from pilotage.localizer.measurement import Beams
from pilotage.localizer.obstacles import obstacles
from pilotage.localizer.places import KEPT_SCANS, ODD_SCAN, SAME_TURN, SAME_WAY

Array = NDArray[np.float64]

WORLD = flat()
AROUND = obstacles(WORLD)
NOBODY = np.empty((0, 3))
WAY = list(poses_along(START, ROUND))
WRONG = np.array([[9.0, 5.0, -2.0], [2.0, 2.0, 1.0], [10.5, 2.5, 0.5]])


def scan(pose: Array) -> Beams:
    beams = look(WORLD, pose).beams
    assert beams is not None
    return beams


def drive(followed: Hypotheses, poses: Iterable[Array], proposed: Array) -> Hypotheses:
    """Follow the robot along poses, its odometry counted from the map's origin."""
    for pose in poses:
        followed.follow(pose, scan(pose), proposed)
    return followed


def anywhere(count: int, seed: int = 0) -> Array:
    """Poses (count, 3) with half a metre of room about them."""
    rng = np.random.default_rng(seed)
    roomy = np.argwhere(AROUND.distance >= 5.0)
    places = AROUND.geometry.centres_of(roomy[rng.integers(len(roomy), size=count)])
    return np.column_stack([places, rng.uniform(-math.pi, math.pi, count)])


def test_nothing_is_followed_before_it_is_proposed() -> None:
    followed = drive(Hypotheses(AROUND), WAY[:2], NOBODY)
    assert len(followed.places) == 0


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_probabilities_sum_to_one_and_fall(seed: int, count: int) -> None:
    followed = Hypotheses(AROUND)
    for step, pose in enumerate(WAY[:4]):
        followed.follow(pose, scan(pose), anywhere(count, seed + step))
        share = np.exp(followed.places.log_share)
        assert share.sum() == pytest.approx(1.0)
        if step == 0:
            assert (np.diff(share) <= 0.0).all()


def test_the_right_one_of_several_places_wins_and_is_followed() -> None:
    followed = drive(Hypotheses(AROUND), WAY[:6], np.vstack([WRONG, WAY[0]]))
    best = followed.places
    assert error(best.poses[0], WAY[5])[0] < 0.05
    assert best.log_share[0] > math.log(0.99)
    assert best.met[0] > 0.9
    assert best.fit[0] > 0.3
    assert best.scans[0] == 6.0


def test_places_move_by_odometry_as_their_robot_would() -> None:
    """Whatever the odometry counts from."""
    offset = np.array([30.0, -4.0, 2.0])
    followed = Hypotheses(AROUND)
    for pose in WAY[:8]:
        followed.follow(se2.compose(offset, pose), scan(pose), WAY[0][None])
    assert error(followed.places.poses[0], WAY[7])[0] < 0.05


def test_places_that_are_one_are_followed_once() -> None:
    """However often poses beside the robot's are proposed."""
    beside = np.array([[0.0, 0.0, 0.0], [0.1, 0.1, 0.05], [-0.1, 0.0, 0.0]])
    followed = Hypotheses(AROUND)
    for pose in WAY[:3]:
        followed.follow(pose, scan(pose), pose + beside)
        assert len(followed.places) == 1
        assert error(followed.places.poses[0], pose)[0] < 0.05


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_no_two_places_are_one(seed: int) -> None:
    followed = drive(Hypotheses(AROUND), WAY[:3], np.vstack([WAY[0], anywhere(40, seed)]))
    poses = followed.places.poses
    for count, pose in enumerate(poses):
        for other in poses[:count]:
            away, turn = error(pose, other)
            assert away > SAME_WAY - 1e-9 or turn > SAME_TURN - 1e-9


def test_the_same_spot_the_other_way_round_is_another_place() -> None:
    turned = se2.compose(WAY[0], [0.0, 0.0, math.pi])
    followed = Hypotheses(AROUND)
    followed.follow(WAY[0], scan(WAY[0]), np.array([WAY[0], turned]))
    assert len(followed.places) <= 2
    assert error(followed.places.poses[0], WAY[0])[1] < 0.05


def test_a_newcomer_has_the_evidence_of_the_last_scans() -> None:
    """Found after six scans, a place stands as if it had been followed from the first."""
    early = drive(Hypotheses(AROUND), WAY[:6], np.vstack([WRONG, WAY[0]]))
    late = drive(Hypotheses(AROUND), WAY[:5], WRONG)
    late.follow(WAY[5], scan(WAY[5]), WAY[5][None])
    assert error(late.places.poses[0], WAY[5])[0] < 0.05
    assert late.places.recent[0, :6].sum() == pytest.approx(
        early.places.recent[0, :6].sum(), rel=0.1
    )
    assert late.places.log_share[0] == pytest.approx(early.places.log_share[0], abs=0.1)


PLAN = draw("""
    ##############################################
    #.......................#....................#
    #.......................#....................#
    #............................................#
    #............................................#
    #............................................#
    #....................#.......................#
    #....................#.......................#
    ##############################################
    """)
CELLS = np.kron(PLAN.cells, np.ones((2, 2), np.int8))
HALL = OccupancyMap(GridGeometry(CELLS.shape[0], CELLS.shape[1], 0.1), CELLS)
"""9.2 m long; half a turn about the middle takes it to itself."""


def alike(pose: Array) -> Array:
    """The other pose in the hall from which everything looks the same."""
    width, height = HALL.geometry.size_m
    return se2.compose([width, height, math.pi], pose)


def seen_in_the_hall(pose: Array) -> Beams:
    return Beams(BEARINGS, cast_scan(HALL, pose, BEARINGS, RANGE_MAX), np.zeros(3), RANGE_MAX)


def follow_in_the_hall(newcomer_after: int) -> tuple[float, float]:
    """Log-probabilities of a place that was followed all the time, and of its late twin."""
    followed = Hypotheses(obstacles(HALL))
    way = list(poses_along((1.5, 0.9, 0.1), [(0.15, 0.0, 0.01)] * newcomer_after))
    for count, pose in enumerate(way):
        proposed = {0: pose[None], newcomer_after: alike(pose)[None]}.get(count, NOBODY)
        followed.follow(pose, seen_in_the_hall(pose), proposed)
    assert len(followed.places) == 2
    away = [error(pose, way[-1])[0] for pose in followed.places.poses]
    one, other = np.argsort(away)
    assert away[one] < 0.05
    assert error(followed.places.poses[other], alike(followed.places.poses[one]))[0] < 0.02
    return float(followed.places.log_share[one]), float(followed.places.log_share[other])


@pytest.mark.parametrize("after", [1, 4, KEPT_SCANS - 2])
def test_a_twin_that_is_found_in_time_is_as_likely(after: int) -> None:
    one, other = follow_in_the_hall(after)
    assert math.exp(one) == pytest.approx(0.5, rel=0.05)
    assert math.exp(other) == pytest.approx(0.5, rel=0.05)


def test_a_twin_that_comes_very_late_lacks_what_the_old_place_had_before() -> None:
    one, other = follow_in_the_hall(KEPT_SCANS + 3)
    assert other - one == pytest.approx(LATE, abs=0.5)


def test_a_robot_that_was_carried_is_found_by_what_it_saw_since() -> None:
    """What it saw before speaks for where it was then, not against the new place."""
    followed = drive(Hypotheses(AROUND), WAY[:15], WAY[0][None])
    before = float(followed.places.recent[0, :-1].sum())
    there = WAY[1:9]
    for step, pose in enumerate(there):
        odometry = se2.compose(WAY[14], se2.between(there[0], pose))
        followed.follow(odometry, scan(pose), pose[None])
        if step == 0:
            newcomer = int(np.argmin([error(p, pose)[0] for p in followed.places.poses]))
            assert followed.places.recent[newcomer, 1:].sum() == pytest.approx(before, rel=0.01)
    assert error(followed.places.poses[0], there[-1])[0] < 0.05


def test_a_place_that_scans_contradict_is_in_need() -> None:
    followed = drive(Hypotheses(AROUND), WAY[:6], WAY[0][None])
    assert not followed.is_in_need
    for pose in WAY[6:8]:
        beams = scan(pose)
        through_all_walls = Beams(beams.bearings, beams.ranges + 3.0, np.zeros(3), RANGE_MAX)
        followed.follow(pose, through_all_walls, NOBODY)
    assert followed.is_in_need


def test_no_place_falls_below_the_floor() -> None:
    followed = drive(Hypotheses(AROUND), WAY[:10], np.vstack([WRONG, WAY[0]]))
    share = followed.places.log_share
    assert share.min() >= share.max() + FLOOR - 1e-9


def test_hopeless_places_are_dropped() -> None:
    followed = drive(Hypotheses(AROUND), WAY[:1], np.vstack([anywhere(50), WAY[:1]]))
    drive(followed, WAY[1:10], NOBODY)
    recent = followed.places.recent.sum(axis=1)
    assert recent.min() >= recent.max() - HOPELESS
    assert len(followed.places) < 20


def test_no_more_places_are_followed_than_there_is_time_for() -> None:
    followed = Hypotheses(AROUND)
    followed.follow(WAY[0], scan(WAY[0]), anywhere(600))
    assert len(followed.places) <= MOST_PLACES


def test_support_is_the_mean_evidence_of_what_was_new() -> None:
    followed = drive(Hypotheses(AROUND), WAY[:5], WAY[0][None])
    support = followed.support()
    assert len(support) == len(followed.places)
    assert support[0] == pytest.approx(followed.places.fit[0], abs=0.05)


def test_a_scan_seen_again_counts_a_quarter_a_ninth_a_sixteenth() -> None:
    rival = np.array(WAY[0]) + np.array([0.35, 0.0, 0.0])
    followed = Hypotheses(AROUND)
    leads = []
    for _ in range(4):
        followed.follow(WAY[0], scan(WAY[0]), np.array([WAY[0], rival]))
        leads.append(float(followed.places.recent[0, 0]))
    heard = [np.logaddexp(leads[0] / k**2, ODD_SCAN) for k in (1, 2, 3, 4)]
    assert leads == pytest.approx(heard, rel=0.01)


def test_forgetting_leaves_nothing() -> None:
    followed = drive(Hypotheses(AROUND), WAY[:3], WAY[0][None])
    followed.forget()
    assert len(followed.places) == 0
    followed.follow(np.zeros(3), scan(WAY[5]), WAY[5][None])
    assert error(followed.places.poses[0], WAY[5])[0] < 0.05


def test_odometry_that_counts_anew_leaves_the_places_where_they_are() -> None:
    followed = drive(Hypotheses(AROUND), WAY[:4], np.vstack([WRONG, WAY[0]]))
    before = followed.places.poses[0]
    followed.forget_odometry()
    elsewhere = np.array([70.0, 3.0, -1.0])
    followed.follow(elsewhere, scan(WAY[3]), NOBODY)
    assert error(followed.places.poses[0], before)[0] < 0.01
    moved = se2.compose(elsewhere, se2.between(WAY[3], WAY[4]))
    followed.follow(moved, scan(WAY[4]), NOBODY)
    assert error(followed.places.poses[0], WAY[4])[0] < 0.05


def test_others_than_the_laser_are_heard_and_repeat_themselves_as_it_does() -> None:
    """A compass tells the twins of the hall apart; standing, it says less each time."""
    truth = np.array([1.5, 0.9, 0.1])
    beams = seen_in_the_hall(truth)

    def compass(poses: Array) -> Array:
        return np.where(np.cos(poses[:, 2]) > 0.0, 0.0, -1.0)

    followed = Hypotheses(obstacles(HALL))
    leads = []
    for _ in range(3):
        followed.follow(np.zeros(3), beams, np.array([truth, alike(truth)]), compass)
        one, other = followed.places.log_share
        leads.append(float(one - other))
    assert error(followed.places.poses[0], truth)[0] < 0.1
    assert leads == pytest.approx([1.0, 1.0 + 1.0 / 4.0, 1.0 + 1.0 / 4.0 + 1.0 / 9.0], abs=0.04)


def test_how_well_a_scan_fits_is_told_however_old_its_surfaces_are() -> None:
    followed = drive(Hypotheses(AROUND), [WAY[0]] * 5, WAY[0][None])
    word = followed.fit_at(np.array([WAY[0], WRONG[0]]), scan(WAY[0]))
    assert word.fit[0] > 0.3
    assert word.fit[1] < 0.0
