"""Evidence of whole scans: what it says of right and wrong poses, wherever the map lies."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from drawing import draw
from localizer_world import BEARINGS, ELSEWHERE, RANGE_MAX, START, error, flat, scan_at
from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.localizer.evidence import EVIDENCE_BEAMS, chosen_beams, ends_in_base, weigh
from pilotage.localizer.evidence_kernels import first_obstacle
from pilotage.localizer.measurement import Beams
from pilotage.localizer.obstacles import MARGIN, Obstacles, enclosed, obstacles
from pilotage.localizer.precision import fitted_covariance

Array = NDArray[np.float64]
seeds = st.integers(0, 2**32 - 1)
turns = st.floats(-math.pi, math.pi)

WORLD = flat()
AROUND = obstacles(WORLD)
WIDE = np.diag([0.25, 0.25, 0.05])


def beams_of(ranges: Array, mount: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Beams:
    return Beams(BEARINGS, ranges, np.array(mount, np.float64), RANGE_MAX)


def seen_from(pose: Array, mount: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Beams:
    """A perfect scan of the flat."""
    return beams_of(scan_at(WORLD, se2.compose(pose, mount)).astype(float), mount)


def all_new(beams: Beams) -> Array:
    return np.ones(len(chosen_beams(beams).ranges))


def free_pose(seed: int) -> Array:
    """A pose of the flat with half a metre of room about it."""
    rng = np.random.default_rng(seed)
    roomy = np.argwhere(AROUND.distance >= 5.0)
    (place,) = AROUND.geometry.centres_of(roomy[rng.integers(len(roomy))][None])
    return np.array([*(place + rng.uniform(-0.05, 0.05, 2)), rng.uniform(-math.pi, math.pi)])


# What stops a beam


def test_free_space_that_meets_the_unknown_is_walled_off_there() -> None:
    world = draw("""
        ??????
        ?....?
        ?..#.?
        ??????
        """)
    assert (
        enclosed(world).cells.tolist()
        == draw("""
        ######
        #....#
        #..#.#
        ######
        """).cells.tolist()
    )


def test_distances_are_in_cells_and_negative_behind_walls() -> None:
    """A wall at the edge of the map has two sides: distances go on beyond it."""
    told = obstacles(
        draw(
            """
            ????#####
            ????#...#
            ????#...#
            ????#...#
            ????#####
            """,
            resolution=0.05,
        )
    ).distance
    beyond, inside = [-1.0, -2.0, -3.0], [-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 1.0, 0.0]
    assert len(beyond) == MARGIN
    assert told[MARGIN + 2].tolist() == [-7.0, -6.0, -5.0, *inside, *beyond]
    assert told[:, MARGIN + 6].tolist() == [*beyond[::-1], 0.0, 1.0, 2.0, 1.0, 0.0, *beyond]


def test_a_map_whose_free_space_runs_to_its_edge_is_walled_off_beyond_it() -> None:
    told = obstacles(draw("....\n....\n....")).distance
    assert told[MARGIN + 1].tolist() == [-2.0, -1.0, 0.0, 1.0, 2.0, 2.0, 1.0, 0.0, -1.0, -2.0]


def test_where_the_map_shows_nothing_everything_is_far_and_finite() -> None:
    told = obstacles(draw("????")).distance
    assert np.isfinite(told).all()
    assert (np.abs(told) > 1e3).all()


@given(turns, st.floats(-30.0, 30.0), st.floats(-30.0, 30.0))
def test_the_margin_leaves_the_map_where_it_is(theta: float, x: float, y: float) -> None:
    world = flat((x, y, theta))
    around = obstacles(world)
    assert around.distance.shape == tuple(side + 2 * MARGIN for side in world.cells.shape)
    corner = around.in_cells(world.geometry.origin)
    assert corner == pytest.approx([MARGIN, MARGIN, 0.0], abs=1e-9)
    inside = around.distance[MARGIN:-MARGIN, MARGIN:-MARGIN]
    assert ((inside > 0.0) == world.is_free).all()


@given(turns, st.floats(-30.0, 30.0), st.floats(-30.0, 30.0), seeds)
def test_poses_go_to_cells_and_back(theta: float, x: float, y: float, seed: int) -> None:
    around = Obstacles(replace(AROUND.geometry, origin=(x, y, theta)), AROUND.distance)
    pose = np.random.default_rng(seed).uniform(-3.0, 3.0, (4, 3))
    assert around.in_map(around.in_cells(pose)) == pytest.approx(pose, abs=1e-9)


@given(seeds)
def test_rays_meet_the_wall_where_an_exact_ray_does(seed: int) -> None:
    """A little earlier, for a wall is met 0.4 cells before the middle of its cells."""
    pose = free_pose(seed)
    cells = AROUND.in_cells(pose)
    exact = cast_scan(WORLD, pose, BEARINGS, RANGE_MAX) / WORLD.geometry.resolution
    rays = [cells + np.array([0.0, 0.0, turn]) for turn in BEARINGS]
    met = np.array([first_obstacle(AROUND.distance, ray, 120.0) for ray in rays])
    off = met - exact
    assert np.median(np.abs(off)) < 0.6
    # A ray that grazes a corner may meet it, and one between two cells may not.
    assert np.mean(np.abs(off) < 2.0) > 0.9


# Where a scan fits


@given(seeds, st.floats(0.0, 0.2), turns, st.floats(-0.08, 0.08))
def test_a_perfect_scan_takes_a_pose_beside_the_truth_back_to_it(
    seed: int, away: float, direction: float, turn: float
) -> None:
    truth = free_pose(seed)
    beams = seen_from(truth)
    offset = np.array([away * math.cos(direction), away * math.sin(direction), turn])
    guess = truth + offset
    at_truth, back = weigh(np.array([truth, guess]), beams, all_new(beams), AROUND).poses
    # Exact beams end on the faces of cells, a scan fits best on their middles: half a cell.
    assert error(at_truth, truth)[0] < 0.5 * WORLD.geometry.resolution
    assert error(back, at_truth)[0] < 0.01
    assert error(back, at_truth)[1] < 0.01


@pytest.mark.parametrize("mount", [(0.0, 0.0, 0.0), (0.2, -0.1, 0.5)], ids=["centre", "mounted"])
def test_the_truth_is_supported_by_all_beams(mount: tuple[float, float, float]) -> None:
    beams = seen_from(np.array(START), mount)
    word = weigh(np.array([START]), beams, all_new(beams), AROUND)
    assert word.met[0] > 0.95
    assert word.through[0] == 0.0
    assert word.fit[0] > 0.3
    assert word.evidence[0] == pytest.approx(word.fit[0] * len(all_new(beams)))
    assert error(word.poses[0], START)[0] < 0.01


@settings(max_examples=25)
@given(seeds, seeds)
def test_no_wrong_pose_is_supported_like_the_truth(one: int, other: int) -> None:
    truth, wrong = free_pose(one), free_pose(other)
    if error(truth, wrong)[0] > 1.0 or error(truth, wrong)[1] > 0.5:
        beams = seen_from(truth)
        word = weigh(np.array([truth, wrong]), beams, all_new(beams), AROUND)
        assert word.evidence[0] > word.evidence[1] + 10.0


@given(seeds, turns, st.floats(-50.0, 50.0), st.floats(-50.0, 50.0))
def test_evidence_is_the_same_wherever_the_map_lies(
    seed: int, theta: float, x: float, y: float
) -> None:
    """The map moved and turned as a whole, and the poses with it."""
    motion = np.array([x, y, theta])
    elsewhere = obstacles(OccupancyMap(flat((x, y, theta)).geometry, WORLD.cells))
    truth = free_pose(seed)
    beams = seen_from(truth, (0.1, 0.0, 0.2))
    poses = np.array([truth, [*(truth[:2] + 0.1), truth[2] + 0.05], ELSEWHERE])
    here = weigh(poses, beams, all_new(beams), AROUND)
    there = weigh(se2.compose(motion, poses), beams, all_new(beams), elsewhere)
    assert there.evidence == pytest.approx(here.evidence, abs=1e-6)
    assert there.fit == pytest.approx(here.fit, abs=1e-6)
    expected = se2.compose(motion, here.poses)
    for told, pose in zip(there.poses, expected, strict=True):
        assert error(told, pose) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_a_pose_off_the_map_or_in_a_wall_is_nowhere() -> None:
    beams = seen_from(np.array(START))
    nowhere = np.array([[-5.0, 2.0, 0.0], [500.0, 2.0, 0.0], [0.05, 0.05, 0.0]])
    word = weigh(nowhere, beams, all_new(beams), AROUND)
    assert (word.evidence < -500.0).all()
    assert (word.fit < 0.0).all()
    assert (word.met == 0.0).all()


def test_a_place_is_left_only_for_its_neighbourhood() -> None:
    """What a scan would pull farther than its reach stays where it was proposed."""
    rng = np.random.default_rng(3)
    poses = np.array([free_pose(seed) for seed in range(60)])
    beams = beams_of(rng.uniform(0.3, 6.0, 90))
    refined = weigh(poses, beams, all_new(beams), AROUND).poses
    for pose, told in zip(poses, refined, strict=True):
        away, turn = error(told, pose)
        assert away <= 0.35 + 1e-9
        assert turn <= 0.2 + 1e-9


# What single beams say

HALL = draw(
    """
    ##############################
    #..............#.............#
    #..............#.............#
    #..............#.............#
    #..............#.............#
    #..............#.............#
    #..............#.............#
    ##############################
    """,
    resolution=0.5,
)
"""Two rooms of 7 m with a wall between them."""

MIDDLE = np.array([3.75, 2.0, 0.0])


def one_beam(length: float, at: Array = MIDDLE) -> tuple[float, float, float]:
    """Evidence, met and through of one beam straight at the wall between the rooms."""
    beams = Beams(np.zeros(1), np.array([length]), np.zeros(3), RANGE_MAX)
    word = weigh(at[None], beams, np.ones(1), obstacles(HALL))
    return float(word.evidence[0]), float(word.met[0]), float(word.through[0])


def test_a_beam_through_a_wall_weighs_less_than_one_that_meets_it_or_falls_short() -> None:
    meets, met, _ = one_beam(4.0)
    through, _, gone = one_beam(7.0)
    short, _, fell = one_beam(2.0)
    assert through < short <= meets
    assert (met, gone, fell) == (1.0, 1.0, 0.0)


def test_even_a_beam_that_ends_at_a_wall_speaks_against_a_pose_if_it_went_through_another() -> None:
    """What a likelihood field cannot see (methods E)."""
    at_the_far_wall = 10.95
    assert one_beam(at_the_far_wall)[0] <= -1.0
    assert one_beam(at_the_far_wall)[2] == 1.0


@pytest.mark.parametrize(("short", "weight"), [(0.4, 0.5), (0.8, 0.2)])
@pytest.mark.parametrize("cell", [0.1, 0.2, 0.4])
def test_what_is_exact_is_told_by_the_cells_of_a_coarse_map(
    cell: float, short: float, weight: float
) -> None:
    """Beams to all four sides that end so many cells short of the middle of a wall's cell."""
    world = OccupancyMap(replace(HALL.geometry, resolution=cell), HALL.cells)
    middle = np.array([8.0 * cell, 4.0 * cell, 0.0])
    lengths = (np.array([7.5, 3.5, 7.5, 3.5]) - short) * cell
    beams = Beams(np.array([0.0, 0.5, 1.0, 1.5]) * math.pi, lengths, np.zeros(3), RANGE_MAX)
    word = weigh(middle[None], beams, np.ones(4), obstacles(world))
    assert word.fit[0] == pytest.approx(weight)


