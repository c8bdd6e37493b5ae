"""Faces of walls found in occupancy maps."""

import time
from dataclasses import replace

import numpy as np
import pytest

from drawing import draw
from pilotage.bench.building_cases import OFFICE_CORRIDOR
from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.corners import find_corners
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.line_extraction import extract_lines
from pilotage.core.map_lines import MapLineParams, map_lines
from pilotage.core.raycast import cast_scan
from pilotage.robot.simulator.floor_plans import office_floor

ROOM = draw(
    """
    ??????????????
    ?############?
    ?#..........#?
    ?#..........#?
    ?#..........#?
    ?#..........#?
    ?#..........#?
    ?############?
    ??????????????
    """,
    resolution=0.1,
)
RIGHT, UP, LEFT, DOWN = 0.0, np.pi / 2.0, -np.pi, -np.pi / 2.0


def half_plane(alpha: float, rho: float, size: int = 80, resolution: float = 0.05) -> OccupancyMap:
    """Return a map whose cells are wall where their centres lie behind a line."""
    rows, cols = np.mgrid[0:size, 0:size]
    x, y = (cols + 0.5) * resolution, (rows + 0.5) * resolution
    behind = x * np.cos(alpha) + y * np.sin(alpha) < rho
    cells = np.where(behind, 100, 0).astype(np.int8)
    return OccupancyMap(GridGeometry(size, size, resolution), cells)


def by_direction(world: OccupancyMap) -> dict[float, float]:
    """Return the distance of each wall by the direction in which its free space lies."""
    lines = map_lines(world)
    assert len({round(a, 6) for a in lines.polar[:, 0]}) == len(lines)
    return {round(float(a), 6): float(r) for a, r in lines.polar}


def test_room_has_four_faces_on_the_sides_of_its_cells() -> None:
    faces = by_direction(ROOM)
    expected = {RIGHT: 0.2, UP: 0.2, LEFT: -1.2, DOWN: -0.7}
    assert {round(key, 6): value for key, value in expected.items()} == pytest.approx(faces)


def test_faces_end_in_the_corners() -> None:
    ends = map_lines(ROOM).ends.reshape(-1, 2)
    corners = {tuple(np.round(end, 6).tolist()) for end in ends}
    assert corners == {(0.2, 0.2), (1.2, 0.2), (1.2, 0.7), (0.2, 0.7)}


def test_free_space_lies_left_of_the_way_from_end_to_end() -> None:
    lines = map_lines(ROOM)
    along = lines.ends[:, 1] - lines.ends[:, 0]
    alpha = np.arctan2(along[:, 1], along[:, 0]) + np.pi / 2.0
    assert np.abs(wrap(alpha - lines.polar[:, 0])).max() < 1e-9


def test_back_of_a_wall_that_nobody_saw_is_no_line() -> None:
    assert len(map_lines(ROOM)) == 4
    seen_behind = draw(
        """
        ??????
        ######
        ......
        """
    )
    assert len(map_lines(seen_behind)) == 1


def test_thin_wall_has_two_faces() -> None:
    world = draw(
        """
        ........
        ........
        .######.
        ........
        """,
        resolution=0.1,
    )
    assert pytest.approx(
        {
            alpha: rho
            for alpha, rho in map_lines(world).polar.tolist()
            if min(abs(alpha - UP), abs(alpha - DOWN)) < 1e-6
        }
    ) == {UP: 0.2, DOWN: -0.1}


def test_wall_is_seen_through_the_unknown_fringe_of_a_map() -> None:
    fringed = draw(
        """
        ########
        ????????
        ........
        """,
        resolution=0.1,
    )
    assert map_lines(fringed).polar == pytest.approx(np.array([[DOWN, -0.2]]))
    assert len(map_lines(fringed, MapLineParams(fringe_cells=0))) == 0


def test_wall_behind_deep_unknown_space_is_not_seen() -> None:
    hidden = draw(
        """
        ########
        ????????
        ????????
        ........
        """,
        resolution=0.1,
    )
    assert len(map_lines(hidden)) == 0


