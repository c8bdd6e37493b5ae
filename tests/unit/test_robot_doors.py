"""Doors of simulated worlds: their entries in files, and their leaves among the walls."""

from pathlib import Path

import numpy as np
import pytest

from drawing import draw
from pilotage.bus.deployment import ConfigError
from pilotage.robot.simulator.config import open_world, read_world
from pilotage.robot.simulator.corridor_plan import corridor_doors, corridor_floor
from pilotage.robot.simulator.doors import (
    AJAR,
    Door,
    DoorFileError,
    Doors,
    doors_of,
    read_doors,
)
from pilotage.robot.simulator.draw_worlds import write_list, write_map
from pilotage.robot.simulator.floor_plans import office_floor
from pilotage.robot.simulator.office_doors import office_doors
from pilotage.robot.simulator.walls import Walls

WALL_WITH_A_GAP = draw(
    """
    ..........
    ..........
    ..........
    ###....###
    ###....###
    ..........
    ..........
    ..........
    """,
    resolution=0.25,
)
"""A wall from y = 0.75 to 1.25 with an opening from x = 0.75 to 1.75."""

ENDS = ((0.75, 1.125), (1.75, 1.125))
NORTH = float(np.pi / 2.0)


def walls(state: str) -> Walls:
    door = {"ends": [list(end) for end in ENDS], "state": state}
    return Walls.of(WALL_WITH_A_GAP, (), doors_of([door]))


def test_through_an_open_door_beams_and_bodies_pass() -> None:
    world = walls("open")
    assert world.ranges((1.25, 0.1, NORTH), [0.0], 5.0) == np.inf
    assert not world.overlaps(1.25, 1.0, 0.2)


def test_a_closed_leaf_stops_both_and_stands_back_from_the_face_of_its_wall() -> None:
    world = walls("closed")
    for x in np.arange(0.8, 1.75, 0.1):
        assert world.ranges((x, 0.1, NORTH), [0.0], 5.0) == pytest.approx(0.9)
    assert world.overlaps(1.25, 1.0, 0.2)
    assert world.ranges((0.5, 0.1, NORTH), [0.0], 5.0) == pytest.approx(0.65)


def test_a_leaf_that_is_ajar_hangs_at_its_first_end_and_opens_to_the_left() -> None:
    leaf = Door(ENDS, "ajar").hung
    assert leaf is not None
    assert leaf[0] == pytest.approx(ENDS[0])
    assert leaf[1] == pytest.approx((0.75 + np.cos(AJAR), 1.125 + np.sin(AJAR)))


def test_a_leaf_that_is_ajar_leaves_a_way_past_its_end() -> None:
    floor = draw("\n".join(["." * 60] * 60), resolution=0.05)
    world = Walls.of(floor, (), Doors((Door(ENDS, "ajar"),)))
    assert world.ranges((1.7, 0.1, NORTH), [0.0], 5.0) == np.inf
    assert world.ranges((1.0, 0.1, NORTH), [0.0], 5.0) == pytest.approx(1.2, abs=0.06)
    assert world.ranges((1.5, 0.1, NORTH), [0.0], 5.0) == pytest.approx(1.54, abs=0.06)


def test_no_beam_slips_through_a_leaf_that_stands_askew() -> None:
    world = draw("\n".join(["." * 60] * 60), resolution=0.05)
    leaf = doors_of([{"ends": [[0.6, 1.2], [2.4, 1.9]], "state": "closed", "leaf": 0.05}])
    closed = Walls.of(world, (), leaf)
    beams = np.linspace(-0.4, 0.4, 400)
    assert np.isfinite(closed.ranges((1.7, 0.3, NORTH), beams, 5.0)).all()


