"""The floors drawn in code, and the files that were drawn from them."""

from pathlib import Path

import numpy as np
import pytest

from pilotage.core.grid import OccupancyMap
from pilotage.core.map_files import load_map
from pilotage.robot.simulator.corridor_plan import corridor_floor
from pilotage.robot.simulator.draw_worlds import write_map
from pilotage.robot.simulator.floor_canvas import FloorCanvas, Room
from pilotage.robot.simulator.floor_plans import office_floor, office_rooms, square_hall
from pilotage.robot.simulator.walls import Walls

MAPS = {
    "hall_map.yaml": square_hall,
    "office_map.yaml": office_floor,
    "corridor_map.yaml": corridor_floor,
}


@pytest.fixture(scope="module")
def office() -> OccupancyMap:
    return office_floor()


@pytest.mark.parametrize("name", MAPS)
def test_committed_map_is_what_the_code_draws(repository: Path, name: str) -> None:
    committed = load_map(repository / "deploy" / "worlds" / name)
    drawn = MAPS[name]()
    renew = "run `python -m pilotage.robot.simulator.draw_worlds deploy/worlds`"
    assert committed.geometry == drawn.geometry, renew
    assert np.array_equal(committed.cells, drawn.cells), renew


@pytest.mark.parametrize("suffix", [".pgm", ".png"])
def test_a_map_that_is_written_loads_back_exactly(tmp_path: Path, suffix: str) -> None:
    hall = square_hall()
    write_map(hall, tmp_path / f"hall{suffix}")
    loaded = load_map(tmp_path / "hall.yaml")
    assert loaded.geometry == hall.geometry
    assert np.array_equal(loaded.cells, hall.cells)


def test_committed_maps_are_small(repository: Path) -> None:
    for file in (repository / "deploy" / "worlds").iterdir():
        assert file.stat().st_size < 50_000, file.name


def test_hall_is_150_cells_square_inside_its_walls() -> None:
    hall = square_hall()
    assert hall.geometry.resolution == 0.10
    assert hall.is_free.sum() == 150 * 150
    assert hall.is_free[1:-1, 1:-1].all()
    lower, upper = hall.geometry.centres_of([[1, 1], [150, 150]])
    assert lower == pytest.approx([0.05, 0.05])
    assert upper == pytest.approx([14.95, 14.95])


def test_office_measures_60_by_40_metres(office: OccupancyMap) -> None:
    rows, cols = np.nonzero(office.is_free)
    extent = office.geometry.centres_of([[rows.min(), cols.min()], [rows.max(), cols.max()]])
    assert extent == pytest.approx(np.array([[0.0, 0.0], [60.0, 40.0]]), abs=0.1)
    assert set(np.unique(office.cells)) == {-1, 0, 100}


def test_no_free_cell_touches_the_unknown(office: OccupancyMap) -> None:
    free, unknown = office.is_free, office.cells < 0
    assert not (free[1:] & unknown[:-1]).any()
    assert not (free[:-1] & unknown[1:]).any()
    assert not (free[:, 1:] & unknown[:, :-1]).any()
    assert not (free[:, :-1] & unknown[:, 1:]).any()


def test_a_robot_can_reach_every_room(office: OccupancyMap) -> None:
    places = Walls.of(office).places(0.165 + 0.2)
    for room in office_rooms():
        x0, y0, x1, y1 = room.box
        x, y = places.T
        inside = (x > x0 + 0.3) & (x < x1 - 0.3) & (y > y0 + 0.3) & (y < y1 - 0.3)
        assert inside.sum() > 200, room.box


def test_some_offices_are_exact_twins(office: OccupancyMap) -> None:
    one, other = (office.cells[690:800, 10 + 80 * i : 88 + 80 * i] for i in (1, 2))
    assert np.array_equal(one, other)


@pytest.mark.parametrize(
    ("places", "facing"),
    [
        ([(x, 3.0) for x in (2.0, 6.0, 10.0, 14.0, 38.0, 42.0, 46.0, 54.0, 58.0)], -np.pi / 2.0),
        ([(4.0, y) for y in (15.0, 19.0, 23.0)], np.pi),
        ([(13.0, y) for y in (16.0, 20.0, 24.0)], 0.0),
    ],
)
def test_a_laser_sees_the_same_in_the_twins_that_the_worlds_file_names(
    office: OccupancyMap, places: list[tuple[float, float]], facing: float
) -> None:
    walls, bearings = Walls.of(office), np.deg2rad(np.linspace(-135.0, 135.0, 271))
    scans = [walls.ranges((x, y, facing), bearings, 12.0) for x, y in places]
    assert len(scans) >= 3
    for scan in scans[1:]:
        assert scan == pytest.approx(scans[0], abs=1e-6)
    assert all(walls.nearest(x, y, 2.0)[0] > 0.3 for x, y in places)


def test_the_floor_as_a_whole_is_not_symmetric(office: OccupancyMap) -> None:
    walls = office.is_wall
    for mirrored in (walls[::-1], walls[:, ::-1], walls[::-1, ::-1]):
        common = (walls & mirrored).sum() / walls.sum()
        assert common < 0.5


def test_a_room_has_the_same_furniture_on_either_side_of_a_corridor() -> None:
    south, north = Room((0, 0, 4, 6), "N"), Room((0, 8, 4, 14), "S")
    assert north.place(0.5, 1.0, 1.5, 2.0) == (0.5, 9.0, 1.5, 10.0)
    assert south.place(0.5, 1.0, 1.5, 2.0) == (2.5, 4.0, 3.5, 5.0)


@pytest.mark.parametrize("side", "NSWE")
def test_what_is_placed_in_a_room_lies_in_it(side: str) -> None:
    room = Room((2.0, 3.0, 6.0, 8.0), side, mirrored=side in "NE")
    x0, y0, x1, y1 = room.place(0.0, 0.0, room.along, room.deep)
    assert (x0, y0, x1, y1) == room.box
    assert sorted((room.along, room.deep)) == [4.0, 5.0]


def test_thin_things_are_at_least_one_cell_thick() -> None:
    canvas = FloorCanvas(1.0, 1.0, 0.1, margin=0.0)
    canvas.solid((0.5, 0.0, 0.501, 1.0))
    assert canvas.to_map().is_wall.sum() == 10


def test_a_column_is_round() -> None:
    canvas = FloorCanvas(2.0, 2.0, 0.05, margin=0.0)
    canvas.round(1.0, 1.0, 0.5)
    area = canvas.to_map().is_wall.sum() * 0.05**2
    assert area == pytest.approx(np.pi * 0.25, rel=0.03)
