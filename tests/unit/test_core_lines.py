"""Walls found in scans, and what lines are."""

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.line_extraction import LineParams, extract_lines
from pilotage.core.line_fit import BeamNoise
from pilotage.core.lines import Lines
from wall_scans import AHEAD, FULL_TURN, Wall, room, scan_of, seen_from

CORRIDOR: list[Wall] = [((-2.0, -1.0), (8.0, -1.0)), ((-2.0, 1.0), (8.0, 1.0))]
WALL_AHEAD: list[Wall] = [((3.0, -2.0), (3.0, 2.0))]
HALF_TURN = np.pi
ROUGH = BeamNoise(0.01, 0.0005, 0.0)


def noisy(ranges: np.ndarray, sigma: float = 0.01, seed: int = 0) -> np.ndarray:
    return ranges + sigma * np.random.default_rng(seed).standard_normal(len(ranges))


def test_rectangular_room_has_four_walls_with_their_normals_inward() -> None:
    walls = seen_from([2.0, 1.5, 0.0], room(5.0, 4.0))
    lines = extract_lines(scan_of(walls), FULL_TURN)
    found = {(round(a / HALF_TURN * 2.0) % 4, round(r, 3)) for a, r in lines.polar}
    assert found == {(0, -2.0), (2, -3.0), (1, -1.5), (3, -2.5)}
    assert len(lines) == 4


def test_ends_reach_the_corners_to_within_a_beam() -> None:
    walls = seen_from([2.0, 1.5, 0.0], room(5.0, 4.0))
    lines = extract_lines(scan_of(walls), FULL_TURN)
    apart = np.linalg.norm(lines.ends.reshape(-1, 1, 2) - walls.reshape(1, -1, 2), axis=2)
    assert apart.min(axis=1).max() < 0.06


def test_free_space_lies_left_of_the_way_from_end_to_end() -> None:
    lines = extract_lines(noisy(scan_of(seen_from([2, 1.5, 0.4], room(5, 4)))), FULL_TURN)
    along = lines.ends[:, 1] - lines.ends[:, 0]
    to_laser = -lines.ends[:, 0]
    assert (along[:, 0] * to_laser[:, 1] - along[:, 1] * to_laser[:, 0] > 0.0).all()
    assert (lines.polar[:, 1] < 0.0).all()


def test_ends_lie_on_their_lines() -> None:
    lines = extract_lines(noisy(scan_of(seen_from([2, 1.5, 0.4], room(5, 4)))), FULL_TURN)
    normals = np.column_stack([np.cos(lines.polar[:, 0]), np.sin(lines.polar[:, 0])])
    assert np.einsum("nei,ni->ne", lines.ends, normals) == pytest.approx(
        np.repeat(lines.polar[:, 1:], 2, axis=1)
    )


def test_laser_that_turns_the_other_way_sees_the_same_walls() -> None:
    ranges = noisy(scan_of(WALL_AHEAD, AHEAD))
    lines = extract_lines(ranges, AHEAD)
    backward = extract_lines(ranges[::-1], (-AHEAD[0], -AHEAD[1]))
    assert backward.ends == pytest.approx(lines.ends)
    assert backward.covariances == pytest.approx(lines.covariances)


def test_door_parts_a_wall_where_beams_go_through() -> None:
    with_door: list[Wall] = [
        ((2.0, -2.0), (2.0, -0.5)),
        ((2.0, 0.4), (2.0, 2.0)),
        ((5.0, -4.0), (5.0, 4.0)),
    ]
    lines = extract_lines(noisy(scan_of(with_door, AHEAD)), AHEAD)
    near = lines.chosen(lines.polar[:, 1] > -3.0)
    ends = np.sort(near.ends[:, :, 1].ravel())
    assert ends == pytest.approx([-2.0, -0.5, 0.4, 2.0], abs=0.05)


def test_door_parts_a_wall_where_nothing_comes_back() -> None:
    with_door: list[Wall] = [((2.0, -2.0), (2.0, -0.5)), ((2.0, 0.4), (2.0, 2.0))]
    assert len(extract_lines(noisy(scan_of(with_door, AHEAD)), AHEAD)) == 2


