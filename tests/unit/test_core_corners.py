"""Corners by the criterion of Zhuang et al. 2005, eq. 1 to 3."""

import numpy as np
import pytest

from pilotage.core.angles import wrap
from pilotage.core.corners import CornerParams, find_corners
from pilotage.core.line_extraction import LineParams, extract_lines
from pilotage.core.line_fit import BeamNoise
from pilotage.core.lines import Lines
from wall_scans import FULL_TURN, room, scan_of, seen_from

Point = tuple[float, float]
DIAGONAL = np.pi / 4.0


def lines_of(*walls: tuple[Point, Point], sigmas: Point = (0.01, 0.02)) -> Lines:
    """Return lines with free space on the left of the way from end to end."""
    ends = np.array(walls)
    along = ends[:, 1] - ends[:, 0]
    alpha = wrap(np.arctan2(along[:, 1], along[:, 0]) + np.pi / 2.0)
    rho = np.sum(np.column_stack([np.cos(alpha), np.sin(alpha)]) * ends[:, 0], axis=1)
    covariances = np.tile(np.diag(np.square(sigmas)), (len(ends), 1, 1))
    return Lines(ends, np.column_stack([alpha, rho]), covariances)


def turned(lines: Lines, angle: float) -> Lines:
    return lines.moved([0.0, 0.0, angle])


# Free space is the quadrant x, y > 0.
INNER = lines_of(((0.0, 3.0), (0.0, 0.0)), ((0.0, 0.0), (2.0, 0.0)))
# The wall is the quadrant x, y < 0: the mouth of a corridor.
OUTER = lines_of(((-2.0, 0.0), (0.0, 0.0)), ((0.0, 0.0), (0.0, -2.0)))


def test_corner_of_a_room_opens_into_the_room() -> None:
    corners = find_corners(INNER)
    assert len(corners) == 1
    assert corners.poses[0] == pytest.approx([0.0, 0.0, DIAGONAL])
    assert corners.convex.tolist() == [False]
    assert corners.lines.tolist() == [[0, 1]]


def test_corner_that_juts_out_points_into_free_space() -> None:
    corners = find_corners(OUTER)
    assert corners.poses[0] == pytest.approx([0.0, 0.0, DIAGONAL])
    assert corners.convex.tolist() == [True]


@pytest.mark.parametrize("angle", np.arange(-180.0, 180.0, 15.0).tolist())
@pytest.mark.parametrize("lines", [INNER, OUTER])
def test_corner_is_one_whichever_way_the_building_stands(lines: Lines, angle: float) -> None:
    """Printed eq. 1 takes arctangents of slopes, which jump where a wall is upright."""
    corners = find_corners(turned(lines, np.deg2rad(angle)))
    assert len(corners) == 1
    assert wrap(corners.poses[0, 2] - DIAGONAL - np.deg2rad(angle)) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("off", "found"), [(0.0, 1), (14.0, 1), (-14.0, 1), (16.0, 0), (-16.0, 0)])
def test_walls_must_be_nearly_square(off: float, found: int) -> None:
    angle = np.deg2rad(off)
    slanted = (2.0 * np.cos(angle), 2.0 * np.sin(angle))
    lines = lines_of(((0.0, 3.0), (0.0, 0.0)), ((0.0, 0.0), slanted))
    assert len(find_corners(lines, CornerParams(most_off_square=np.deg2rad(15.0)))) == found


@pytest.mark.parametrize(("short", "found"), [(0.0, 1), (0.2, 1), (0.22, 0), (0.5, 0)])
def test_ends_must_be_near(short: float, found: int) -> None:
    lines = lines_of(((0.0, 3.0), (0.0, short)), ((short, 0.0), (2.0, 0.0)))
    assert len(find_corners(lines, CornerParams(most_apart=0.3))) == found


def test_tip_lies_where_the_walls_cross() -> None:
    lines = lines_of(((0.0, 3.0), (0.0, 0.1)), ((0.2, 0.0), (2.0, 0.0)))
    assert find_corners(lines).poses[0, :2] == pytest.approx([0.0, 0.0])


def test_tip_is_the_mean_of_the_near_ends_if_eq_3_is_asked_for() -> None:
    lines = lines_of(((0.0, 3.0), (0.0, 0.1)), ((0.2, 0.0), (2.0, 0.0)))
    corners = find_corners(lines, CornerParams(tip="mean of ends"))
    assert corners.poses[0, :2] == pytest.approx([0.1, 0.05])


def test_wall_that_goes_straight_on_makes_no_corner() -> None:
    assert len(find_corners(lines_of(((2.0, 0.0), (0.0, 0.0)), ((0.0, 0.0), (-2.0, 0.0))))) == 0


