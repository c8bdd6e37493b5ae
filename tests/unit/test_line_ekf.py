"""The filter of lines and corners on walls drawn by their ends."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from ekf_world import (
    MAPPED,
    NICHED,
    ROOM,
    SEEN,
    corridor,
    erring,
    lines_between,
    seen_from,
    walls_around,
)
from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.lines import Lines
from pilotage.localizer.ekf_walls import Walls
from pilotage.localizer.line_ekf import (
    EkfStep,
    GaussianPose,
    LineEkfParams,
    match_corners,
    match_lines,
    predict,
    track,
)
from pilotage.localizer.line_ekf_update import Pairs, corrected
from pilotage.localizer.motion_spread import MotionSpread

Array = NDArray[np.float64]

PARAMS = LineEkfParams()
ALONE = replace(PARAMS, slip=None)
"""Without second thoughts about odometry."""
STANDING = np.zeros(3)
NEAR = np.diag([0.01, 0.01, 0.003])
HERE = np.array([2.0, 2.0, 0.3])


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(3)


def off(pose: Array, truth: Array) -> Array:
    away = pose - truth
    away[2] = wrap(float(away[2]))
    return away


def squared_error(belief: GaussianPose, truth: Array) -> float:
    """The normalized estimation error squared (NEES): 3 on average if the covariance is true."""
    away = off(belief.mean, truth)
    return float(away @ np.linalg.solve(belief.covariance, away))


def information(step: EkfStep) -> Array:
    """What a cycle has added to what was known before."""
    gained: Array = np.linalg.inv(step.belief.covariance) - np.linalg.inv(step.predicted.covariance)
    return gained


def wall(begin: tuple[float, float], end: tuple[float, float], noise: Array = SEEN) -> Lines:
    return lines_between([[begin, end]], noise)


def one_step(truth: Array, belief: GaussianPose, known: Walls, seed: int = 0) -> EkfStep:
    seen = seen_from(truth, known, np.random.default_rng(seed))
    return track(belief, STANDING, seen, known, PARAMS)


def test_prediction_follows_odometry_and_grows_less_sure() -> None:
    before = GaussianPose(HERE, NEAR)
    after = predict(before, np.array([1.0, 0.0, 0.5]), MotionSpread())
    assert after.mean == pytest.approx(se2.compose(HERE, [1.0, 0.0, 0.5]))
    assert np.linalg.eigvalsh(after.covariance - NEAR)[0] > -1e-9
    assert after.covariance[2, 2] > NEAR[2, 2]


def test_walls_of_a_room_correct_the_whole_pose() -> None:
    known = walls_around(ROOM)
    step = one_step(HERE, GaussianPose(HERE + np.array([0.15, -0.1, 0.05]), NEAR), known)
    assert len(step.pairs.lines) == 3, "the fourth wall is out of sight"
    assert np.abs(off(step.belief.mean, HERE)) == pytest.approx(np.zeros(3), abs=0.06)
    assert np.sqrt(np.diag(step.belief.covariance)).max() < 0.03


def test_a_bare_corridor_leaves_the_way_along_it_unknown() -> None:
    truth = np.array([0.0, 0.2, 0.1])
    belief = GaussianPose(truth + np.array([0.3, 0.1, -0.05]), np.diag([0.09, 0.09, 0.01]))
    after = one_step(truth, belief, corridor()).belief
    assert after.covariance[0, 0] == pytest.approx(0.09, rel=0.02)
    assert np.sqrt(after.covariance[1, 1]) < 0.03
    assert np.sqrt(after.covariance[2, 2]) < 0.02
    assert after.mean[0] == pytest.approx(belief.mean[0], abs=0.02)
    assert after.mean[1] == pytest.approx(truth[1], abs=0.06)


def test_along_a_corridor_it_gets_less_and_less_sure_of_the_way() -> None:
    rng, known, truth = np.random.default_rng(0), corridor(), np.array([-10.0, 0.0, 0.0])
    belief, along, across = GaussianPose(truth, NEAR), [], []
    for _ in range(40):
        truth = se2.compose(truth, [0.25, 0.0, 0.0])
        belief = track(
            belief, np.array([0.25, 0.0, 0.0]), seen_from(truth, known, rng), known, PARAMS
        ).belief
        along.append(belief.covariance[0, 0])
        across.append(belief.covariance[1, 1])
    assert (np.diff(along) > 0.0).all()
    assert along[-1] > 4.0 * along[0]
    assert max(across) < 0.04**2


def test_a_wall_is_not_its_own_back() -> None:
    """A thin wall between two rooms has two faces, 0.1 m apart; only one looks at the robot."""
    faces = Walls.of(lines_between([[[0.0, 0.0], [6.0, 0.0]], [[6.0, -0.1], [0.0, -0.1]]], MAPPED))
    for side, face in ((1.0, 0), (-1.1, 1)):
        pose = np.array([3.0, side, 0.2])
        seen = faces.lines.chosen(np.array([face])).moved(se2.inverse(pose))
        wide = np.diag([0.04, 0.04, 0.01])
        partners, _ = match_lines(GaussianPose(pose, wide), seen, faces.lines, PARAMS)
        assert partners.tolist() == [face]


def test_only_what_lies_along_a_wall_is_a_piece_of_it() -> None:
    """Two walls in one line, with a doorway of 4 m between: what is seen there is neither."""
    known = lines_between([[[0.0, 0.0], [4.0, 0.0]], [[8.0, 0.0], [12.0, 0.0]]], MAPPED)
    pose = np.array([6.0, 2.0, 0.0])
    belief = GaussianPose(pose, np.diag([0.01, 0.01, 1e-4]))

    def partner_of(begin: float, end: float) -> int:
        seen = wall((begin, 0.0), (end, 0.0)).moved(se2.inverse(pose))
        return int(match_lines(belief, seen, known, PARAMS)[0][0])

    assert partner_of(1.0, 3.0) == 0
    assert partner_of(9.0, 11.0) == 1
    assert partner_of(4.8, 7.2) == -1
    assert partner_of(3.0, 5.2) == 0
    assert partner_of(3.5, 7.0) == -1


def test_one_wall_may_be_seen_in_pieces() -> None:
    known = Walls.of(lines_between([[[0.0, 0.0], [10.0, 0.0]]], MAPPED))
    pose = np.array([5.0, 2.0, 0.0])
    pieces = lines_between([[[x, 0.0], [x + 1.0, 0.0]] for x in (1.0, 4.0, 7.0)])
    step = track(
        GaussianPose(pose, NEAR), STANDING, Walls.of(pieces.moved(se2.inverse(pose))), known, PARAMS
    )
    assert step.pairs.lines.tolist() == [[0, 0], [1, 0], [2, 0]]


def test_furniture_off_the_map_is_matched_with_nothing() -> None:
    known, pose = walls_around(ROOM), HERE
    cupboard = wall((1.0, 0.6), (2.5, 0.6)).moved(se2.inverse(pose))
    belief = GaussianPose(pose, np.diag([1e-3, 1e-3, 1e-4]))
    step = track(belief, STANDING, Walls.of(cupboard), known, ALONE)
    assert len(step.pairs) == 0
    assert step.belief.mean == pytest.approx(step.predicted.mean)
    assert step.belief.covariance == pytest.approx(step.predicted.covariance)


def test_a_long_wall_tells_the_heading_before_short_ones_are_told_apart() -> None:
    """Turned by 15 degrees, the niche's back and the wall beside it are easily mixed up."""
    truth, known = np.array([5.0, 2.0, -1.4]), walls_around(NICHED)
    belief = GaussianPose(truth + np.array([0.1, 0.1, 0.26]), np.diag([0.04, 0.04, 0.07]))
    step = one_step(truth, belief, known)
    assert np.hypot(*off(step.belief.mean, truth)[:2]) < 0.05
    assert abs(off(step.belief.mean, truth)[2]) < 0.02
    ends = np.round(step.near.lines.ends[step.pairs.lines[:, 1]], 1)
    assert len(np.unique(ends, axis=0)) == len(ends)