def test_person_in_front_does_not_part_a_wall() -> None:
    legs = [(1.5, 0.0, 0.06), (1.5, 0.25, 0.06)]
    lines = extract_lines(noisy(scan_of(WALL_AHEAD, AHEAD, legs)), AHEAD)
    assert len(lines) == 1
    assert lines.lengths == pytest.approx([4.0], abs=0.06)
    assert lines.polar[0, 1] == pytest.approx(-3.0, abs=0.005)


def test_what_hides_a_wall_for_long_parts_it() -> None:
    long: list[Wall] = [((3.0, -4.0), (3.0, 4.0))]
    crowd = [(1.0, y, 0.2) for y in (-0.4, 0.0, 0.4)]
    lines = extract_lines(noisy(scan_of(long, AHEAD, crowd)), AHEAD)
    assert len(lines.chosen(lines.polar[:, 1] < -2.9)) == 2


@pytest.mark.parametrize("radius", [0.06, 0.12, 0.2, 0.25])
def test_people_are_no_walls(radius: float) -> None:
    crowd = [(x, y, radius) for x, y in [(1, 0), (0.9, 0.8), (2, -1), (1.5, -2), (3, 1.5)]]
    params = LineParams(noise=ROUGH)
    assert len(extract_lines(noisy(scan_of([], AHEAD, crowd)), AHEAD, params)) == 0


def test_pillar_is_no_wall() -> None:
    params = LineParams(noise=ROUGH)
    scan = noisy(scan_of([], AHEAD, [(1.5, 0.2, 0.5)]))
    assert len(extract_lines(scan, AHEAD, params)) == 0


def test_wall_with_lost_and_stray_beams_stays_one() -> None:
    rng = np.random.default_rng(7)
    ranges = noisy(scan_of(WALL_AHEAD, AHEAD))
    stray = rng.random(len(ranges)) < 0.05
    ranges[stray] *= rng.random(stray.sum())
    ranges[rng.random(len(ranges)) < 0.05] = np.inf
    lines = extract_lines(ranges, AHEAD)
    assert len(lines) == 1
    assert lines.lengths == pytest.approx([4.0], abs=0.2)
    assert lines.polar[0, 1] == pytest.approx(-3.0, abs=0.005)


def test_corridor_seen_at_a_grazing_angle_is_two_long_walls() -> None:
    lines = extract_lines(noisy(scan_of(CORRIDOR, AHEAD)), AHEAD)
    assert len(lines) == 2
    assert lines.lengths.min() > 7.0
    assert np.abs(lines.polar[:, 1] + 1.0).max() < 0.01


def test_wall_behind_a_laser_that_looks_all_about_is_one() -> None:
    behind: list[Wall] = [((-2.0, -1.5), (-2.0, 1.5))]
    lines = extract_lines(noisy(scan_of(behind)), FULL_TURN)
    assert len(lines) == 1
    assert lines.lengths == pytest.approx([3.0], abs=0.08)


def test_wall_across_a_blind_sector_is_two() -> None:
    angles = (-0.75 * HALF_TURN, np.deg2rad(0.5))
    behind: list[Wall] = [((-1.0, -4.0), (-1.0, 4.0))]
    lines = extract_lines(noisy(scan_of(behind, angles, beams=541)), angles)
    assert len(lines) == 2
    assert lines.lengths == pytest.approx([3.0, 3.0], abs=0.2)


def test_step_in_a_wall_makes_two_lines() -> None:
    stepped: list[Wall] = [((2.0, -2.0), (2.0, 0.0)), ((2.15, 0.0), (2.15, 2.0))]
    lines = extract_lines(noisy(scan_of(stepped, AHEAD)), AHEAD)
    assert sorted(lines.polar[:, 1]) == pytest.approx([-2.15, -2.0], abs=0.01)


def test_what_is_short_is_left_out() -> None:
    box: list[Wall] = [((1.0, -0.12), (1.0, 0.12))]
    ranges = scan_of(box, AHEAD)
    assert len(extract_lines(ranges, AHEAD)) == 0
    assert len(extract_lines(ranges, AHEAD, LineParams(least_length=0.2))) == 1


@pytest.mark.parametrize("nothing", [np.nan, np.inf, -np.inf, 0.0, -1.0])
def test_no_return_is_no_beam_however_it_is_said(nothing: float) -> None:
    ranges = noisy(scan_of(WALL_AHEAD, AHEAD))
    expected = extract_lines(ranges, AHEAD)
    said = np.where(np.isfinite(ranges), ranges, nothing)
    assert extract_lines(said, AHEAD).ends == pytest.approx(expected.ends)


