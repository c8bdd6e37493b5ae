import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pilotage.core.grid import OccupancyMap
from pilotage.mapper.laser_grid import MOST_CELLS, LaserGrid
from pilotage.mapper.laser_grid_params import LaserGridParams

PARAMS = LaserGridParams(resolution=1.0, surface_gap=1.5, person_width=1.5)
"""Cells of a metre, so that a drawing is a scan: three cells in a row are no person."""

Seen = tuple[np.ndarray, np.ndarray, np.ndarray]
Scan = tuple[Any, ...]
"""Arguments of `insert`."""

SIGNS = {-1: " ", 0: ".", 100: "#"}


def drawing(world: OccupancyMap, rows: range, cols: range) -> list[str]:
    """The map as text, row 0 of the raster at the bottom, unknown blank."""
    x, y, _ = world.geometry.origin
    row, col = round(y), round(x)
    return [
        "".join(SIGNS[int(world.cells[r - row, c - col])] for c in cols) for r in reversed(rows)
    ]


def grid_of(*scans: Scan, params: LaserGridParams = PARAMS) -> LaserGrid:
    grid = LaserGrid(params)
    for scan in scans:
        grid.insert(*scan)
    return grid


def wall_ahead(cols: range = range(3), row: float = 4.5) -> Seen:
    """A robot in cell (0, 1) that sees a wall across its way."""
    ends = np.array([[col + 0.5, row] for col in cols])
    return np.array([1.5, 0.5]), ends, np.ones(len(ends), bool)


def post(x: float = 1.5, y: float = 3.5) -> Seen:
    """The same robot sees a post, and to its left and right far away."""
    ends = np.array([[-2.5, y + 1.0], [x, y], [5.5, y + 1.0]])
    return np.array([1.5, 0.5]), ends, np.array([False, True, False])


def test_beams_end_on_a_wall_and_leave_free_what_they_cross() -> None:
    grid = grid_of(wall_ahead())
    assert drawing(grid.map(), range(6), range(-1, 4)) == [
        "     ",
        " ### ",
        " ... ",
        " ... ",
        "  .  ",
        "  .  ",
    ]


def test_nothing_is_known_before_the_first_scan() -> None:
    grid = LaserGrid()
    assert grid.map().cells.shape == (0, 0)
    assert grid.log_odds().shape == (0, 0)
    assert grid.changed() is None


def test_a_scan_without_beams_shows_nothing() -> None:
    grid = grid_of((np.zeros(2), np.empty((0, 2)), np.empty(0, bool)))
    assert (grid.map().cells == -1).all()


def test_a_beam_without_a_return_clears_its_cells_and_the_last_too() -> None:
    grid = grid_of((np.array([0.5, 0.5]), np.array([[4.5, 0.5]]), np.array([False])))
    assert drawing(grid.map(), range(2), range(6)) == ["      ", "..... "]


def test_a_hit_is_not_erased_by_a_beam_of_the_same_scan_that_passes_it() -> None:
    origin = np.array([0.5, 0.5])
    ends = np.array([[3.5, 0.5], [2.5, 0.4], [3.5, 0.6]])
    grid = grid_of((origin, ends, np.ones(3, bool)))
    assert grid.log_odds()[grid.map().geometry.cells_of([[2.5, 0.5]])[0][0], 2] == pytest.approx(
        0.85, abs=0.02
    )


def test_a_cell_learns_once_from_a_scan_however_many_beams_cross_it() -> None:
    origin = np.array([0.5, 0.5])
    ends = np.column_stack([np.full(50, 5.5), np.linspace(0.2, 0.8, 50)])
    grid = grid_of((origin, ends, np.zeros(50, bool)))
    assert np.unique(grid.log_odds()[0, :6]) == pytest.approx([-0.3], abs=0.02)


@pytest.mark.parametrize("broken", [math.nan, math.inf, -math.inf])
def test_a_beam_that_ends_nowhere_is_left_out(broken: float) -> None:
    origin, ends, is_hit = wall_ahead()
    worse = np.vstack([ends, [[broken, 4.5], [4.5, broken]]])
    with_it = grid_of((origin, worse, np.ones(5, bool))).map()
    assert (with_it.cells == grid_of((origin, ends, is_hit)).map().cells).all()


def test_a_beam_of_no_length_says_nothing() -> None:
    here = np.array([0.5, 0.5])
    grid = grid_of((here, here[None], np.array([True])))
    assert (grid.map().cells == -1).all()