def test_silence_is_right_where_nothing_is_in_reach_and_wrong_where_something_is() -> None:
    def silent(range_max: float) -> float:
        beams = Beams(np.zeros(1), np.array([np.inf]), np.zeros(3), range_max)
        return float(weigh(MIDDLE[None], beams, np.ones(1), obstacles(HALL)).evidence[0])

    assert silent(2.0) > 0.0
    assert silent(10.0) < -1.0


def test_old_news_counts_for_less_and_the_fit_for_all() -> None:
    beams = seen_from(np.array(START))
    full = weigh(np.array([START]), beams, all_new(beams), AROUND)
    half = weigh(np.array([START]), beams, 0.5 * all_new(beams), AROUND)
    assert half.evidence == pytest.approx(0.5 * full.evidence)
    assert half.fit == pytest.approx(full.fit)


def test_no_poses_are_weighed_as_none() -> None:
    beams = seen_from(np.array(START))
    assert len(weigh(np.empty((0, 3)), beams, all_new(beams), AROUND).evidence) == 0


def test_of_many_beams_some_are_chosen_evenly_silent_ones_too() -> None:
    ranges = np.where(np.arange(1000) % 2 == 0, 3.0, np.inf)
    beams = Beams(np.linspace(-2.0, 2.0, 1000), ranges, np.zeros(3), RANGE_MAX)
    chosen = chosen_beams(beams)
    assert len(chosen.ranges) == EVIDENCE_BEAMS
    assert chosen.bearings[[0, -1]] == pytest.approx([-2.0, 2.0])
    assert np.ptp(np.diff(chosen.bearings)) < 0.01
    assert 0.3 < np.mean(np.isinf(chosen.ranges)) < 0.7
    assert len(ends_in_base(beams)) == 500


