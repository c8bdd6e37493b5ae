import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from naive import raycast as naive
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_ray_in_grid, cast_rays, cast_scan, expected_ranges

SHAPES = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=12)
WALLS = SHAPES.flatmap(
    lambda shape: arrays(bool, shape, elements=st.floats(0, 1).map(lambda value: value > 0.8))
)
UNIT = st.floats(0.001, 0.999)
DIRECTIONS = st.floats(-7.0, 7.0)


def world_of(is_wall: np.ndarray, origin: tuple[float, float, float], size: float) -> OccupancyMap:
    cells = np.where(is_wall, 100, 0).astype(np.int8)
    rows, cols = is_wall.shape
    return OccupancyMap(GridGeometry(rows, cols, size, origin), cells)


def grazes(is_wall: np.ndarray, x: float, y: float, theta: float) -> bool:
    """Say whether the ray starts or passes where rounding decides what it meets."""
    if min(abs(x - round(x)), abs(y - round(y))) < 1e-9:
        return True
    rows, cols = np.indices((is_wall.shape[0] + 1, is_wall.shape[1] + 1))
    aside = (cols - x) * math.sin(theta) - (rows - y) * math.cos(theta)
    return bool(np.abs(aside).min() < 1e-9)


@given(WALLS, UNIT, UNIT, DIRECTIONS, st.floats(0.5, 30.0))
def test_ray_measures_what_the_boxes_of_all_walls_say(
    is_wall: np.ndarray, x_share: float, y_share: float, theta: float, max_cells: float
) -> None:
    x, y = x_share * is_wall.shape[1], y_share * is_wall.shape[0]
    assume(not grazes(is_wall, x, y, theta))
    measured = cast_ray_in_grid(is_wall, x, y, theta, max_cells)
    assert measured == pytest.approx(naive.cast_ray_in_grid(is_wall, x, y, theta, max_cells))


@given(WALLS, UNIT, UNIT, UNIT, UNIT)
def test_who_sees_is_seen(is_wall: np.ndarray, ax: float, ay: float, bx: float, by: float) -> None:
    rows, cols = is_wall.shape
    x, y, end_x, end_y = ax * cols, ay * rows, bx * cols, by * rows
    distance, theta = math.hypot(end_x - x, end_y - y), math.atan2(end_y - y, end_x - x)
    assume(distance > 1e-3)
    assume(not grazes(is_wall, x, y, theta))
    there = cast_ray_in_grid(is_wall, x, y, theta, 100.0)
    back = cast_ray_in_grid(is_wall, end_x, end_y, theta + math.pi, 100.0)
    assume(abs(there - distance) > 1e-9)
    assume(abs(back - distance) > 1e-9)
    assert (there >= distance) == (back >= distance)


@given(WALLS, st.tuples(UNIT, UNIT, DIRECTIONS), st.tuples(*[st.floats(-5.0, 5.0)] * 3))
def test_moving_the_map_and_the_robot_together_changes_nothing(
    is_wall: np.ndarray, start: tuple[float, float, float], motion: tuple[float, float, float]
) -> None:
    size = 0.25
    x, y = start[0] * is_wall.shape[1], start[1] * is_wall.shape[0]
    assume(not grazes(is_wall, x, y, start[2]))
    pose = np.array([x * size, y * size, start[2]])
    here = cast_scan(world_of(is_wall, (0.0, 0.0, 0.0), size), pose, [0.0], 20.0)
    there = cast_scan(world_of(is_wall, motion, size), se2.compose(motion, pose), [0.0], 20.0)
    assert there == pytest.approx(here, abs=1e-6)


@given(WALLS, UNIT, UNIT, DIRECTIONS)
def test_a_further_wall_never_lengthens_a_range(
    is_wall: np.ndarray, x_share: float, y_share: float, theta: float
) -> None:
    x, y = x_share * is_wall.shape[1], y_share * is_wall.shape[0]
    more = is_wall.copy()
    more[0, 0] = True
    before = cast_ray_in_grid(is_wall, x, y, theta, 50.0)
    assert cast_ray_in_grid(more, x, y, theta, 50.0) <= before


@settings(max_examples=50)
@given(WALLS, st.integers(1, 4), st.sampled_from([3, 5, 7]), st.floats(0.0, 3.0))
def test_range_table_holds_what_single_scans_measure(
    is_wall: np.ndarray, ratio: int, headings: int, turn: float
) -> None:
    world = world_of(is_wall, (1.0, -2.0, turn), 0.5)
    shape = -(-is_wall.shape[0] // ratio), -(-is_wall.shape[1] // ratio)
    geometry = GridGeometry(*shape, 0.5 * ratio, world.geometry.origin)
    table = expected_ranges(world, geometry, headings, 4.0)
    centres = geometry.centres_of(np.argwhere(np.ones(shape, bool)))
    for k in range(headings):
        theta = 2.0 * math.pi * k / headings
        for centre, entry in zip(centres, table[k].ravel(), strict=True):
            x, y = world.geometry.grid_from_map([centre])[0] / 0.5
            if not grazes(is_wall, x, y, theta - turn):
                measured = cast_rays(world, [[*centre, theta]], 4.0)[0]
                assert entry == pytest.approx(min(measured, 4.0), abs=1e-5)