def test_a_laser_in_the_cell_of_a_wall_clears_that_cell_in_the_end() -> None:
    origin, ends, is_hit = wall_ahead()
    grid = grid_of((origin, ends, is_hit))
    for _ in range(4):
        grid.insert(np.array([1.5, 4.2]), np.array([[1.5, 9.5]]), np.array([False]))
    assert drawing(grid.map(), range(4, 5), range(3)) == ["#.#"]


def test_a_hit_in_the_lasers_own_cell_is_a_hit() -> None:
    grid = grid_of((np.array([0.5, 0.5]), np.array([[0.9, 0.5]]), np.array([True])))
    assert grid.log_odds()[0, 0] > 0.0


def test_a_beam_longer_than_the_longest_is_cut_and_hits_nothing() -> None:
    params = LaserGridParams(resolution=1.0, range_max=3.0)
    scan = np.array([0.5, 0.5]), np.array([[9.5, 0.5]]), np.array([True])
    grid = grid_of(scan, params=params)
    assert drawing(grid.map(), range(1), range(6)) == ["....  "]


def test_what_was_a_wall_is_gone_after_a_few_scans_that_look_through_it() -> None:
    grid = grid_of(*[wall_ahead()] * 50)
    scans = 0
    while grid.map().is_wall.any():
        origin, ends, _ = wall_ahead(row=7.5)
        grid.insert(origin, ends + (ends - origin), np.zeros(3, bool))
        scans += 1
    assert scans == 7


def test_a_new_wall_is_learnt_in_a_few_scans_where_it_was_long_free() -> None:
    origin, ends, _ = wall_ahead(row=7.5)
    grid = grid_of(*[(origin, ends, np.zeros(3, bool))] * 50)
    scans = 0
    while not grid.map().is_wall.any():
        grid.insert(*wall_ahead(row=4.5))
        scans += 1
    assert scans == 4


def test_a_post_is_drawn_once_it_lasted() -> None:
    grid = LaserGrid(PARAMS)
    seen = []
    for stamp in np.arange(0.0, 2.0, 0.25):
        grid.insert(*post(), stamp)
        seen.append(bool(grid.map().is_wall.any()))
    assert seen == [False] * 4 + [True] * 4


def test_a_post_hit_beside_its_cell_lasts_too() -> None:
    """Errors of a pose move a post from cell to cell."""
    grid = LaserGrid(PARAMS)
    for stamp, x in ((0.0, 1.5), (0.3, 2.5), (0.6, 1.5), (1.2, 2.5)):
        grid.insert(*post(x), stamp)
    assert grid.map().is_wall.sum() >= 1


def test_the_laser_may_go_on_instead_of_waiting() -> None:
    grid = LaserGrid(PARAMS)
    for stamp, shift in ((0.0, 0.0), (0.1, 0.1), (0.2, 0.2), (0.3, 0.4), (0.4, 0.6)):
        origin, ends, is_hit = post()
        grid.insert(origin + np.array([0.0, shift]), ends, is_hit, stamp)
    assert grid.map().is_wall.sum() == 1


def test_who_walks_past_leaves_nothing_even_if_nobody_looks_again() -> None:
    grid = LaserGrid(PARAMS)
    for stamp in (0.0, 0.2, 0.4, 0.6):
        grid.insert(*post(x=0.5 + 5.0 * stamp), stamp)
    assert not grid.map().is_wall.any()


def test_who_stood_a_minute_and_left_is_forgotten_in_a_second() -> None:
    grid = LaserGrid(PARAMS)
    for stamp in np.arange(0.0, 60.0, 0.2):
        grid.insert(*post(), stamp)
    assert grid.map().is_wall.any()
    origin, ends, is_hit = post(y=6.5)
    for stamp in np.arange(60.0, 62.0, 0.2):
        grid.insert(origin, ends, is_hit, stamp)
    assert drawing(grid.map(), range(3, 4), range(1, 2)) == ["."]


def test_a_wide_wall_needs_no_second_look() -> None:
    grid = LaserGrid(PARAMS)
    grid.insert(*post(), 0.0)
    grid.insert(*post(), 0.1)
    grid.insert(*wall_ahead(range(4)), 0.2)
    assert drawing(grid.map(), range(4, 5), range(4)) == ["####"]


def test_key_scans_draw_at_once_what_something_nearer_hides_in_part() -> None:
    origin = np.array([1.5, 0.5])
    ends = np.array([[0.5, 2.5], [1.5, 6.5], [3.5, 3.5]])
    grid = grid_of((origin, ends, np.ones(3, bool)))
    assert drawing(grid.map(), range(6, 7), range(3)) == [" # "]