@pytest.mark.parametrize("seed", range(6))
def test_a_start_given_by_hand_is_found_within_half_a_metre(seed: int) -> None:
    """Known to 0.5 m and 15 degrees, the nearest walls are often the wrong ones."""
    rng, known = np.random.default_rng(seed), walls_around(NICHED)
    spread = np.diag([0.25, 0.25, np.deg2rad(15.0) ** 2])
    start = GaussianPose(rng.multivariate_normal(HERE, 0.5 * spread), spread)
    assert squared_error(one_step(HERE, start, known, seed).belief, HERE) < 16.0


def test_wheels_that_slipped_are_noticed_and_the_pose_goes_on(rng: np.random.Generator) -> None:
    known, sure = walls_around(NICHED), np.diag([1e-4, 1e-4, 1e-5])
    slipped = GaussianPose(HERE + np.array([0.1, -0.12, 0.15]), sure)
    seen = seen_from(HERE, known, rng)
    believed = track(slipped, STANDING, seen, known, ALONE)
    assert believed.pairs.matched_share(seen) < 0.5
    doubted = track(slipped, STANDING, seen, known, PARAMS)
    assert doubted.pairs.matched_share(seen) > 0.8
    assert np.abs(off(doubted.belief.mean, HERE)).max() < 0.06


