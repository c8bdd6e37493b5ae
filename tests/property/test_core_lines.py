"""Laws of lines: their group, their twin, and that their covariances are right."""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from naive import lines as naive
from pilotage.bench.reference_lines import plain_lines
from pilotage.core import se2
from pilotage.core.angles import difference, wrap
from pilotage.core.corners import find_corners
from pilotage.core.line_extraction import LineParams, extract_lines
from pilotage.core.line_fit import BeamNoise, fit_line
from pilotage.core.lines import Lines
from pilotage.core.near_points import near_pairs
from pilotage.core.wall_contours import sides_to_free_space, trace_contours
from wall_scans import AHEAD, FULL_TURN, Wall, room, scan_of, seen_from

SEEDS = st.integers(0, 2**32 - 1)
LENGTHS = st.floats(-20.0, 20.0) | st.sampled_from([0.0, 1e-9])
ANGLES = st.floats(-7.0, 7.0) | st.sampled_from([0.0, np.pi, -np.pi, 1e-9])
POSES = st.tuples(LENGTHS, LENGTHS, ANGLES).map(np.array)
SIZES = st.floats(2.0, 8.0)
SHARES = st.floats(0.1, 0.9)
TRUE_NOISE = BeamNoise(0.01, 0.001, 0.003)
TRIALS = 400
SIX_SIGMA = 6.0


def random_lines(seed: int, count: int = 6) -> Lines:
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-8.0, 8.0, (count, 2, 2))
    along = ends[:, 1] - ends[:, 0]
    alpha = wrap(np.arctan2(along[:, 1], along[:, 0]) + np.pi / 2.0)
    normals = np.column_stack([np.cos(alpha), np.sin(alpha)])
    rho = np.sum(normals * ends[:, 0], axis=1)
    roots = rng.normal(0.0, 0.01, (count, 2, 2))
    return Lines(ends, np.column_stack([alpha, rho]), roots @ roots.transpose(0, 2, 1))


def assert_same(one: Lines, two: Lines, tolerance: float = 1e-6) -> None:
    assert len(one) == len(two)
    turned = difference(one.polar[:, 0], two.polar[:, 0])
    assert np.abs(turned).max(initial=0.0) < tolerance
    assert one.polar[:, 1] == pytest.approx(two.polar[:, 1], abs=tolerance)
    assert one.ends == pytest.approx(two.ends, abs=tolerance)
    assert one.covariances == pytest.approx(two.covariances, abs=tolerance)


@given(SEEDS, POSES, POSES)
def test_lines_moved_twice_are_lines_moved_by_the_composition(
    seed: int, outer: np.ndarray, inner: np.ndarray
) -> None:
    lines = random_lines(seed)
    assert_same(lines.moved(inner).moved(outer), lines.moved(se2.compose(outer, inner)))


@given(SEEDS, POSES)
def test_lines_moved_there_and_back_are_the_same(seed: int, pose: np.ndarray) -> None:
    lines = random_lines(seed)
    assert_same(lines.moved(pose).moved(se2.inverse(pose)), lines)


@given(SEEDS)
def test_lines_that_are_not_moved_stay(seed: int) -> None:
    lines = random_lines(seed)
    assert_same(lines.moved(np.zeros(3)), lines)


@given(SEEDS, POSES)
def test_moving_keeps_how_well_lines_are_known_across_a_point(seed: int, pose: np.ndarray) -> None:
    """A line's variance across each of its ends does not depend on the frame."""

    def across(lines: Lines) -> np.ndarray:
        alpha = lines.polar[:, 0]
        left = np.column_stack([-np.sin(alpha), np.cos(alpha)])
        places = np.einsum("nei,ni->ne", lines.ends, left)
        jacobian = np.stack([-places, np.ones_like(places)], axis=2)
        variances: np.ndarray = np.einsum("nei,nij,nej->ne", jacobian, lines.covariances, jacobian)
        return variances

    lines = random_lines(seed)
    assert across(lines.moved(pose)) == pytest.approx(across(lines), rel=1e-6, abs=1e-9)