def test_furniture_that_the_map_lacks_does_not_move_the_pose() -> None:
    ranges = scan_at(WORLD, START).astype(float)
    ranges[10:35] *= 0.6
    beams, whole = beams_of(ranges), seen_from(np.array(START))
    (bare,) = weigh(np.array([START]), whole, all_new(whole), AROUND).poses
    word = weigh(np.array([START]) + np.array([0.05, -0.05, 0.03]), beams, all_new(beams), AROUND)
    away, turn = error(word.poses[0], bare)
    assert away < 0.04
    assert turn < 0.02
    assert word.through[0] == 0.0


# How exactly


@given(seeds)
def test_a_fitted_covariance_is_symmetric_positive_and_narrower_than_the_belief(seed: int) -> None:
    pose = free_pose(seed)
    covariance = fitted_covariance(pose, ends_in_base(seen_from(pose)), AROUND, WIDE)
    assert (covariance == covariance.T).all()
    assert (np.linalg.eigvalsh(covariance) > 0.0).all()
    assert (np.linalg.eigvalsh(WIDE - covariance) > -1e-9).all()


LONG = draw("#" * 60 + "\n" + ("." * 60 + "\n") * 9 + "#" * 60, resolution=0.2)
"""A corridor without ends, 1.8 m wide."""