def test_crack_in_a_wall_is_closed_and_a_door_is_not() -> None:
    picture = """
        ###############..###############
        ................................
    """
    cracked, door = draw(picture, resolution=0.1), draw(picture, resolution=0.45)
    assert len(map_lines(cracked)) == 1
    assert sorted(map_lines(door).lengths) == pytest.approx([15 * 0.45, 15 * 0.45], abs=0.01)
    assert map_lines(cracked).lengths == pytest.approx([3.2])


def test_bump_does_not_part_a_wall() -> None:
    world = draw(
        """
        ................................
        ................................
        ...............##...............
        ...............##...............
        ...............##...............
        ################################
        """,
        resolution=0.1,
    )
    along = [line for line in map_lines(world).polar if abs(line[0] - UP) < 0.02 and line[1] < 0.2]
    assert len(along) == 1


@pytest.mark.parametrize("alpha", [0.0, 0.1, 0.5, np.pi / 4.0, 1.2, 1.5])
def test_oblique_wall_is_found_to_within_a_fraction_of_a_cell(alpha: float) -> None:
    lines = map_lines(half_plane(alpha, 1.8))
    assert len(lines) == 1
    assert lines.polar[0, 0] == pytest.approx(alpha, abs=0.01)
    assert lines.polar[0, 1] == pytest.approx(1.8, abs=0.02)


def test_errors_of_rastered_walls_are_as_large_as_the_covariances_say() -> None:
    rng = np.random.default_rng(2)
    errors = []
    for _ in range(200):
        alpha, size = rng.uniform(0.0, np.pi / 2.0), int(rng.integers(20, 60))
        rho = rng.uniform(0.35, 0.65) * size * 0.05 * (np.cos(alpha) + np.sin(alpha))
        lines = map_lines(half_plane(alpha, rho, size))
        off = lines.polar[0] - [alpha, rho]
        errors.append(off @ np.linalg.solve(lines.covariances[0], off))
    # A staircase averages out what an edge along the cells hides: never too sure, then.
    assert np.mean(errors) < 2.0
    assert np.quantile(errors, 0.95) < 6.0


def test_face_along_the_cells_is_known_to_a_cell_at_its_ends() -> None:
    lines = map_lines(ROOM)
    left = np.column_stack([-np.sin(lines.polar[:, 0]), np.cos(lines.polar[:, 0])])
    places = np.einsum("nei,ni->ne", lines.ends, left)
    jacobian = np.stack([-places, np.ones_like(places)], axis=2)
    across = np.einsum("nei,nij,nej->ne", jacobian, lines.covariances, jacobian)
    assert across == pytest.approx(np.full((4, 2), 1.5 * 0.1**2 / 12.0))
    assert np.linalg.eigvalsh(lines.covariances).min() > 0.0


def test_wall_along_the_cells_errs_as_its_covariance_says() -> None:
    """It lies anywhere within a cell, and its direction is right."""
    offsets = np.random.default_rng(3).uniform(0.0, 0.05, 100)
    errors = []
    for offset in offsets:
        lines = map_lines(half_plane(0.0, 1.8 + float(offset)))
        off = lines.polar[0] - [0.0, 1.8 + offset]
        errors.append(off @ np.linalg.solve(lines.covariances[0], off))
    assert np.mean(errors) == pytest.approx(1.0, abs=0.3)


def test_map_that_lies_turned_has_its_lines_turned() -> None:
    origin = (3.0, -2.0, 0.7)
    turned = OccupancyMap(replace(ROOM.geometry, origin=origin), ROOM.cells)
    here, there = map_lines(ROOM).moved(origin), map_lines(turned)
    assert there.ends == pytest.approx(here.ends)
    assert there.polar == pytest.approx(here.polar)


def test_mirrored_map_has_mirrored_lines() -> None:
    world = office_floor()
    part = world.cells[100:400, 100:400]
    lines = map_lines(OccupancyMap(GridGeometry(300, 300, 0.05), part))
    mirrored = map_lines(OccupancyMap(GridGeometry(300, 300, 0.05), part[:, ::-1].copy()))
    assert len(lines) == pytest.approx(len(mirrored), abs=3)
    assert lines.lengths.sum() == pytest.approx(mirrored.lengths.sum(), rel=0.01)