def test_a_collision_is_more_than_a_slip(rng: np.random.Generator) -> None:
    """0.5 m and 20 degrees off: hardly a wall is matched, and the filter does not find back."""
    known, sure = walls_around(NICHED), np.diag([1e-4, 1e-4, 1e-5])
    carried = GaussianPose(HERE + np.array([0.4, -0.3, 0.35]), sure)
    step = track(carried, STANDING, seen_from(HERE, known, rng), known, ALONE)
    assert len(step.pairs) <= 1
    assert abs(off(step.belief.mean, HERE)[2]) > 0.2


def test_a_corner_is_a_point_where_its_walls_are_not_both_matched() -> None:
    """In a corridor that ends: too little is seen of the end to be a line of its own."""
    corner = lines_between([[[0.0, 0.0], [8.0, 0.0]], [[8.0, 0.0], [8.0, 2.4]]], MAPPED)
    known, pose = Walls.of(corner), np.array([5.0, 1.2, 0.0])
    belief = GaussianPose(pose + np.array([0.2, 0.0, 0.0]), np.diag([0.09, 0.01, 0.001]))
    vague = lines_between([[[3.0, 0.0], [8.0, 0.0]], [[8.0, 0.0], [8.0, 0.5]]], SEEN)
    seen = Walls.of(vague.moved(se2.inverse(pose)))
    only_wall = Pairs(np.array([[0, 0]]))
    with_corner = replace(only_wall, corners=np.array([[0, 0]]), is_new=np.array([True]))
    less, _ = corrected(belief.mean, belief.covariance, (seen, known), only_wall)
    more, covariance = corrected(belief.mean, belief.covariance, (seen, known), with_corner)
    assert less[0] == pytest.approx(5.2, abs=0.01)
    assert more[0] == pytest.approx(5.0, abs=0.01)
    assert np.sqrt(covariance[0, 0]) < 0.05


def test_a_corner_whose_walls_are_matched_is_counted_but_says_nothing_new() -> None:
    known = walls_around(ROOM)
    step = one_step(HERE, GaussianPose(HERE, NEAR), known)
    assert len(step.pairs.corners) >= 2
    assert not step.pairs.is_new.any()
    without = Pairs(step.pairs.lines)
    seen = seen_from(HERE, known, np.random.default_rng(0))
    mean, _ = corrected(step.predicted.mean, step.predicted.covariance, (seen, step.near), without)
    assert mean == pytest.approx(step.belief.mean)


