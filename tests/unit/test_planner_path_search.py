"""Ways through drawn grids."""

import numpy as np
import pytest

from drawing import draw
from pilotage.core.grid import OccupancyMap
from pilotage.planner import path_kernels
from pilotage.planner.path_search import Field, Mask, shortened, travel_field, way_to


def open_cells(picture: str) -> tuple[Mask, Field]:
    world: OccupancyMap = draw(picture)
    return world.is_free, np.ones(world.cells.shape, np.float32)


def test_costs_grow_along_straight_and_diagonal_steps() -> None:
    field = travel_field(*open_cells("... ... ..."), 0.5, (0, 0))
    assert field[0] == pytest.approx([0.0, 0.5, 1.0])
    assert field[2, 2] == pytest.approx(np.sqrt(2.0))
    assert field.dtype == np.float32


def test_a_way_leads_round_a_wall() -> None:
    passable, cost = open_cells(
        """
        .....
        .###.
        .....
        """
    )
    field = travel_field(passable, cost, 1.0, (0, 2))
    # Diagonal steps would cut the corners of the wall.
    assert field[2, 2] == pytest.approx(6.0)
    way = way_to(field, passable, (2, 2), cost)
    assert len(way) == 7
    assert tuple(way[0]) == (0, 2)
    assert tuple(way[-1]) == (2, 2)


def test_corners_are_not_cut() -> None:
    field = travel_field(*open_cells(".. .#"), 1.0, (0, 0))
    assert field[1, 1] == pytest.approx(2.0)


def test_no_way_leads_between_two_blocked_cells_that_touch_at_a_corner() -> None:
    field = travel_field(*open_cells("#. .#"), 1.0, (0, 0))
    assert np.isinf(field[1, 1])


def test_what_cannot_be_reached_costs_infinitely_much_and_has_no_way() -> None:
    passable, cost = open_cells(".#.")
    field = travel_field(passable, cost, 1.0, (0, 0))
    assert np.isinf(field[0, 2])
    assert way_to(field, passable, (0, 2), cost).shape == (0, 2)


def test_from_a_blocked_start_nothing_is_reached() -> None:
    assert np.isinf(travel_field(*open_cells("#..."), 1.0, (0, 0))).all()


def test_a_dear_cell_is_gone_round() -> None:
    passable, cost = open_cells("..... ..... .....")
    cost[:2, 2] = 10.0
    field = travel_field(passable, cost, 1.0, (0, 0))
    way = way_to(field, passable, (0, 4), cost)
    assert (2, 2) in {(int(row), int(col)) for row, col in way}


def test_a_search_with_a_goal_costs_the_same_and_looks_at_less() -> None:
    passable, cost = np.ones((60, 60), bool), np.ones((60, 60), np.float32)
    whole = travel_field(passable, cost, 0.1, (30, 5))
    part = travel_field(passable, cost, 0.1, (30, 5), (33, 30))
    assert part[33, 30] == whole[33, 30]
    assert np.isfinite(part).sum() < 0.3 * part.size


def test_the_way_to_the_start_is_the_start() -> None:
    passable, cost = open_cells("...")
    field = travel_field(passable, cost, 1.0, (0, 1))
    assert way_to(field, passable, (0, 1)).tolist() == [[0, 1]]


def test_in_the_open_a_straight_line_takes_the_place_of_a_way() -> None:
    passable, cost = np.ones((20, 40), bool), np.ones((20, 40), np.float32)
    field = travel_field(passable, cost, 1.0, (2, 3))
    way = way_to(field, passable, (15, 37), cost)
    assert shortened(way, passable, cost).tolist() == [[2, 3], [15, 37]]


def test_a_straight_line_does_not_lead_through_a_wall() -> None:
    passable, cost = open_cells(
        """
        .........
        ...#.....
        ...#.....
        ...#.....
        .........
        """
    )
    field = travel_field(passable, cost, 1.0, (2, 1))
    short = shortened(way_to(field, passable, (2, 7), cost), passable, cost)
    assert 2 < len(short) <= 4
    factors = np.pad(np.where(passable, cost, 0.0).astype(np.float32), 1)
    for a, b in zip(short[:-1] + 1, short[1:] + 1, strict=True):
        assert np.isfinite(path_kernels.line_cost(factors, a, b))


def test_a_straight_line_does_not_save_a_step_by_a_dear_way() -> None:
    passable, cost = np.ones((7, 9), bool), np.ones((7, 9), np.float32)
    cost[:4, 4] = 20.0
    field = travel_field(passable, cost, 1.0, (1, 1))
    way = way_to(field, passable, (1, 7), cost)
    assert len(shortened(way, passable, cost)) > 2


def test_a_line_by_the_corner_of_a_blocked_cell_is_blocked() -> None:
    factors = np.ones((4, 4), np.float32)
    factors[1, 2] = 0.0
    diagonal = path_kernels.line_cost(factors, np.array([1, 1]), np.array([2, 2]))
    assert np.isinf(diagonal)
    beside = path_kernels.line_cost(factors, np.array([1, 1]), np.array([3, 1]))
    assert beside == pytest.approx(2.0)
