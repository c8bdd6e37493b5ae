"""Symmetric places: their images, what a walk shows there, and what is reported of it."""

import json
import math
from typing import Any

import numpy as np
import pytest

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.experiments import symmetric_walk
from pilotage.experiments.corridor_floor import MIDDLE, corridor_floor
from pilotage.experiments.outcome import Request
from pilotage.experiments.plots import mode_figure, walk_figure
from pilotage.experiments.ranger_localizer import Place, RangerLocalizer, RangerModel, survey
from pilotage.experiments.ranger_robot import RobotParams, on_a_bin, random_goals
from pilotage.experiments.repeated_walks import repeated_walks
from pilotage.experiments.symmetric_walk import (
    Route,
    Symmetry,
    Walk,
    errors,
    spread_of_masses,
    walk,
)
from pilotage.experiments.symmetry_report import symmetry_report
from pilotage.localizer.modes import Mode
from pilotage.robot.simulator.floor_plans import square_hall

CELL, SIZE, METRES = 0.10, 3.0, 4
MODEL = RangerModel(robot=RobotParams(range_max=5.0))


def room(width: float, height: float) -> OccupancyMap:
    """A featureless room with its inner corner at the origin."""
    cells = np.full((round(height / CELL) + 2, round(width / CELL) + 2), 100, np.int8)
    cells[1:-1, 1:-1] = 0
    return OccupancyMap(GridGeometry(*cells.shape, CELL, (-CELL, -CELL, 0.0)), cells)


def walked(width: float, height: float) -> tuple[Place, Walk]:
    place = survey(room(width, height), MODEL)
    rng = np.random.default_rng(3)
    start = on_a_bin(0.9, 0.7, 0.5)
    goals = random_goals((0.6, 0.6), (width - 0.6, height - 0.6), rng)
    return place, walk(place, MODEL, Route(start, goals, METRES), rng, lambda: None)


@pytest.fixture(scope="module")
def square() -> tuple[Place, Walk]:
    return walked(SIZE, SIZE)


def reported(walks: list[Walk], symmetry: Symmetry, settled_m: int) -> dict[str, Any]:
    return symmetry_report(walks, symmetry, settled_m)


def mode(mass: float, *pose: float) -> Mode:
    return Mode(mass, np.array(pose), np.eye(3))


def test_the_images_of_a_pose_lie_round_the_middle() -> None:
    images = Symmetry(4, (7.5, 7.5)).images(np.array([9.5, 7.5, 0.0]))
    expected = [
        [9.5, 7.5, 0.0],
        [7.5, 9.5, math.pi / 2],
        [5.5, 7.5, -math.pi],
        [7.5, 5.5, -math.pi / 2],
    ]
    assert images == pytest.approx(np.array(expected))


def test_without_symmetry_a_pose_is_its_only_image() -> None:
    pose = np.array([1.0, 2.0, 3.0])
    assert Symmetry(1, (4.0, 5.0)).images(pose) == pytest.approx(pose[None])


def test_every_image_is_told_from_the_next_by_its_heading_even_in_the_middle() -> None:
    images = Symmetry(4, (0.0, 0.0)).images(np.array([0.01, 0.0, 0.3]))
    modes = [mode(0.25, *image) for image in images]
    assert errors(modes, images) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_the_error_is_that_of_the_image_that_is_met_worst() -> None:
    modes = [mode(0.5, 0.0, 0.0, 0.0), mode(0.5, 4.0, 0.3, 0.1)]
    distance, turn = errors(modes, np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]]))
    assert (distance, turn) == pytest.approx((0.3, 0.1))


def test_the_spread_of_masses_is_a_share_of_their_mean() -> None:
    assert spread_of_masses([mode(0.25, 0, 0, 0)] * 4) == 0.0
    assert spread_of_masses([mode(0.6, 0, 0, 0), mode(0.4, 0, 0, 0)]) == pytest.approx(0.2)


def test_the_papers_hall_has_its_1_620_000_states() -> None:
    hall = square_hall()
    assert int(hall.is_free.sum()) * 72 == 1_620_000


def test_a_walk_is_shown_after_every_metre(square: tuple[Place, Walk]) -> None:
    _, shown = square
    for said in (shown.without_compass, shown.with_compass):
        assert len(said) == METRES
        for place in said:
            assert place.marginal.sum() == pytest.approx(1.0, abs=1e-3)
            assert any(np.array_equal(place.truth, pose) for pose in shown.path)


def test_a_walk_tells_of_every_metre() -> None:
    place = survey(room(2.0, 2.0), MODEL)
    rng = np.random.default_rng(0)
    told: list[None] = []
    route = Route(on_a_bin(1.0, 1.0, 0.0), random_goals((0.6, 0.6), (1.4, 1.4), rng), 2)
    walk(place, MODEL, route, rng, lambda: told.append(None))
    assert len(told) == 2