def test_a_corner_is_matched_only_with_one_that_opens_the_same_way() -> None:
    known, belief = walls_around(ROOM).corners, GaussianPose(np.zeros(3), NEAR)
    seen = replace(known, poses=known.poses.copy())
    assert match_corners(belief, seen, known, PARAMS).tolist() == [[k, k] for k in range(4)]
    seen.poses[0, 2] = wrap(float(seen.poses[0, 2]) + np.pi / 2.0)
    assert match_corners(belief, seen, known, PARAMS).tolist() == [[k, k] for k in range(1, 4)]
    juts = replace(known, convex=~known.convex)
    assert len(match_corners(belief, juts, known, PARAMS)) == 0


def test_without_walls_there_is_nothing_to_correct() -> None:
    nothing, belief = Walls.of(Lines.none()), GaussianPose(HERE, NEAR)
    for seen, known in ((nothing, walls_around(ROOM)), (walls_around(ROOM), nothing)):
        step = track(belief, STANDING, seen, known, PARAMS)
        assert len(step.pairs) == 0
        assert step.belief.mean == pytest.approx(HERE)
    assert Pairs().matched_share(nothing) == 1.0
    assert Pairs().matched_share(walls_around(ROOM)) == 0.0


def test_a_sight_that_is_hardly_new_counts_little(rng: np.random.Generator) -> None:
    known, belief = walls_around(ROOM), GaussianPose(HERE, NEAR)
    seen = seen_from(HERE, known, rng)
    full = track(belief, STANDING, seen, known, PARAMS)
    old = track(belief, STANDING, seen.as_new_as(0.05), known, PARAMS)
    assert information(full) == pytest.approx(20.0 * information(old), rel=1e-3, abs=1.0)


def test_walls_far_off_or_seen_from_behind_are_left_out() -> None:
    known = walls_around(((0.0, 0.0), (30.0, 0.0), (30.0, 5.0), (0.0, 5.0)))
    near = known.near(np.array([3.0, 2.0, 0.0]), 12.0)
    assert len(near.lines) == 3
    assert len(near.corners) == 2
    assert len(known.near(np.array([3.0, 8.0, 0.0]), 12.0).lines) == 2


def drive(corners: tuple[tuple[float, float], ...], seed: int, cycles: int = 40) -> list[float]:
    """NEES along a curved way, with a map, odometry and lines as wrong as they claim to be."""
    rng = np.random.default_rng(seed)
    truth_walls = walls_around(corners)
    known = Walls.of(erring(truth_walls.lines, MAPPED, rng))
    truth, told = HERE, []
    belief = GaussianPose(rng.multivariate_normal(truth, NEAR), NEAR)
    increment = np.array([0.2, 0.0, 0.12])
    along, around = PARAMS.motion.variances(0.2, 0.12)
    for _ in range(cycles):
        noise = rng.normal(size=3) * np.sqrt([along, along, around])
        truth = se2.compose(truth, increment + noise)
        seen = seen_from(truth, truth_walls, rng)
        belief = track(belief, increment, seen, known, PARAMS).belief
        told.append(squared_error(belief, truth))
    return told


@pytest.mark.parametrize("corners", [ROOM, NICHED], ids=["room", "niched"])
def test_errors_are_as_large_as_the_covariance_says(
    corners: tuple[tuple[float, float], ...],
) -> None:
    """NEES over 15 tracks: 3 were it all independent; a map is wrong the same way all along."""
    told = np.array([drive(corners, seed) for seed in range(15)])
    assert 2.0 < told.mean() < 4.5
    assert np.mean(told < 11.34) > 0.93  # chi-squared of three degrees, 99 %
    assert told[:, -10:].mean() < 5.0, "it does not drift away"
