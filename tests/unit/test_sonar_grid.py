import math

import numpy as np
import pytest

from drawing import draw
from pilotage.core.grid import OccupancyMap
from pilotage.mapper.cell_layers import CellLayers
from pilotage.mapper.sonar_grid import SonarGrid, SonarGridParams, filtered
from pilotage.mapper.sonar_models import KERNEL_OF
from pilotage.mapper.sonar_news import SonarNewsParams
from pilotage.mapper.sonar_ring import SonarRing
from pilotage.mapper.temporal_filter import FREE_VOTE, OCCUPIED_VOTE, UNDECIDED, verdict
from sonar_world import along, hear, ring_of

HALL = draw(
    """
    ##############################
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    ##############################
    """,
    resolution=0.1,
)
OPENING = draw(
    """
    ##############################
    #............................#
    #............................#
    #............................#
    #............................#
    #############....#############
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    #............................#
    ##############################
    """,
    resolution=0.1,
)
MODELS = sorted(KERNEL_OF)
MORCS = ring_of(*np.radians([90.0, 44.0, 12.0, -12.0, -44.0, -90.0, -144.0, 144.0]))
AHEAD = ring_of(0.0)
ORIGIN = np.zeros(3)


def value_at(world: OccupancyMap, x: float, y: float) -> int:
    row, col = world.geometry.cells_of([[x, y]])[0]
    inside = 0 <= row < world.geometry.rows and 0 <= col < world.geometry.cols
    return int(world.cells[row, col]) if inside else -1


def grid_of(model: str, ring: SonarRing = AHEAD, **params: object) -> SonarGrid:
    return SonarGrid(SonarGridParams(**params), ring, model)  # type: ignore[arg-type]  # given by name in tests


def passed(model: str, world: OccupancyMap, poses: np.ndarray) -> OccupancyMap:
    """What a model makes of a drive."""
    grid = grid_of(model, MORCS)
    for pose in poses:
        grid.insert(pose, hear(world, pose, MORCS))
    return grid.map()


@pytest.mark.parametrize("model", MODELS)
def test_the_way_to_the_echo_is_free_and_the_echo_is_not(model: str) -> None:
    grid = grid_of(model)
    for nudge in 0.03 * np.arange(9):
        grid.insert([nudge, 0.0, 0.0], [1.02 - nudge])
    world = grid.map()
    assert 0 <= value_at(world, 0.5, 0.01) < 30
    assert value_at(world, 1.02, 0.01) > 50
    assert value_at(world, 1.4, 0.01) == -1
    assert value_at(world, -0.3, 0.01) == -1


@pytest.mark.parametrize("model", ["bayes", "improved_atm"])
def test_a_hall_is_free_inside_and_has_walls_along_its_sides(model: str) -> None:
    world = passed(model, HALL, along((0.6, 0.4), (2.4, 0.4), 60))
    assert all(0 <= value_at(world, x, 0.42) < 20 for x in np.arange(0.7, 2.3, 0.1))
    below = [max(value_at(world, x, y) for y in (0.03, 0.08)) for x in np.arange(0.8, 2.2, 0.05)]
    assert np.mean(np.array(below) >= 65) > 0.9


def test_arc_transversal_methods_leave_an_opening_open() -> None:
    poses = along((0.5, 0.4), (2.5, 0.4), 80)
    opening = np.arange(1.36, 1.66, 0.05)

    def clogged(model: str) -> float:
        world = passed(model, OPENING, poses)
        return float(np.mean([value_at(world, x, y) >= 65 for x in opening for y in (0.82, 0.88)]))

    assert clogged("improved_atm") <= clogged("atm") <= clogged("bayes")
    assert clogged("improved_atm") == 0.0


def test_nothing_is_heard_while_the_robot_turns() -> None:
    grid = grid_of("bayes")
    grid.insert(ORIGIN, [1.0], is_turning=True)
    assert (grid.map().cells == -1).all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 0.0, 0.05, -1.0, 2.5])
