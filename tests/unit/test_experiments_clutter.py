"""What a condition changes in a building, and that it is as much as it says."""

import numpy as np
import pytest
from numpy.typing import NDArray

from localizer_world import flat
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.experiments.clutter import CONDITIONS, PIECE_SIDES, Condition, altered
from pilotage.robot.simulator.walls import Walls

WORLD = flat()
CELL_AREA = WORLD.geometry.resolution**2
MIDDLE_PIECE = (sum(PIECE_SIDES) / 2.0) ** 2
"""Mean area of a piece of furniture [m2]."""


def large_hall() -> OccupancyMap:
    """30 m x 20 m with walls all around."""
    cells = np.zeros((200, 300), np.int8)
    cells[[0, -1]] = 100
    cells[:, [0, -1]] = 100
    return OccupancyMap(GridGeometry(200, 300, 0.1), cells)


def changed(condition: Condition, seed: int = 0, world: OccupancyMap = WORLD) -> Walls:
    return altered(world, condition, np.random.default_rng(seed))


def gone(walls: Walls, world: OccupancyMap = WORLD) -> NDArray[np.bool_]:
    return world.is_wall & ~walls.stops_beams


def new(walls: Walls, world: OccupancyMap = WORLD) -> NDArray[np.bool_]:
    return world.is_free & walls.stops_beams


def test_a_clean_building_is_as_its_map_shows_it() -> None:
    walls = changed(CONDITIONS["clean"])
    assert (walls.stops_beams == ~WORLD.is_free).all()
    assert (walls.stops_bodies == walls.stops_beams).all()


def test_what_is_unknown_stops_beams_for_nobody_drew_what_stands_there() -> None:
    cells = WORLD.cells.copy()
    cells[30:34, 60:64] = -1
    world = OccupancyMap(WORLD.geometry, cells)
    walls = changed(CONDITIONS["clean"], world=world)
    assert walls.stops_beams[30:34, 60:64].all()


@pytest.mark.parametrize("share", [0.05, 0.12, 0.3])
def test_the_given_share_of_the_walls_is_gone(share: float) -> None:
    world = large_hall()
    missing = gone(changed(Condition(walls_gone=share), world=world), world)
    actual = missing.sum() / world.is_wall.sum()
    a_gap_at_a_corner = 24.0 / world.is_wall.sum()
    assert share * 0.8 <= actual <= share + a_gap_at_a_corner


def test_walls_that_are_gone_are_put_up_elsewhere_as_panels() -> None:
    world = large_hall()
    walls = changed(Condition(walls_gone=0.2), world=world)
    assert 0.2 < new(walls, world).sum() / gone(walls, world).sum() < 1.5


@pytest.mark.parametrize("piece_area", [13.0, 40.0])
def test_furniture_covers_the_floor_as_densely_as_it_should(piece_area: float) -> None:
    world = large_hall()
    floor = world.is_free.sum() * CELL_AREA
    condition = Condition(piece_area=piece_area)
    covered = [new(changed(condition, seed, world), world).sum() * CELL_AREA for seed in range(5)]
    expected = floor / piece_area * MIDDLE_PIECE
    assert np.mean(covered) == pytest.approx(expected, rel=0.3)
    assert not gone(changed(condition, world=world), world).any()


def test_no_furniture_if_it_has_no_floor_of_its_own() -> None:
    assert not new(changed(Condition(piece_area=np.inf))).any()


def test_badly_drawn_walls_are_thicker_than_the_map_shows_in_places() -> None:
    world = large_hall()
    walls = changed(Condition(rough=0.3), world=world)
    thicker = new(walls, world)
    beside = np.zeros_like(thicker)
    beside[1, 1:-1] = beside[-2, 1:-1] = True
    beside[1:-1, 1] = beside[1:-1, -2] = True
    assert not (thicker & ~beside).any()
    assert thicker.sum() / beside.sum() == pytest.approx(0.3, abs=0.06)


def test_chance_alone_decides_and_repeats_itself() -> None:
    one, again, other = (changed(CONDITIONS["extreme"], seed).stops_beams for seed in (3, 3, 4))
    assert (one == again).all()
    assert (one != other).any()


def test_the_conditions_grow_harder() -> None:
    clean, hard, extreme = (CONDITIONS[name] for name in ("clean", "hard", "extreme"))
    assert clean.people < hard.people < extreme.people
    assert clean.piece_area > hard.piece_area > extreme.piece_area
    assert clean.outliers < hard.outliers < extreme.outliers
    assert clean.odometry < hard.odometry < extreme.odometry
    assert clean.walls_gone == hard.walls_gone == 0.0 < extreme.walls_gone


def test_the_hard_and_the_extreme_case_are_those_of_the_methods() -> None:
    hard, extreme = CONDITIONS["hard"], CONDITIONS["extreme"]
    assert (hard.people, hard.piece_area, hard.outliers, hard.odometry) == (4, 40.0, 0.05, 2.0)
    assert (extreme.people, extreme.piece_area, extreme.outliers) == (10, 13.0, 0.10)
    assert (extreme.walls_gone, extreme.odometry) == (0.12, 3.0)
    assert extreme.laser.range_max == 5.6
    assert np.rad2deg(extreme.laser.field_of_view) == pytest.approx(240.0)