@pytest.mark.parametrize("turn", [0.0, 0.7, math.pi / 2.0], ids=["plain", "turned", "upright"])
def test_along_a_corridor_a_pose_is_as_wide_as_the_belief_and_across_it_is_not(
    turn: float,
) -> None:
    origin = (3.0, -1.0, turn)
    around = obstacles(OccupancyMap(replace(LONG.geometry, origin=origin), LONG.cells))
    here = np.array([6.0, 1.1, 0.3])
    bearings = np.linspace(-math.pi, math.pi, 90, endpoint=False)
    ranges = cast_scan(LONG, here, bearings, 2.5)
    ends = ends_in_base(Beams(bearings, ranges, np.zeros(3), 2.5))
    pose = se2.compose(origin, here)
    covariance = fitted_covariance(pose, ends, around, WIDE)
    lengthwise = np.array([math.cos(turn), math.sin(turn), 0.0])
    across = np.array([-math.sin(turn), math.cos(turn), 0.0])
    assert lengthwise @ covariance @ lengthwise > 0.8 * WIDE[0, 0]
    assert across @ covariance @ across < 0.05**2


def test_a_scan_without_ends_leaves_the_belief_as_it_is() -> None:
    covariance = fitted_covariance(np.array(START), np.empty((0, 2)), AROUND, WIDE)
    assert covariance == pytest.approx(WIDE)
