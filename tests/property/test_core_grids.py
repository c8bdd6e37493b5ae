import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from naive import distance_field as naive_field
from naive import grid_resampling as naive_resampling
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.grid_resampling import resample

SHAPES = array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=14)
SPARSE = SHAPES.flatmap(
    lambda shape: arrays(bool, shape, elements=st.integers(0, 9).map(lambda value: value == 0))
)
CELLS = SHAPES.flatmap(
    lambda shape: arrays(np.int8, shape, elements=st.sampled_from([-1, 0, 30, 64, 65, 100]))
)


def world_of(cells: np.ndarray, origin: tuple[float, float, float]) -> OccupancyMap:
    rows, cols = cells.shape
    return OccupancyMap(GridGeometry(rows, cols, 0.1, origin), cells)


@given(SPARSE, st.floats(0.01, 2.0))
def test_distance_is_what_looking_at_every_wall_gives(is_wall: np.ndarray, size: float) -> None:
    field = distance_to_walls(is_wall, size)
    assert field == pytest.approx(naive_field.distance_to_walls(is_wall, size), rel=1e-6)


@given(SPARSE)
def test_distance_turns_and_mirrors_with_the_map(is_wall: np.ndarray) -> None:
    field = distance_to_walls(is_wall, 1.0)
    transposed = distance_to_walls(np.ascontiguousarray(is_wall.T), 1.0)
    mirrored = distance_to_walls(np.ascontiguousarray(is_wall[::-1, ::-1]), 1.0)
    assert (field == transposed.T).all()
    assert (mirrored[::-1, ::-1] == field).all()


@given(SPARSE)
def test_distance_grows_by_at_most_a_step_from_cell_to_cell(is_wall: np.ndarray) -> None:
    is_wall = is_wall.copy()
    is_wall[0, 0] = True
    field = distance_to_walls(is_wall, 1.0)
    for axis in (0, 1):
        assert (np.abs(np.diff(field, axis=axis)) <= 1.0 + 1e-6).all()


@given(CELLS, st.sampled_from([0.05, 0.07, 0.1, 0.15, 0.2, 0.25, 0.33]))
def test_coarse_cell_is_what_its_fine_cells_say(cells: np.ndarray, resolution: float) -> None:
    world = world_of(cells, (0.0, 0.0, 0.0))
    coarse = resample(world, resolution)
    for cell in np.ndindex(coarse.geometry.shape):
        expected = naive_resampling.resampled_cell(world, cell, resolution)
        assert coarse.cells[cell] == expected


@given(CELLS, st.sampled_from([0.1, 0.17, 0.2, 0.5]))
def test_resampled_map_covers_the_old_one(cells: np.ndarray, resolution: float) -> None:
    world = world_of(cells, (1.0, 2.0, 0.3))
    coarse = resample(world, resolution)
    for new, old in zip(coarse.geometry.size_m, world.geometry.size_m, strict=True):
        assert old - 1e-6 <= new <= old + resolution
    walls = world.geometry.centres_of(np.argwhere(world.is_wall))
    rows, cols = coarse.geometry.cells_of(walls).T
    assert coarse.is_wall[rows, cols].all()


@given(
    st.tuples(*[st.floats(-50.0, 50.0)] * 3),
    st.floats(0.02, 1.0),
    st.integers(0, 30),
    st.integers(0, 20),
)
def test_centre_of_a_cell_lies_in_that_cell(
    origin: tuple[float, float, float], size: float, row: int, col: int
) -> None:
    geometry = GridGeometry(31, 21, size, origin)
    assert geometry.cells_of(geometry.centres_of([[row, col]])).tolist() == [[row, col]]