def test_a_thick_leaf_fills_more_cells_than_a_thin_one() -> None:
    world = draw("\n".join(["." * 60] * 60), resolution=0.05)
    thin, thick = (
        Walls.of(world, (), Doors((Door(((0.5, 1.52), (1.5, 1.52)), "closed", leaf),)))
        for leaf in (0.05, 0.2)
    )
    assert thick.stops_beams.sum() == pytest.approx(4 * thin.stops_beams.sum(), rel=0.1)


def test_the_jambs_of_all_doors_and_the_leaves_that_hang_in_the_way_are_told() -> None:
    doors = Doors((Door(ENDS), Door(ENDS, "closed")))
    assert doors.jambs.shape == (2, 2, 2)
    assert doors.leaves == pytest.approx(np.array([ENDS]))
    assert Doors().jambs.shape == (0, 2, 2)
    assert Doors().leaves.shape == (0, 2, 2)


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        (3, "door 1 must be a mapping with ends, not 3"),
        ({}, "door 1 must be a mapping with ends"),
        ({"ends": [[0, 0], [1, 0]], "colour": 3}, "door 1: unknown key 'colour'"),
        ({"ends": [[0, 0], [1, 0]], "state": "stuck"}, "door 1: state must be one of open, closed"),
        ({"ends": [[0, 0], [1, 0]], "leaf": 0.5}, "door 1: leaf must be a thickness of at most"),
        ({"ends": [[0, 0], [1, 0]], "leaf": True}, "door 1: leaf must be a thickness of at most"),
        ({"ends": [[0, 0]]}, "door 1: ends must be two points"),
        ({"ends": [[0, 0], [1, float("nan")]]}, "door 1: its ends must be finite"),
        ({"ends": [[0, 0], ["a", 1]]}, "door 1: ends must be two points"),
        ({"ends": [[0, 0], [0.1, 0]]}, "door 1: its ends lie nearer than 0.3 m"),
    ],
)
def test_an_entry_that_is_no_door_is_refused_with_the_reason(entry: object, reason: str) -> None:
    with pytest.raises(ValueError, match=r"^" + reason.replace("'", ".")):
        doors_of([entry])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("doors: {a: 1}", "a list 'doors' is needed"),
        ("doors: []\nmore: 1", "a list 'doors' is needed"),
        ("[1, 2]", "a list 'doors' is needed"),
        ("doors: [", "not readable as YAML"),
        ("doors: [3]", "door 1 must be a mapping"),
    ],
)
def test_a_file_without_doors_is_refused_with_the_reason(
    tmp_path: Path, text: str, reason: str
) -> None:
    file = tmp_path / "doors.yaml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(DoorFileError, match=reason):
        read_doors(file)


def test_a_file_that_is_missing_is_refused_with_its_name(tmp_path: Path) -> None:
    with pytest.raises(DoorFileError, match=r"none.yaml: No such file"):
        read_doors(tmp_path / "none.yaml")


def test_doors_that_are_written_are_read_back(tmp_path: Path) -> None:
    write_list("doors", corridor_doors(), tmp_path / "doors.yaml")
    assert read_doors(tmp_path / "doors.yaml") == doors_of(corridor_doors())


@pytest.fixture
def world_file(tmp_path: Path) -> Path:
    write_map(WALL_WITH_A_GAP, tmp_path / "map.pgm")
    return tmp_path / "world.yaml"


def test_a_world_file_holds_its_doors_or_names_a_file_of_them(world_file: Path) -> None:
    listed = "map: map.yaml\ndoors: [{ends: [[0.75, 1.125], [1.75, 1.125]], state: closed}]\n"
    world_file.write_text(listed, encoding="utf-8")
    closed = read_world(world_file).doors
    assert closed == Doors((Door(ENDS, "closed"),))
    write_list("doors", [{"ends": [[0.75, 1.125], [1.75, 1.125]]}], world_file.parent / "d.yaml")
    world_file.write_text("map: map.yaml\ndoors: d.yaml\n", encoding="utf-8")
    assert read_world(world_file).doors == Doors((Door(ENDS),))