@pytest.mark.parametrize("model", MODELS)
def test_readings_that_are_no_use_leave_no_trace(model: str, bad: float) -> None:
    grid = grid_of(model)
    grid.insert(ORIGIN, [bad])
    grid.insert([0.1, 0.0, 0.0], [bad])
    assert (grid.map().cells == -1).all()


@pytest.mark.parametrize("model", MODELS)
def test_a_ring_without_sonars_knows_nothing(model: str) -> None:
    grid = grid_of(model, ring_of())
    grid.insert(ORIGIN, [])
    assert grid.map().cells.tolist() == [[-1]]
    assert len(grid.crossings().points) == 0


def test_a_round_must_fit_the_ring() -> None:
    with pytest.raises(ValueError, match="do not fit 1 sonars"):
        grid_of("bayes").insert(ORIGIN, [1.0, 2.0])


@pytest.mark.parametrize(
    ("cone", "range_max"), [(0.0, 4.0), (4.0, 4.0), (0.4, 0.0), (0.4, math.inf)]
)
def test_impossible_rings_are_refused(cone: float, range_max: float) -> None:
    with pytest.raises(ValueError, match=r"cone|range"):
        SonarRing(np.zeros((1, 3)), cone, range_max)


def test_mounts_must_be_poses() -> None:
    with pytest.raises(ValueError, match="mounts"):
        SonarRing(np.zeros((2, 2)), 0.4, 4.0)


def test_standing_still_makes_nothing_surer() -> None:
    once, often = grid_of("bayes"), grid_of("bayes")
    once.insert(ORIGIN, [1.0])
    for _ in range(50):
        often.insert(ORIGIN, [1.0])
    assert np.array_equal(once.map().cells, often.map().cells)


def test_a_standing_robot_sees_a_door_open() -> None:
    grid = grid_of("bayes")
    grid.insert(ORIGIN, [1.0])
    grid.insert(ORIGIN, [1.9])
    assert value_at(grid.map(), 1.0, 0.01) < 50


def test_the_thesis_keeps_readings_up_to_a_metre() -> None:
    grid = grid_of("bayes", news=SonarNewsParams(use_up_to=1.0))
    grid.insert(ORIGIN, [1.01])
    assert (grid.map().cells == -1).all()
    grid.insert(ORIGIN, [0.99])
    assert (grid.map().cells >= 0).any()


def test_a_changed_world_is_believed_in_the_end() -> None:
    grid = grid_of("bayes")
    for step in range(300):
        grid.insert([0.0, 0.03 * (step % 2), 0.0], [1.5])
    for step in range(30):
        grid.insert([0.0, 0.03 * (step % 2), 0.0], [1.0])
    assert value_at(grid.map(), 1.0, 0.01) > 65


def test_the_edge_of_a_cone_stays_unknown() -> None:
    grid = grid_of("bayes")
    grid.insert(ORIGIN, [1.5])
    world = grid.map()
    assert 0 <= value_at(world, 1.0, 0.0) < 35
    assert value_at(world, 1.0 * math.cos(0.21), math.sin(0.21)) == -1


def test_another_ring_may_take_over() -> None:
    grid = grid_of("bayes")
    grid.insert(ORIGIN, [1.0])
    grid.use_ring(ring_of(math.pi / 2.0, -math.pi / 2.0))
    grid.insert(ORIGIN, [1.0, np.inf])
    world = grid.map()
    assert value_at(world, 0.99, 0.01) > 50
    assert value_at(world, 0.01, 0.99) > 50