def furnished_scan(seed: int) -> tuple[np.ndarray, tuple[float, float]]:
    """Return a noisy scan of a room with people, stray beams and lost ones, or pure noise."""
    rng = np.random.default_rng(seed)
    width, height = rng.uniform(2.0, 8.0, 2)
    pose = [*(rng.uniform(0.1, 0.9, 2) * [width, height]), rng.uniform(-4.0, 4.0)]
    angles = FULL_TURN if rng.random() < 0.5 else AHEAD
    people = [(*rng.uniform(-3.0, 3.0, 2), rng.choice([0.06, 0.2])) for _ in range(3)]
    ranges = scan_of(seen_from(pose, room(width, height)), angles, people)
    ranges = ranges + 0.01 * rng.standard_normal(len(ranges))
    stray = rng.random(len(ranges)) < 0.03
    ranges[stray] *= rng.random(stray.sum())
    ranges[rng.random(len(ranges)) < 0.03] = rng.choice([np.inf, np.nan])
    if rng.random() < 0.2:
        ranges = rng.uniform(0.2, 8.0, len(ranges))
    if rng.random() < 0.3:
        return ranges[::-1].copy(), (-angles[0], -angles[1])
    return ranges, angles


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_kernel_finds_the_lines_that_its_twin_finds(seed: int) -> None:
    ranges, angles = furnished_scan(seed)
    assert_same(extract_lines(ranges, angles), plain_lines(ranges, angles, LineParams()))


@settings(max_examples=30, deadline=None)
@given(SEEDS)
def test_fitted_line_is_the_likeliest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    alpha, distance = rng.uniform(-np.pi, np.pi), rng.uniform(0.5, 5.0)
    bearings = alpha + np.sort(rng.uniform(-1.0, 0.8, 15))
    ranges = distance / np.cos(bearings - alpha) + 0.01 * rng.standard_normal(15)
    fit = fit_line(np.column_stack([np.cos(bearings), np.sin(bearings), ranges]), TRUE_NOISE)
    beams = np.column_stack([bearings, ranges])
    best = naive.likeliest(beams, (alpha, distance), TRUE_NOISE)
    # The search also lets the variances change with the line, by which it gains a little.
    sigmas = np.sqrt([fit.var_alpha, fit.var_distance])
    assert abs(difference(fit.alpha, best[0])) < 0.1 * sigmas[0]
    assert abs(fit.distance - best[1]) < 0.1 * sigmas[1]


def normalised_errors(seed: int, noise: BeamNoise) -> np.ndarray:
    """Return the squared errors (n,) in covariances of walls of many sizes, each seen once."""
    rng = np.random.default_rng(seed)
    errors = []
    for _ in range(TRIALS):
        alpha, distance = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, 8.0)
        length = rng.uniform(1.0, 6.0)
        start = rng.uniform(-5.0, 5.0) - length / 2.0
        lines = extract_lines(
            _noisy_wall(rng, (alpha, distance, start, length), noise),
            FULL_TURN,
            LineParams(noise=noise),
        )
        if len(lines):
            longest = int(np.argmax(lines.lengths))
            off = lines.polar[longest] - [alpha + np.pi, -distance]
            off[0] = wrap(float(off[0]))
            errors.append(off @ np.linalg.solve(lines.covariances[longest], off))
    return np.array(errors)


def _noisy_wall(
    rng: np.random.Generator, wall: tuple[float, float, float, float], noise: BeamNoise
) -> np.ndarray:
    """Return what a laser that errs, and whose bearings err, measures of a wall."""
    alpha, distance, start, length = wall
    bearings = FULL_TURN[0] + FULL_TURN[1] * np.arange(720)
    turns = bearings + noise.bearing_sigma * rng.standard_normal(720) - alpha
    cos = np.maximum(np.cos(turns), 1e-3)
    bumpy = distance + noise.wall_sigma * rng.standard_normal(720)
    place = distance * np.sin(turns) / cos
    met = (np.cos(turns) > 0.01) & (place > start) & (place < start + length)
    ranges = bumpy / cos + noise.range_sigma * rng.standard_normal(720)
    return np.where(met, ranges, np.inf)


@pytest.mark.parametrize(
    "noise", [BeamNoise(0.01, 0.0, 0.0), TRUE_NOISE, BeamNoise(0.03, 0.003, 0.01)]
)
def test_covariances_are_right(noise: BeamNoise) -> None:
    """Errors in covariances follow chi-square with two degrees of freedom.

    Its mean is 2 and its variance 4, so a mean of n of them errs by 2 / sqrt(n); and one in
    twenty lies above 5.99.
    """
    errors = normalised_errors(11, noise)
    count = len(errors)
    assert count > 0.95 * TRIALS
    assert errors.mean() == pytest.approx(2.0, abs=3.5 * 2.0 / np.sqrt(count))
    share = np.mean(errors > 5.991)
    assert share == pytest.approx(0.05, abs=3.5 * np.sqrt(0.05 * 0.95 / count))