@pytest.mark.parametrize(
    ("doors", "reason"),
    [
        ("7", "doors: .*it must be a list of doors or a file with one"),
        ("[7]", "doors: .*door 1 must be a mapping"),
        ("none.yaml", "doors: .*No such file"),
        ("[{ends: [[0.5, 1], [9, 1]]}]", r"doors: door 1 at \(4.75, 1\) lies outside of the map"),
    ],
)
def test_a_world_with_doors_that_cannot_be_is_refused_in_one_line(
    world_file: Path, doors: str, reason: str
) -> None:
    world_file.write_text(f"map: map.yaml\nstart: [1, 0.3, 0]\ndoors: {doors}\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=reason) as refused:
        open_world(world_file)
    assert "\n" not in str(refused.value)


def test_every_door_of_the_corridor_lies_in_an_opening_between_two_pieces_of_wall() -> None:
    floor = corridor_floor()
    doors = doors_of(corridor_doors())
    assert len(doors) == 16
    for first, second in doors.jambs:
        along = (second - first) / np.hypot(*(second - first))
        beside = np.array([first - 0.1 * along, second + 0.1 * along])
        between = first + np.linspace(0.1, 0.9, 9)[:, None] * (second - first)
        assert floor.is_wall[tuple(floor.geometry.cells_of(beside).T)].all()
        assert floor.is_free[tuple(floor.geometry.cells_of(between).T)].all()


def test_every_door_of_the_office_lies_in_an_opening_between_two_pieces_of_wall() -> None:
    floor = office_floor()
    doors = doors_of(office_doors())
    assert len(doors) == 52
    for first, second in doors.jambs:
        between = first + np.linspace(0.1, 0.9, 9)[:, None] * (second - first)
        assert floor.is_free[tuple(floor.geometry.cells_of(between).T)].all()
        along = (second - first) / np.hypot(*(second - first))
        across = np.array([-along[1], along[0]])
        for jamb, outwards in ((first, -along), (second, along)):
            near = jamb + 0.05 * outwards + np.array([[-0.02], [0.02]]) * across
            assert floor.is_wall[tuple(floor.geometry.cells_of(near).T)].all(), (first, second)


@pytest.mark.parametrize("name", ["corridor", "office"])
def test_committed_doors_are_what_the_code_draws(repository: Path, name: str) -> None:
    committed = read_doors(repository / "deploy" / "worlds" / f"{name}_doors.yaml")
    drawn = doors_of(corridor_doors() if name == "corridor" else office_doors())
    renew = "run `python -m pilotage.robot.simulator.draw_worlds deploy/worlds`"
    assert committed == drawn, renew


def test_closed_doors_of_the_corridor_stand_back_by_ten_centimetres_or_are_flush() -> None:
    world = Walls.of(corridor_floor(), (), doors_of(corridor_doors()))
    recesses = []
    for door in world.doors.doors:
        if door.state == "closed":
            x = float(door.jambs[:, 0].mean())
            side = NORTH if door.jambs[0, 1] > 5.9 else -NORTH
            recesses.append(float(world.ranges((x, 5.9, side), [0.0], 5.0)[0]) - 1.2)
    assert sorted(set(np.round(recesses, 3))) == [0.0, 0.1]


def test_a_robot_can_reach_the_rooms_whose_doors_are_open_and_no_others() -> None:
    world = Walls.of(corridor_floor(), (), doors_of(corridor_doors()))
    places = world.places(0.165 + 0.15)
    x, y = places.T
    is_inside = {
        (side, number): bool(((x // 4 == number) & (x % 4 > 0.5) & (x % 4 < 3.5) & where).any())
        for side, where in (("south", y < 3.5), ("north", (y > 8.0) & (y < 11.0)))
        for number in range(8)
    }
    assert is_inside["south", 1]
    assert is_inside["north", 0]
    assert not is_inside["south", 0]
    assert not is_inside["north", 5]