def test_walls_seen_from_different_sides_make_no_corner() -> None:
    """One wall is a room's, the other the back of it, seen from next door."""
    lines = lines_of(((0.0, 3.0), (0.0, 0.0)), ((2.0, 0.0), (0.0, 0.0)))
    assert len(find_corners(lines)) == 0


def test_end_of_a_wall_against_the_middle_of_another_makes_no_corner() -> None:
    lines = lines_of(((-2.0, 0.0), (2.0, 0.0)), ((0.0, 2.0), (0.0, 0.05)))
    assert len(find_corners(lines)) == 0


def test_room_has_four_corners_in_a_row() -> None:
    corners = find_corners(lines_of(*room(5.0, 4.0)))
    assert {tuple(tip) for tip in np.round(corners.poses[:, :2] + 0.0, 9).tolist()} == {
        (0.0, 0.0),
        (5.0, 0.0),
        (5.0, 4.0),
        (0.0, 4.0),
    }
    assert not corners.convex.any()
    assert sorted(corners.lines[:, 0]) == sorted(corners.lines[:, 1]) == [0, 1, 2, 3]


def test_pillar_has_four_corners_that_jut_out() -> None:
    around = [(second, first) for first, second in reversed(room(1.0, 1.0))]
    corners = find_corners(lines_of(*around))
    assert corners.convex.tolist() == [True] * 4
    away = corners.poses[:, :2] - 0.5
    expected = np.arctan2(away[:, 1], away[:, 0])
    assert wrap(corners.poses[:, 2] - expected) == pytest.approx(np.zeros(4), abs=1e-9)


@pytest.mark.parametrize("tip", ["crossing", "mean of ends"])
def test_no_lines_have_no_corners(tip: str) -> None:
    params = CornerParams(tip="crossing" if tip == "crossing" else "mean of ends")
    for lines in (Lines.none(), INNER.chosen(np.array([0]))):
        corners = find_corners(lines, params)
        assert (len(corners), corners.covariances.shape) == (0, (0, 2, 2))


def test_covariance_is_what_sampled_walls_scatter() -> None:
    rng = np.random.default_rng(3)
    lines = turned(lines_of(((0.5, 3.0), (0.5, 1.0)), ((0.5, 1.0), (2.0, 1.1))), 0.7)
    tips = []
    for _ in range(4000):
        polar = [
            rng.multivariate_normal(*one)
            for one in zip(lines.polar, lines.covariances, strict=True)
        ]
        sampled = Lines(lines.ends, np.array(polar), lines.covariances)
        tips.append(find_corners(sampled).poses[0, :2])
    said = find_corners(lines).covariances[0]
    # A variance from 4000 samples errs by 2 %.
    assert np.cov(np.array(tips).T) == pytest.approx(said, abs=0.08 * np.trace(said))


@pytest.mark.parametrize(("tip", "most"), [("crossing", 0.006), ("mean of ends", 0.13)])
def test_corners_of_a_scanned_room_are_as_good_as_they_say(tip: str, most: float) -> None:
    """The tip errs as its covariance says, and the crossing errs far less than eq. 3."""
    rng, params = np.random.default_rng(4), CornerParams()
    if tip != "crossing":
        params = CornerParams(tip="mean of ends")
    off, errors = [], []
    for _ in range(60):
        pose = [*rng.uniform([0.5, 0.5], [4.5, 3.5]), rng.uniform(-3.0, 3.0)]
        walls = seen_from(pose, room(5.0, 4.0))
        ranges = scan_of(walls) + 0.01 * rng.standard_normal(720)
        noise = LineParams(noise=BeamNoise(0.01, 0.0002, 0.0))
        corners = find_corners(extract_lines(ranges, FULL_TURN, noise), params)
        for found, covariance in zip(corners.poses[:, :2], corners.covariances, strict=True):
            miss = found - walls[np.linalg.norm(walls[:, 0] - found, axis=1).argmin(), 0]
            off.append(np.hypot(*miss))
            errors.append(miss @ np.linalg.solve(covariance, miss))
    assert len(off) > 0.9 * 60 * 4
    assert np.quantile(off, 0.95) < most
    assert 1.5 < np.mean(errors) < 2.6


def test_a_building_of_many_walls_is_searched_at_once() -> None:
    many = [
        ((x + a, y + b), (x + c, y + d))
        for x in range(0, 120, 3)
        for y in range(0, 90, 3)
        for (a, b), (c, d) in room(2.0, 2.0)
    ]
    assert len(find_corners(lines_of(*many))) == len(many)