@pytest.mark.parametrize("model", ["bayes", "improved_atm"])
def test_a_grid_goes_on_where_it_was(model: str) -> None:
    poses = along((0.6, 0.4), (2.4, 0.4), 60)
    whole, before, after = (grid_of(model, MORCS) for _ in range(3))
    for number, pose in enumerate(poses):
        heard = hear(HALL, pose, MORCS)
        whole.insert(pose, heard)
        if number == 30:
            after.resume(before.remember())
        (before if number < 30 else after).insert(pose, heard)
    assert np.abs(whole.map().cells.astype(int) - after.map().cells).max() <= 1


@pytest.mark.parametrize("missing", ["log_odds", "first", "arcs", "votes"])
def test_a_memory_that_lacks_something_is_refused(missing: str) -> None:
    memory = grid_of("atm").remember()
    del memory[missing]
    with pytest.raises(ValueError, match="lacks"):
        grid_of("atm").resume(memory)


def test_a_memory_of_other_layers_is_refused() -> None:
    grid = grid_of("atm")
    grid.insert(ORIGIN, [1.0])
    memory = grid.remember()
    with pytest.raises(ValueError, match="no layer"):
        grid_of("atm").resume({**memory, "votes": np.zeros((3, 3))})
    with pytest.raises(ValueError, match="no echoes"):
        grid_of("atm").resume({**memory, "arcs": np.zeros((3, 3))})


@pytest.mark.parametrize("chunk", [1, 7, 64])
def test_cells_keep_their_place_however_the_grid_grows(chunk: int) -> None:
    layers = CellLayers(0.1, chunk)
    marks = [(0.25, 0.35), (-3.05, 0.35), (4.95, -7.15), (0.25, 9.05)]
    for x, y in marks:
        assert layers.cover((x, x, y, y))
        layers.log_odds[layers.window((x, x, y, y))] += 1.0
    rows_cols = np.argwhere(layers.log_odds)
    centres = {(round(x, 2), round(y, 2)) for x, y in layers.geometry.centres_of(rows_cols)}
    assert centres == set(marks)


def test_a_place_that_is_too_far_away_is_left_out() -> None:
    grid = grid_of("bayes")
    grid.insert(ORIGIN, [1.0])
    grid.insert([1e6, 1e6, 0.0], [1.0])
    world = grid.map()
    assert world.geometry.size_m[0] < 20.0
    assert value_at(world, 0.99, 0.01) > 50


@pytest.mark.parametrize("votes", [0b000, 0b001, 0b010, 0b100])
def test_slices_that_say_free(votes: int) -> None:
    assert verdict(votes, 3) == FREE_VOTE


@pytest.mark.parametrize("votes", [0b011, 0b110, 0b111])
def test_slices_that_say_occupied(votes: int) -> None:
    assert verdict(votes, 3) == OCCUPIED_VOTE


def test_five_slices_decide_about_101() -> None:
    assert verdict(0b101, 3) == UNDECIDED
    assert verdict(0b00101, 5) == FREE_VOTE
    assert verdict(0b01101, 5) == OCCUPIED_VOTE
    assert verdict(0b11101, 5) == OCCUPIED_VOTE


def test_a_cell_that_only_alternates_is_noise() -> None:
    assert verdict(0b10101010, 8) == FREE_VOTE
    assert verdict(0b01010101, 8) == FREE_VOTE


def test_two_slices_decide_nothing() -> None:
    assert verdict(0b11, 2) == UNDECIDED


def test_the_filter_overrules_and_leaves_doubt() -> None:
    cells = np.array([[90, 90, 10, 10]], np.int8)
    verdicts = np.array([[FREE_VOTE, UNDECIDED, OCCUPIED_VOTE, UNDECIDED]], np.uint8)
    assert filtered(cells, verdicts).tolist() == [[35, 90, 65, 10]]


def test_noise_of_one_slice_is_filtered_away() -> None:
    grid = grid_of("centre_line", temporal_filter=True, slice_rounds=1)
    for step in range(8):
        grid.insert([0.0, 0.03 * (step % 2), 0.0], [0.6 if step == 5 else 1.5])
    assert value_at(grid.map(), 0.6, 0.01) < 50