@pytest.mark.parametrize("value", [-1, 0, 100])
def test_map_of_one_kind_has_no_lines(value: int) -> None:
    world = OccupancyMap(GridGeometry(5, 6, 0.1), np.full((5, 6), value, np.int8))
    assert len(map_lines(world)) == 0


@pytest.mark.parametrize("shape", [(1, 1), (1, 20), (20, 1)])
def test_smallest_maps_do(shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(0)
    cells = rng.choice(np.array([-1, 0, 100], np.int8), shape)
    lines = map_lines(OccupancyMap(GridGeometry(shape[0], shape[1], 0.5), cells))
    assert np.isfinite(lines.polar).all()


def test_specks_are_no_walls() -> None:
    rng = np.random.default_rng(1)
    cells = np.where(rng.random((100, 100)) < 0.02, 100, 0).astype(np.int8)
    assert len(map_lines(OccupancyMap(GridGeometry(100, 100, 0.05), cells))) == 0


def test_room_of_a_map_has_its_corners() -> None:
    corners = find_corners(map_lines(ROOM))
    tips = {tuple(tip) for tip in np.round(corners.poses[:, :2], 6).tolist()}
    assert tips == {(0.2, 0.2), (1.2, 0.2), (1.2, 0.7), (0.2, 0.7)}
    assert not corners.convex.any()


def test_pillar_in_a_map_has_four_faces_and_four_corners_that_jut_out() -> None:
    world = draw(
        """
        ..........
        ...####...
        ...####...
        ...####...
        ...####...
        ..........
        """,
        resolution=0.1,
    )
    assert len(map_lines(world)) == 4
    assert find_corners(map_lines(world)).convex.tolist() == [True] * 4


def test_laser_sees_the_lines_of_the_map() -> None:
    """Each line of a scan cast in a map lies on one of the map's, seen from the same side."""
    world = office_floor()
    low, high, middle = OFFICE_CORRIDOR
    pose = np.array([0.5 * (low + high), middle, 0.3])
    angles = (-np.pi / 2.0, float(np.deg2rad(0.5)))
    ranges = cast_scan(world, pose, angles[0] + angles[1] * np.arange(361), 20.0)
    seen = extract_lines(ranges, angles).moved(pose)
    drawn = map_lines(world)
    long = seen.chosen(seen.lengths > 1.0)
    assert len(long) > 2
    for (alpha, rho), ends in zip(long.polar, long.ends, strict=True):
        off = np.column_stack([wrap(drawn.polar[:, 0] - alpha), drawn.polar[:, 1] - rho])
        near = np.abs(off) < [0.03, 0.05]
        assert near.all(axis=1).any(), f"nothing in the map at {ends}"


def test_a_large_building_takes_less_than_two_seconds() -> None:
    tiles = np.tile(ROOM.cells, (155, 128))
    rng = np.random.default_rng(5)
    ragged = np.where(rng.random(tiles.shape) < 0.02, 100, tiles).astype(np.int8)
    rows, cols = tiles.shape
    world = OccupancyMap(GridGeometry(rows, cols, 0.05), ragged)
    assert world.cells.size > 1400 * 1750
    map_lines(ROOM)
    begun = time.process_time()
    lines = map_lines(world)
    assert time.process_time() - begun < 2.0
    assert len(lines) > 3000


def test_moving_into_the_map_frame_is_exact_far_from_the_origin() -> None:
    origin = (5000.0, -3000.0, 0.0)
    far = OccupancyMap(replace(ROOM.geometry, origin=origin), ROOM.cells)
    back = map_lines(far).moved(se2.inverse(origin))
    assert back.polar == pytest.approx(map_lines(ROOM).polar, abs=1e-6)


def test_a_lump_whose_outline_fits_a_line_across_it_makes_no_line_without_length() -> None:
    lump = draw(
        """
        ..###.?...
        ..###.?...
        ..###.....
        ..###.....
        ..###.....
        ...#......
        ..........
        """,
        resolution=0.1,
    )
    lines = map_lines(lump)
    assert len(lines) > 0
    assert (lines.lengths >= MapLineParams().least_length - 1e-9).all()
    assert np.isfinite(lines.covariances).all()
