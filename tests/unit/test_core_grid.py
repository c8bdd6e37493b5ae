import math

import numpy as np
import pytest

from drawing import draw
from pilotage.core.grid import GridGeometry, OccupancyMap

GRID = GridGeometry(rows=2, cols=3, resolution=0.5, origin=(1.0, -1.0, 0.0))


def test_origin_is_the_outer_corner_of_cell_zero() -> None:
    assert GRID.centres_of([[0, 0], [1, 2]]) == pytest.approx(
        np.array([[1.25, -0.75], [2.25, -0.25]])
    )


def test_x_grows_with_the_column_and_y_with_the_row() -> None:
    assert GRID.cells_of([[2.4, -0.9], [1.1, -0.1]]).tolist() == [[0, 2], [1, 0]]


def test_points_outside_have_cells_outside() -> None:
    cells = GRID.cells_of([[0.9, -0.9], [1.1, -0.9], [2.6, -0.9], [1.1, 0.1]])
    assert GRID.contains(cells).tolist() == [False, True, False, False]


def test_turned_grid_turns_its_cells() -> None:
    turned = GridGeometry(1, 2, 1.0, (0.0, 0.0, math.pi / 2.0))
    assert turned.centres_of([[0, 1]]) == pytest.approx(np.array([[-0.5, 1.5]]))
    assert turned.cells_of([[-0.5, 1.5]]).tolist() == [[0, 1]]


def test_shape_and_size_follow_rows_and_columns() -> None:
    assert GRID.shape == (2, 3)
    assert GRID.size_m == (1.5, 1.0)


def test_cells_are_walls_from_65_on_and_free_below() -> None:
    world = OccupancyMap(GridGeometry(1, 5, 1.0), np.array([[-1, 0, 64, 65, 100]], np.int8))
    assert world.is_wall.tolist() == [[False, False, False, True, True]]
    assert world.is_free.tolist() == [[False, True, True, False, False]]


def test_cells_that_do_not_fit_the_geometry_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\(1, 1\)"):
        OccupancyMap(GRID, np.zeros((1, 1), np.int8))


def test_drawings_of_these_tests_have_row_zero_at_the_bottom() -> None:
    world = draw("""
        #.
        .?
    """)
    assert world.cells.tolist() == [[0, -1], [100, 0]]
