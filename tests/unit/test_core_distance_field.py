import numpy as np
import pytest

from drawing import draw
from pilotage.core.distance_field import distance_to_map_walls, distance_to_walls


def test_distance_is_measured_between_cell_centres_in_metres() -> None:
    field = distance_to_map_walls(draw("#...", resolution=0.5))
    assert field[0] == pytest.approx([0.0, 0.5, 1.0, 1.5])


def test_diagonal_distance_is_euclidean() -> None:
    field = distance_to_map_walls(
        draw("""
        ....
        ....
        ....
        #...
        """)
    )
    assert field[3, 2] == pytest.approx(np.hypot(3.0, 2.0))


def test_nearest_of_several_walls_counts() -> None:
    field = distance_to_map_walls(
        draw("""
        #.....#
        .......
        ...?...
        """)
    )
    assert field[0, 3] == pytest.approx(np.hypot(2.0, 3.0))
    assert field[2, 5] == pytest.approx(1.0)


def test_without_a_wall_the_distance_is_infinite() -> None:
    assert np.isinf(distance_to_walls(np.zeros((3, 4), bool), 0.1)).all()


def test_field_of_walls_alone_is_zero() -> None:
    assert (distance_to_walls(np.ones((3, 4), bool), 0.1) == 0.0).all()


def test_field_has_the_shape_of_the_map_and_single_precision() -> None:
    field = distance_to_walls(np.eye(5, 7, dtype=bool), 0.1)
    assert field.shape == (5, 7)
    assert field.dtype == np.float32