def test_a_square_room_holds_four_equal_modes_and_the_compass_one(
    square: tuple[Place, Walk],
) -> None:
    report = reported([square[1]], Symmetry(4, (SIZE / 2, SIZE / 2)), settled_m=1)
    without, compass = report["without_compass"], report["with_compass"]
    assert without["modes"] == [4] * METRES
    assert without["equal_within_5_percent"]
    assert without["error_m"] < 2.0 * CELL
    assert 0.0 <= without["mass_elsewhere"] < 0.02
    assert compass["modes"] == [1] * METRES
    assert compass["within_a_cell_and_a_bin"]


def test_an_oblong_room_holds_two_equal_modes_and_the_compass_one() -> None:
    _, shown = walked(4.0, 2.0)
    report = reported([shown], Symmetry(2, (2.0, 1.0)), settled_m=2)
    assert report["without_compass"]["always_as_expected"]
    assert report["without_compass"]["mass_spread"] < 0.05
    assert report["with_compass"]["always_as_expected"]


def test_the_report_of_several_walks_has_them_one_after_another(
    square: tuple[Place, Walk],
) -> None:
    report = reported([square[1]] * 3, Symmetry(4, (SIZE / 2, SIZE / 2)), settled_m=2)
    assert len(report["without_compass"]["modes"]) == 3 * METRES
    assert len(report["without_compass"]["errors_m"]) == 3 * (METRES - 1)
    json.dumps(report, allow_nan=False)


def test_what_differs_from_the_claim_is_said(square: tuple[Place, Walk]) -> None:
    report = reported([square[1]], Symmetry(2, (SIZE / 2, SIZE / 2)), settled_m=1)
    assert not report["without_compass"]["always_as_expected"]


def test_the_floor_with_the_corridor_looks_alike_after_half_a_turn() -> None:
    world = corridor_floor()
    assert np.array_equal(world.cells, np.flip(world.cells))
    x, y, _ = world.geometry.origin
    width, height = world.geometry.size_m
    assert (x + width / 2.0, y + height / 2.0) == pytest.approx(MIDDLE)


def test_the_floor_with_the_corridor_has_no_other_symmetry() -> None:
    cells = corridor_floor().cells
    assert not np.array_equal(cells, cells[::-1])
    assert not np.array_equal(cells, cells[:, ::-1])


def test_the_plots_show_the_place_the_path_and_the_modes(square: tuple[Place, Walk]) -> None:
    place, shown = square
    figure = walk_figure(place, shown, "Room")
    titles = [axes.get_title() for axes in figure.axes]
    assert titles == [
        "without compass: 4 most probable poses after every metre",
        "with compass: 1 most probable pose after every metre",
    ]
    for axes in figure.axes:
        assert len(axes.images) == 2
        assert axes.get_legend_handles_labels()[1] == ["true path", "modes"]


def test_a_wide_place_is_drawn_one_condition_above_the_other() -> None:
    place, shown = walked(4.0, 2.0)
    upper, lower = walk_figure(place, shown, "Room").axes
    assert upper.get_position().y0 >= lower.get_position().y0


def test_the_plot_of_modes_has_every_mode(square: tuple[Place, Walk]) -> None:
    figure = mode_figure(square[1], Symmetry(4, (SIZE / 2, SIZE / 2)))
    masses = figure.axes[0].collections
    assert [len(np.array(points.get_offsets())) for points in masses] == [4 * METRES, METRES]


def test_a_metre_is_ten_steps() -> None:
    assert symmetric_walk.STEPS_PER_METRE == 10


def test_a_place_that_holds_next_to_nothing_is_no_mode() -> None:
    place = survey(room(2.0, 2.0), MODEL)
    localizer = RangerLocalizer(place, MODEL, "m2", has_compass=True)
    here, there = [0.5, 0.5, 0.0], [1.5, 1.5, 1.0]
    for weights, count in (([0.995, 0.004], 1), ([0.9, 0.1], 2)):
        localizer.grid.set_states(np.array([here, there]), np.array(weights))
        assert len(localizer.modes()) == count


def test_every_run_has_chances_of_its_own_and_its_share_of_the_progress() -> None:
    place, said = survey(room(2.0, 2.0), MODEL), list[float]()

    def route(rng: np.random.Generator) -> Route:
        corner = (0.6, 0.6), (1.4, 1.4)
        x, y = rng.uniform(*corner)
        return Route(on_a_bin(x, y, 0.0), random_goals(*corner, rng), 1)

    one, other = repeated_walks(place, MODEL, route, Request(2, seed=4), said.append)
    assert not np.array_equal(one.path[0], other.path[0])
    assert said == [0.5, 0.5]
    again = repeated_walks(place, MODEL, route, Request(1, seed=4), said.append)
    assert np.array_equal(again[0].path, one.path), "the seed and the run settle everything"
