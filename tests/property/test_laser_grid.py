import math
from collections.abc import Callable
from itertools import pairwise
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from naive import laser_grid as naive
from pilotage.core.grid import OccupancyMap
from pilotage.mapper import laser_grid_kernels as kernels
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_params import LaserGridParams

SIZE = 0.0625
"""Cells of a size that floating point divides by exactly."""

PARAMS = LaserGridParams(resolution=SIZE)
RASTER = st.integers(-40_000, 40_000).map(lambda k: (2 * k + 1) * SIZE / kernels.PARTS)
"""Coordinates [m] on the raster, +-5 m, so that mirrored points are on it too."""

Scan = tuple[Any, ...]
"""Arguments of `insert`: origin, ends, is_hit, and perhaps a stamp."""

ANY = st.floats(-4.0, 4.0)
POINTS = st.tuples(ANY, ANY)


def scans(coordinate: st.SearchStrategy[float]) -> st.SearchStrategy[Scan]:
    beam = st.tuples(coordinate, coordinate, st.booleans())
    return st.tuples(coordinate, coordinate, st.lists(beam, max_size=8)).map(as_scan)


def as_scan(drawn: tuple[Any, ...]) -> Scan:
    x, y, beams = drawn
    ends = np.array([beam[:2] for beam in beams], float).reshape(-1, 2)
    return np.array([x, y]), ends, np.array([beam[2] for beam in beams], bool)


def rooms(rng: np.random.Generator, count: int) -> list[Scan]:
    """Scans by a robot that wanders in a room with a pillar, stamps now dense and now far apart."""
    origin, stamp, seen = np.array([0.3, -0.2]), 0.0, []
    for _ in range(count):
        origin = np.clip(origin + rng.normal(0.0, 0.1, 2), -0.9, 0.9)
        stamp += rng.choice([0.1, 0.3, 0.8])
        angles = np.linspace(-math.pi, math.pi, 60, endpoint=False)
        ranges = np.minimum(
            1.5 / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles))),
            np.where(np.abs(angles - rng.choice([1.0, -2.0])) < 0.15, 0.7, 9.0),
        ) + rng.normal(0.0, 0.01, 60)
        ends = origin + ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        ends[rng.random(60) < 0.02] = np.nan
        seen.append((origin.copy(), ends, rng.random(60) < 0.95, stamp))
    return seen


def drawn(all_scans: list[Scan], params: LaserGridParams = PARAMS) -> LaserGrid:
    grid = LaserGrid(params)
    for scan in all_scans:
        grid.insert(*scan)
    return grid


def by_cell(world: OccupancyMap, values: np.ndarray | None = None) -> dict[tuple[int, int], float]:
    """Values by row and col of the raster whose corner is the map's origin, without the unknown."""
    x, y, _ = world.geometry.origin
    row, col = round(y / world.geometry.resolution), round(x / world.geometry.resolution)
    cells = world.cells if values is None else values
    known = np.argwhere(~np.isnan(cells) & (cells != -1))
    return {(int(r) + row, int(c) + col): float(cells[r, c]) for r, c in known}


def evidence(grid: LaserGrid) -> dict[tuple[int, int], float]:
    return by_cell(grid.map(), grid.log_odds())


@given(RASTER, RASTER, RASTER, RASTER, st.integers(0, kernels.SHARE))
def test_a_beam_crosses_the_cells_whose_corners_lie_on_both_sides(
    x: float, y: float, end_x: float, end_y: float, share: int
) -> None:
    start, end = (
        (kernels.raster(a / SIZE) + 85 * 1024, kernels.raster(b / SIZE) + 85 * 1024)
        for a, b in ((x, y), (end_x, end_y))
    )
    marks = np.zeros((170, 170), np.uint8)
    kernels.mark_beam(marks.reshape(-1), 170, start, end, share)
    cells = naive.passed_cells(start, end, share)
    assert {tuple(cell) for cell in np.argwhere(marks).tolist()} == set(cells)


@given(st.integers(-30, 30), st.integers(-30, 30), st.integers(-3, 3), st.integers(1, 1023))
def test_a_beam_through_corners_goes_from_cell_to_opposite_cell(
    row: int, col: int, more: int, inside: int
) -> None:
    """Along the diagonal of the raster, where every crossing is through a corner or none is."""
    start = ((40 + col) * 1024 + inside | 1, (40 + row) * 1024 + inside | 1)
    end = start[0] + more * 1024, start[1] + more * 1024
    marks = np.zeros((90, 90), np.uint8)
    kernels.mark_beam(marks.reshape(-1), 90, start, end, 0)
    assert marks.sum() == abs(more) + 1
    assert marks[40 + row, 40 + col] == 1


@settings(max_examples=20)  # the plain twin takes its time
@given(st.integers(0, 2**32 - 1), st.integers(1, 12))
def test_the_grid_is_what_plain_python_draws(seed: int, count: int) -> None:
    plain = naive.PlainLaserGrid(PARAMS)
    grid = LaserGrid(PARAMS)
    for scan in rooms(np.random.default_rng(seed), count):
        plain.insert(*scan)
        grid.insert(*scan)
    levels = {
        cell: here.level / 256.0
        for cell, here in plain.cells.items()
        if here.is_passed or here.level
    }
    assert evidence(grid) == levels
    values = {cell: plain.value(cell) for cell in levels if plain.value(cell) >= 0}
    assert by_cell(grid.map()) == values