def test_key_scans_draw_a_narrow_thing_when_they_see_it_again() -> None:
    grid = grid_of(post())
    assert not grid.map().is_wall.any()
    grid.insert(*post())
    assert grid.map().is_wall.sum() == 1


def test_a_beam_that_grazes_its_wall_does_not_speak_against_it() -> None:
    """Along the wall ahead of a laser beside it, cells that steeper beams hit stay walls."""
    params = LaserGridParams(resolution=0.1)
    origin = np.array([0.0, 0.55])
    x = np.arange(2.0, 9.0, 0.6)
    ends = np.column_stack([x, np.full(len(x), 0.02)])
    grid = grid_of(*[(origin, ends, np.ones(len(x), bool))] * 3, params=params)
    near_wall = grid.log_odds()[0, 30:72]
    assert not (near_wall < 0.0).any()


def test_the_map_grows_on_every_side_without_moving_its_cells() -> None:
    grid = grid_of(wall_ahead())
    here = np.array([[1.5, 4.5]])
    for shift in ([300.0, 0.0], [0.0, 300.0], [-300.0, 0.0], [0.0, -300.0]):
        origin, ends, is_hit = wall_ahead()
        grid.insert(origin + shift, ends + shift, is_hit)
        world = grid.map()
        assert world.cells[tuple(world.geometry.cells_of(here)[0])] == 100
        assert (np.array(world.geometry.origin[:2]) % 128.0 == 0.0).all()


def test_a_map_handed_out_does_not_change_any_more() -> None:
    grid = grid_of(wall_ahead())
    before = grid.map()
    copy = before.cells.copy()
    for _ in range(9):
        grid.insert(np.array([1.5, 0.5]), np.array([[1.5, 9.5]]), np.array([False]))
    grid.map()
    assert (before.cells == copy).all()


def test_changes_are_told_once() -> None:
    grid = grid_of(wall_ahead())
    window = grid.changed()
    assert window is not None
    assert (window.row, window.col, window.rows, window.cols) == (0, 0, 6, 4)
    assert grid.changed() is None


@pytest.mark.parametrize("origin", [[math.nan, 0.0], [0.0, math.inf], [1e30, 0.0]])
def test_a_scan_from_nowhere_is_refused(origin: list[float]) -> None:
    with pytest.raises(ValueError, match="from nowhere"):
        LaserGrid().insert(origin, [[1.0, 1.0]], [True])


def test_a_pose_gone_wrong_does_not_take_all_memory() -> None:
    origin, ends, is_hit = wall_ahead()
    grid = grid_of((origin, ends, is_hit))
    before = grid.map()
    far = math.sqrt(MOST_CELLS) * 1.1
    with pytest.raises(ValueError, match="is the pose right"):
        grid.insert(origin + far, ends + far, is_hit)
    assert (grid.map().cells == before.cells).all()


def test_ends_and_hits_must_be_as_many() -> None:
    with pytest.raises(ValueError, match="2 ends, but is_hit has 1"):
        LaserGrid().insert([0.0, 0.0], [[1.0, 1.0], [2.0, 1.0]], [True])


@pytest.mark.parametrize(
    "wrong", [{"resolution": 0.0}, {"hit_log_odds": -1.0}, {"lasting_time": math.nan}]
)
def test_params_that_nothing_can_be_drawn_with_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must be a positive number"):
        LaserGridParams(**wrong)


def test_a_limit_below_what_counts_as_occupied_is_refused() -> None:
    with pytest.raises(ValueError, match="limit_log_odds"):
        LaserGridParams(limit_log_odds=0.5)


DAMAGES: dict[str, Callable[[dict[str, np.ndarray]], object]] = {
    "no state of a laser grid": lambda state: state.pop("evidence"),
    "do not fit": lambda state: state.update(since=np.zeros((1, 1), np.int32)),
    "not enough values": lambda state: state.update(clock=np.zeros(2)),
    "too many values": lambda state: state.update(corner=np.zeros(3)),
}


@pytest.mark.parametrize("reason", DAMAGES)
def test_a_state_that_is_none_is_refused(reason: str) -> None:
    state = grid_of(wall_ahead()).state()
    DAMAGES[reason](state)
    with pytest.raises(ValueError, match=reason):
        LaserGrid.from_state(state)


def test_an_empty_grid_can_be_remembered() -> None:
    assert LaserGrid.from_state(LaserGrid().state()).map().cells.shape == (0, 0)