@pytest.mark.parametrize("ranges", [[], [1.0], [1.0, 1.0], [np.inf] * 361, [np.nan] * 5])
def test_next_to_nothing_has_no_lines(ranges: list[float]) -> None:
    lines = extract_lines(np.array(ranges), AHEAD)
    assert (lines.ends.shape, lines.polar.shape) == ((0, 2, 2), (0, 2))
    assert lines.covariances.shape == (0, 2, 2)


def test_single_precision_ranges_do() -> None:
    ranges = noisy(scan_of(WALL_AHEAD, AHEAD))
    lines = extract_lines(ranges.astype(np.float32), AHEAD)
    assert lines.polar == pytest.approx(extract_lines(ranges, AHEAD).polar, abs=1e-5)


def test_longer_wall_is_known_better() -> None:
    short: list[Wall] = [((3.0, -0.5), (3.0, 0.5))]
    one = extract_lines(scan_of(short, AHEAD), AHEAD)
    other = extract_lines(scan_of(WALL_AHEAD, AHEAD), AHEAD)
    assert other.covariances[0, 0, 0] < 0.1 * one.covariances[0, 0, 0]


def test_covariances_are_symmetric_and_positive() -> None:
    lines = extract_lines(noisy(scan_of(seen_from([2, 1.5, 0.4], room(5, 4)))), FULL_TURN)
    assert lines.covariances == pytest.approx(lines.covariances.transpose(0, 2, 1))
    assert (np.linalg.eigvalsh(lines.covariances) > 0.0).all()


def some_lines() -> Lines:
    return extract_lines(noisy(scan_of(seen_from([2, 1.5, 0.4], room(5, 4)))), FULL_TURN)


def test_lines_moved_carry_their_ends_and_their_normals_along() -> None:
    pose = np.array([1.0, -2.0, 2.5])
    lines = some_lines()
    moved = lines.moved(pose)
    points = se2.transform_points(pose, lines.ends.reshape(-1, 2)).reshape(-1, 2, 2)
    assert moved.ends == pytest.approx(points)
    normals = np.column_stack([np.cos(moved.polar[:, 0]), np.sin(moved.polar[:, 0])])
    rho = np.einsum("nei,ni->ne", points, normals)
    assert rho == pytest.approx(np.repeat(moved.polar[:, 1:], 2, axis=1))


def test_covariance_moves_as_the_lines_themselves_do() -> None:
    """Sampled lines moved one by one scatter as the moved covariance says."""
    pose, rng = np.array([3.0, -2.0, 1.0]), np.random.default_rng(1)
    line = some_lines().chosen(np.array([0]))
    wide = Lines(line.ends, line.polar, 100.0 * line.covariances)
    samples = rng.multivariate_normal(wide.polar[0], wide.covariances[0], 20_000)
    ends = np.repeat(line.ends, len(samples), axis=0)
    many = Lines(ends, samples, np.repeat(wide.covariances, len(samples), axis=0)).moved(pose)
    off = many.polar - wide.moved(pose).polar
    off[:, 0] = wrap(off[:, 0])
    # Relative error of a variance from 20,000 samples: 1 %.
    spread = np.sqrt(np.diag(wide.moved(pose).covariances[0]))
    scattered = np.cov((off / spread).T)
    said = wide.moved(pose).covariances[0] / np.outer(spread, spread)
    assert scattered == pytest.approx(said, abs=0.05)


def test_chosen_lines_keep_what_belongs_to_them() -> None:
    lines = some_lines()
    chosen = lines.chosen(lines.lengths > 4.5)
    assert 0 < len(chosen) < len(lines)
    assert (chosen.lengths > 4.5).all()
    assert len(lines.chosen(np.array([2, 0]))) == 2


def test_no_lines_can_be_moved() -> None:
    assert len(Lines.none().moved([1.0, 2.0, 3.0])) == 0


@pytest.mark.parametrize("scale", [1e-300, 1e-9, 1e9, 1e200])
def test_ranges_beyond_all_reason_do_no_harm(scale: float) -> None:
    rng = np.random.default_rng(1)
    ranges = scale * rng.uniform(0.0, 1.0, 361)
    ranges[100:200] = 2.0
    lines = extract_lines(ranges, AHEAD)
    assert np.isfinite(lines.ends).all()
    assert np.isfinite(lines.covariances).all()