@given(scans(ANY))
def test_only_what_beams_cross_is_free(scan: Scan) -> None:
    origin, ends, _ = scan
    grid = drawn([scan])
    world = grid.map()
    free = world.geometry.centres_of(np.argwhere(world.cells == 0))
    for centre in free:
        away = min(distance_to_segment(centre, origin, end) for end in ends)
        assert away <= SIZE * math.sqrt(0.5) + 1e-3


def distance_to_segment(point: np.ndarray, start: np.ndarray, end: np.ndarray) -> float:
    way = end - start
    share = np.clip((point - start) @ way / max(way @ way, 1e-12), 0.0, 1.0)
    return float(np.hypot(*(start + share * way - point)))


@given(scans(ANY))
def test_where_a_beam_hits_something_is_and_nothing_where_none_does(scan: Scan) -> None:
    origin, ends, is_hit = scan
    assume((np.hypot(*(ends - origin).T) > 1e-9).all())
    grid = drawn([scan])
    hits = {(math.floor(y / SIZE), math.floor(x / SIZE)) for (x, y) in ends[is_hit]}
    assert {cell for cell, value in evidence(grid).items() if value > 0.0} == hits


@given(st.lists(scans(ANY), max_size=4))
def test_beams_without_a_return_never_make_walls(some: list[Scan]) -> None:
    grid = drawn([(origin, ends, np.zeros(len(ends), bool)) for origin, ends, _ in some])
    assert not grid.map().is_wall.any()
    assert all(value < 0.0 for value in evidence(grid).values())


@given(st.lists(scans(ANY), max_size=3), st.randoms(use_true_random=False))
def test_a_few_scans_say_the_same_in_any_order(some: list[Scan], random: Random) -> None:
    """Three scans cannot reach the limits of evidence."""
    mixed = some.copy()
    random.shuffle(mixed)
    there, back = drawn(some), drawn(mixed)
    assert evidence(there) == evidence(back)
    assert there.map().geometry == back.map().geometry


Motion = tuple[np.ndarray, Callable[[int, int], tuple[int, int]]]
MOTIONS: dict[str, Motion] = {
    "mirrored left and right": (np.array([[-1.0, 0.0], [0.0, 1.0]]), lambda r, c: (r, -1 - c)),
    "mirrored up and down": (np.array([[1.0, 0.0], [0.0, -1.0]]), lambda r, c: (-1 - r, c)),
    "turned by 90 degrees": (np.array([[0.0, -1.0], [1.0, 0.0]]), lambda r, c: (c, -1 - r)),
    "turned by 180 degrees": (-np.eye(2), lambda r, c: (-1 - r, -1 - c)),
}


@pytest.mark.parametrize("motion", MOTIONS)
@given(some=st.lists(scans(RASTER), min_size=1, max_size=3))
def test_a_mirrored_or_turned_world_has_a_map_so(motion: str, some: list[Scan]) -> None:
    matrix, moved_cell = MOTIONS[motion]
    moved = [(origin @ matrix.T, ends @ matrix.T, is_hit) for origin, ends, is_hit in some]
    here, there = drawn(some), drawn(moved)
    assert evidence(there) == {moved_cell(*k): v for k, v in evidence(here).items()}
    walls = {moved_cell(*k): v for k, v in by_cell(here.map()).items()}
    assert by_cell(there.map()) == walls


@given(st.lists(scans(ANY), min_size=1, max_size=4), POINTS, st.integers(1, 30))
def test_a_map_that_grew_is_one_that_was_large_from_the_start(
    some: list[Scan], corner: tuple[float, float], size: int
) -> None:
    apart = [
        (origin + 8.0 * k, ends + 8.0 * k, is_hit) for k, (origin, ends, is_hit) in enumerate(some)
    ]
    large = LaserGrid(PARAMS)
    large.make_room(np.array(corner) - size, np.array(corner) + size)
    for scan in apart:
        large.insert(*scan)
    grown = drawn(apart)
    assert evidence(large) == evidence(grown)
    assert by_cell(large.map()) == by_cell(grown.map())


@given(st.lists(scans(ANY), min_size=1, max_size=5), st.integers(0, 5))
def test_what_was_remembered_goes_on_as_if_nothing_had_been(some: list[Scan], pause: int) -> None:
    stamped = [(*scan, 0.2 * k) for k, scan in enumerate(some)]
    whole = drawn(stamped)
    resumed = LaserGrid.from_state(drawn(stamped[:pause]).state(), PARAMS)
    for scan in stamped[pause:]:
        resumed.insert(*scan)
    assert evidence(resumed) == evidence(whole)
    assert by_cell(resumed.map()) == by_cell(whole.map())


@given(st.lists(scans(ANY), min_size=2, max_size=5))
def test_cells_change_only_in_the_window_that_is_told(some: list[Scan]) -> None:
    grid = LaserGrid(PARAMS)
    grid.make_room((-9.0, -9.0), (9.0, 9.0))
    maps = []
    for scan in some:
        grid.insert(*scan)
        maps.append((grid.map(), grid.changed()))
    for (before, _), (after, window) in pairwise(maps):
        assert window is not None
        inside = np.zeros(after.cells.shape, bool)
        inside[window.slices] = True
        assert (before.cells == after.cells)[~inside].all()
    assert grid.changed() is None