@settings(max_examples=40, deadline=None)
@given(SIZES, SIZES, SHARES, SHARES, ANGLES)
def test_room_gives_its_four_walls_wherever_the_laser_stands(
    width: float, height: float, x: float, y: float, theta: float
) -> None:
    pose = np.array([x * width, y * height, theta])
    lines = extract_lines(scan_of(seen_from(pose, room(width, height))), FULL_TURN).moved(pose)
    assert len(lines) == 4
    order = np.argsort(np.round(lines.polar[:, 0] * 2.0 / np.pi) % 4)
    # A beam that ends next to a corner may go with the other wall, being within its noise.
    assert np.abs(lines.polar[order, 1] - [0.0, 0.0, -width, -height]).max() < 0.01


@settings(max_examples=30, deadline=None)
@given(SEEDS, st.integers(-300, 300))
def test_turning_the_laser_by_whole_beams_turns_the_lines(seed: int, beams: int) -> None:
    """A scan of a full turn has no beginning."""
    rng = np.random.default_rng(seed)
    walls = seen_from([2.0, 1.5, rng.uniform(-3.0, 3.0)], room(5.0, 4.0))
    ranges = scan_of(walls) + 0.01 * rng.standard_normal(720)
    lines = extract_lines(ranges, FULL_TURN)
    turned = extract_lines(np.roll(ranges, beams), FULL_TURN).moved([0, 0, -beams * FULL_TURN[1]])
    assert len(turned) == len(lines)
    for alpha, rho in lines.polar:
        off = np.abs(difference(turned.polar[:, 0], np.full(len(turned), alpha)))
        k = int(np.argmin(off))
        # A beam at a corner may go with the other wall.
        assert off[k] < 0.01
        assert abs(turned.polar[k, 1] - rho) < 0.02


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_mirrored_scan_has_mirrored_lines(seed: int) -> None:
    rng = np.random.default_rng(seed)
    walls: list[Wall] = [((1.0, -2.0), (3.0, 1.0)), ((0.5, 2.5), (4.0, 2.0))]
    ranges = scan_of(walls, AHEAD) + 0.005 * rng.standard_normal(361)
    lines = extract_lines(ranges, AHEAD)
    mirrored = extract_lines(ranges[::-1], AHEAD)
    assert len(lines) == len(mirrored)
    back = mirrored.ends[::-1, ::-1] * [1.0, -1.0]
    assert back == pytest.approx(lines.ends, abs=0.05)
    assert -mirrored.polar[::-1, 0] == pytest.approx(lines.polar[:, 0], abs=0.01)


@given(SEEDS, POSES)
def test_corners_move_with_their_lines(seed: int, pose: np.ndarray) -> None:
    ends = np.array(room(*np.random.default_rng(seed).uniform(1.0, 9.0, 2)))
    along = ends[:, 1] - ends[:, 0]
    alpha = wrap(np.arctan2(along[:, 1], along[:, 0]) + np.pi / 2.0)
    rho = np.sum(np.column_stack([np.cos(alpha), np.sin(alpha)]) * ends[:, 0], axis=1)
    covariances = np.tile(np.diag([1e-4, 4e-4]), (4, 1, 1))
    lines = Lines(ends, np.column_stack([alpha, rho]), covariances)
    here, there = find_corners(lines), find_corners(lines.moved(pose))
    assert len(here) == len(there) == 4
    expected = se2.compose(pose, here.poses)
    assert there.poses[:, :2] == pytest.approx(expected[:, :2], abs=1e-6)
    assert np.abs(difference(there.poses[:, 2], expected[:, 2])).max() < 1e-6
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    rotation = np.array([[cos, -sin], [sin, cos]])
    turned = rotation @ here.covariances @ rotation.T
    assert there.covariances == pytest.approx(turned, abs=1e-6)


KINDS = arrays(np.int8, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(0, 2))


@given(KINDS)
def test_contours_walk_every_side_that_free_space_touches_once(kinds: np.ndarray) -> None:
    is_wall, is_free = kinds == 0, kinds == 1
    corners, begins = trace_contours(sides_to_free_space(is_wall, is_free))
    walked = [
        (tuple(corners[k].tolist()), tuple(corners[k + 1].tolist()))
        for first, last in itertools.pairwise(begins)
        for k in range(first, last - 1)
    ]
    assert len(walked) == len(set(walked))
    assert set(walked) == naive.sides(is_wall, is_free)


@given(SEEDS, st.floats(0.01, 3.0))
def test_near_points_are_those_that_a_table_of_all_pairs_says(seed: int, apart: float) -> None:
    rng = np.random.default_rng(seed)
    ones, others = rng.uniform(-3, 3, (rng.integers(0, 20), 2)), rng.uniform(-3, 3, (15, 2))
    assume(len(ones))
    pairs = near_pairs(ones, others, apart)
    assert len(pairs) == len({tuple(pair) for pair in pairs.tolist()})
    assert {(i, j) for i, j in pairs.tolist()} == naive.near_pairs(ones, others, apart)
