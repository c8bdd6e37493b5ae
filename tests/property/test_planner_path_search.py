"""Laws of ways through grids, and their plain twins."""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import path_search as naive
from pilotage.planner import path_kernels
from pilotage.planner.path_search import Cells, Field, Mask, shortened, travel_field, way_to

Cell = tuple[int, int]
Floor = tuple[Mask, Field, list[Cell]]


@st.composite
def floors(draw: st.DrawFn) -> Floor:
    """A grid, costs in it, and three of its free cells."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shape = (draw(st.integers(1, 14)), draw(st.integers(1, 14)))
    passable = rng.random(shape) > draw(st.sampled_from([0.0, 0.2, 0.4]))
    dearest = draw(st.sampled_from([0.0, 1.0, 30.0]))
    cost = (1.0 + dearest * rng.random(shape)).astype(np.float32)
    cells = [(int(rng.integers(shape[0])), int(rng.integers(shape[1]))) for _ in range(3)]
    for cell in cells:
        passable[cell] = True
    return passable, cost, cells


def cells_of(way: Cells) -> list[Cell]:
    return [(int(row), int(col)) for row, col in way]


@given(floors())
@settings(max_examples=60, deadline=None)
def test_costs_are_those_of_the_twin(floor: Floor) -> None:
    passable, cost, (start, _, _) = floor
    field = travel_field(passable, cost, 0.1, start)
    np.testing.assert_allclose(field, naive.travel_field(passable, cost, 0.1, start), rtol=1e-5)


@given(floors())
@settings(max_examples=60, deadline=None)
def test_a_search_with_a_goal_finds_the_best_way(floor: Floor) -> None:
    passable, cost, (start, goal, _) = floor
    whole = travel_field(passable, cost, 0.1, start)
    part = travel_field(passable, cost, 0.1, start, goal)
    np.testing.assert_allclose(part[goal], whole[goal], rtol=1e-5)


@given(floors())
@settings(max_examples=60, deadline=None)
def test_there_and_back_cost_the_same(floor: Floor) -> None:
    passable, cost, (start, goal, _) = floor
    there = travel_field(passable, cost, 0.1, start)[goal]
    back = travel_field(passable, cost, 0.1, goal)[start]
    np.testing.assert_allclose(there, back, rtol=1e-5)


@given(floors())
@settings(max_examples=60, deadline=None)
def test_no_detour_is_cheaper(floor: Floor) -> None:
    passable, cost, (start, by, goal) = floor
    from_start = travel_field(passable, cost, 0.1, start)
    from_by = travel_field(passable, cost, 0.1, by)
    assert from_start[goal] <= from_start[by] + from_by[goal] + 1e-4 * (1.0 + from_start[goal])


@given(floors())
@settings(max_examples=60, deadline=None)
def test_a_way_costs_what_its_field_says_and_takes_only_allowed_steps(floor: Floor) -> None:
    passable, cost, (start, goal, _) = floor
    field = travel_field(passable, cost, 0.1, start, goal)
    way = way_to(field, passable, goal, cost)
    if len(way) == 0:
        assert np.isinf(field[goal])
        return
    cells = cells_of(way)
    assert (cells[0], cells[-1]) == (start, goal)
    assert all(b in naive.neighbours(passable, a) for a, b in itertools.pairwise(cells))
    np.testing.assert_allclose(naive.way_cost(cost, way, 0.1), field[goal], rtol=1e-4, atol=1e-6)


@given(floors())
@settings(max_examples=60, deadline=None)
def test_a_shortened_way_keeps_off_blocked_cells_and_costs_no_more(floor: Floor) -> None:
    passable, cost, (start, goal, _) = floor
    field = travel_field(passable, cost, 1.0, start)
    way = way_to(field, passable, goal, cost)
    short = shortened(way, passable, cost)
    factors = np.pad(np.where(passable, cost, 0.0).astype(np.float32), 1)
    cells = cells_of(short + 1)
    total = sum(naive.line_cost(factors, a, b) for a, b in itertools.pairwise(cells))
    assert total <= field[goal] * (1.0 + 1e-4) + 1e-4 or len(way) == 0
    assert set(cells_of(short)) <= set(cells_of(way))


@given(floors())
@settings(max_examples=100, deadline=None)
def test_a_line_costs_what_the_twin_says(floor: Floor) -> None:
    passable, cost, (start, end, _) = floor
    factors = np.pad(np.where(passable, cost, 0.0).astype(np.float32), 1)
    a, b = (start[0] + 1, start[1] + 1), (end[0] + 1, end[1] + 1)
    measured = path_kernels.line_cost(factors, np.array(a), np.array(b))
    np.testing.assert_allclose(measured, naive.line_cost(factors, a, b), rtol=1e-5)
