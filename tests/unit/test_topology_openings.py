"""Doors and passages of drawn maps, and the rooms between them."""

import numpy as np
import pytest

from floor_plans import FLAT, TWO_ROOMS, floor_plan
from pilotage.topology.from_map.building import Building, build
from pilotage.topology.from_map.chords import ChordParams, find_chords
from pilotage.topology.from_map.openings import OpeningParams, find_openings
from pilotage.topology.from_map.rooms import room_at
from pilotage.topology.from_map.space import Space, SpaceParams, space_of

HALL_AND_CORRIDOR = """
    #################################################
    #.................###############################
    #.................###############################
    #.................###############################
    #.................###############################
    #.................###############################
    #.................###############################
    #.................F.............................#
    #...............................................#
    #...............................................#
    #...............................................#
    #...............................................#
    #.................F.............................#
    #.................###############################
    #.................###############################
    #.................###############################
    #.................###############################
    #.................###############################
    #################################################
"""
"""A room of 5.1 m x 5.1 m and a corridor of 9 m x 1.8 m; with F a frame of 1.2 m at its mouth."""

TWO_DOORS = """
    #################################
    #...............#...............#
    #...............#...............#
    #...............................#
    #...............................#
    #...............................#
    #...............#...............#
    #...............#...............#
    #...............#...............#
    #...............#...............#
    #...............#...............#
    #...............................#
    #...............................#
    #...............................#
    #...............#...............#
    #...............#...............#
    #################################
"""

CLOSED_DOOR = TWO_ROOMS.replace(
    "#...............................#", "#...............#...............#"
)

NICHE = """
    ####################
    #...............####
    #...............####
    #...............####
    #...............####
    #..................#
    #..................#
    #..................#
    #..................#
    #...............####
    #...............####
    #...............####
    #...............####
    #...............####
    ####################
"""

TABLE = """
    ##################
    #................#
    #................#
    #................#
    #................#
    #................#
    #.....####.......#
    #.....####.......#
    #.....####.......#
    #................#
    #................#
    #................#
    #................#
    ##################
"""

BED = """
    #################
    #...............#
    #...............#
    #...............#
    #...............#
    #...............#
    #...............#
    #...............#
    #...#####.......#
    #...#####.......#
    #...#####.......#
    #...#####.......#
    #...#####.......#
    #...#####.......#
    #################
"""

GLASS = """
    ###############??????????????..
    #.............#??????????....??
    #.............#???????...??????
    #.............#????...?????????
    #.............#?..?????????????
    #..............????????????????
    #.............#?...????????????
    #.............#????....????????
    #.............#????????....????
    #.............#????????????....
    #.............#????????????????
    ###############????????????????
"""
"""A window at the right: a few beams went through it and far into the street."""

OPEN_PLAN = """
    .........................
    .........................
    .........................
    .........................
    .........................
    .........................
    .........................
    .........................
    .........................
    .........................
    .........................
    .........................
"""


def space(picture: str) -> Space:
    return space_of(floor_plan(picture), SpaceParams())


def doors(building: Building) -> list[tuple[float, float, float]]:
    """Middle and width of each door, from left to right."""
    openings = building.openings
    rows = np.column_stack([openings.chords.middles, openings.chords.widths])[openings.is_door]
    return sorted((float(x), float(y), float(width)) for x, y, width in rows)


def passages(building: Building) -> int:
    return int((~building.openings.is_door).sum())


@pytest.mark.parametrize("cell", [0.1, 0.05])
def test_door_between_two_rooms_is_found_at_its_middle_with_its_width(cell: float) -> None:
    building = build(floor_plan(TWO_ROOMS, cell), "0123")
    ((x, y, width),) = doors(building)
    assert x == pytest.approx(4.95, abs=0.1)
    assert y == pytest.approx(1.95, abs=0.02)
    assert width == pytest.approx(0.9, abs=0.02)
    assert passages(building) == 0
    assert len(building.rooms) == 2


def test_door_is_where_the_map_says_that_it_is_wherever_the_map_lies() -> None:
    cos, sin = np.cos(0.6), np.sin(0.6)
    building = build(floor_plan(TWO_ROOMS, origin=(10.0, -3.0, 0.6)), "0123")
    ((x, y, width),) = doors(building)
    at = 10.0 + cos * 4.95 - sin * 1.95, -3.0 + sin * 4.95 + cos * 1.95
    assert (x, y) == pytest.approx(at, abs=0.12)
    assert width == pytest.approx(0.9, abs=0.02)
    across = building.openings.chords.across[0]
    assert abs(across @ [cos, sin]) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("cell", [0.1, 0.05])
def test_all_doors_of_a_corridor_are_found(cell: float) -> None:
    building = build(floor_plan(FLAT, cell), "0123")
    found = np.array(doors(building))
    assert found[:, 0] == pytest.approx([2.25, 6.45, 10.95], abs=0.03)
    assert found[:, 1] == pytest.approx([1.95] * 3, abs=0.15)
    assert next(room.name for room in building.rooms.values()) == "corridor 1"
    assert len(building.rooms) == 4


def test_door_in_a_corner_of_both_its_rooms_is_found() -> None:
    # Straight ahead it looks along the wall beside it, where the space hardly widens.
    world = floor_plan(CLOSED_DOOR)
    world.cells[4:13, 48:51] = 0
    ((_, y, width),) = doors(build(world, "0123"))
    assert y == pytest.approx(0.85, abs=0.02)
    assert width == pytest.approx(0.9, abs=0.02)


def test_two_doors_to_the_same_room_are_both_found() -> None:
    building = build(floor_plan(TWO_DOORS), "0123")
    heights = [y for _, y, _ in doors(building)]
    assert sorted(heights) == pytest.approx([1.35, 3.75], abs=0.02)
    assert len(building.rooms) == 2


def test_closed_door_is_none() -> None:
    building = build(floor_plan(CLOSED_DOOR), "0123")
    assert doors(building) == []
    assert len(building.rooms) == 2


def test_mouth_of_a_corridor_is_a_passage() -> None:
    building = build(floor_plan(HALL_AND_CORRIDOR.replace("F", ".")), "0123")
    assert doors(building) == []
    assert building.openings.chords.middles[0] == pytest.approx([5.4, 2.7], abs=0.2)
    assert building.openings.chords.widths == pytest.approx([1.8], abs=0.02)
    assert sorted(room.kind for room in building.rooms.values()) == ["corridor", "room"]


def test_mouth_of_a_corridor_with_a_frame_is_a_door() -> None:
    building = build(floor_plan(HALL_AND_CORRIDOR.replace("F", "#")), "0123")
    ((x, y, width),) = doors(building)
    assert (x, y) == pytest.approx((5.55, 2.7), abs=0.15)
    assert width == pytest.approx(1.2, abs=0.02)
    assert passages(building) == 0


def test_niche_is_no_room() -> None:
    assert_one_room_without_openings(build(floor_plan(NICHE), "0123"))


def test_table_that_stands_alone_makes_no_door() -> None:
    assert_one_room_without_openings(build(floor_plan(TABLE), "0123"))


def test_gap_between_a_bed_and_a_wall_is_no_door() -> None:
    assert_one_room_without_openings(build(floor_plan(BED), "0123"))


def test_beams_through_glass_make_no_room() -> None:
    building = build(floor_plan(GLASS), "0123")
    assert_one_room_without_openings(building)
    assert building.rooms[1].area == pytest.approx(3.9 * 3.0, abs=0.1)


def test_map_that_is_free_to_its_rim_is_one_room() -> None:
    assert_one_room_without_openings(build(floor_plan(OPEN_PLAN), "0123"))


def assert_one_room_without_openings(building: Building) -> None:
    assert len(building.openings) == 0
    assert len(building.rooms) == 1
    assert len(building.topology.nodes) > 0


@pytest.mark.parametrize("mark", ["#", "?"])
def test_map_without_free_cells_gives_an_empty_topology(mark: str) -> None:
    building = build(floor_plan((mark * 8 + "\n") * 6), "0123")
    assert building.topology.map_id == "0123"
    assert building.topology.nodes == ()
    assert building.topology.edges == ()
    assert building.rooms == {}
    assert len(building.openings) == 0


def test_opening_that_is_wider_than_the_widest_is_none() -> None:
    narrow = ChordParams(widest=0.8)
    assert len(find_chords(space(TWO_ROOMS), narrow).ends) == 0


def test_gap_that_nothing_drives_through_is_no_opening() -> None:
    broad = ChordParams(narrowest=1.0)
    assert len(find_chords(space(TWO_ROOMS), broad).ends) == 0


def test_chord_lies_on_the_faces_of_the_walls() -> None:
    chords = find_chords(space(TWO_ROOMS), ChordParams())
    assert sorted(chords.ends[0, :, 1]) == pytest.approx([1.5, 2.4])
    assert chords.middles[0, 1] == pytest.approx(1.95)
    assert abs(chords.along[0]) == pytest.approx([0.0, 1.0])
    assert abs(chords.across[0]) == pytest.approx([1.0, 0.0])


def test_room_that_is_smaller_than_asked_for_is_a_niche() -> None:
    plan = space(TWO_ROOMS)
    chords = find_chords(plan, ChordParams())
    assert len(find_openings(plan, chords, OpeningParams(least_room=17.0))) == 1
    assert len(find_openings(plan, chords, OpeningParams(least_room=18.0))) == 0


def test_rooms_of_an_opening_lie_to_its_left_and_to_its_right() -> None:
    plan = space(TWO_ROOMS)
    openings = find_openings(plan, find_chords(plan, ChordParams()), OpeningParams())
    middle, across = openings.chords.middles[0], openings.chords.across[0]
    beside = np.stack([middle + across, middle - across])
    assert room_at(openings, plan, beside).tolist() == openings.rooms[0].tolist()


def test_nothing_outside_of_the_map_is_in_a_room() -> None:
    plan = space(TWO_ROOMS)
    openings = find_openings(plan, find_chords(plan, ChordParams()), OpeningParams())
    points = np.array([[-50.0, 0.0], [0.0, 1e6], [0.1, 0.1]])
    assert room_at(openings, plan, points).tolist() == [0, 0, 0]


def test_names_count_the_largest_room_of_each_kind_first() -> None:
    rooms = list(build(floor_plan(FLAT), "0123").rooms.values())
    assert [room.name for room in rooms] == ["corridor 1", "room 1", "room 2", "room 3"]
    assert rooms[1].area > rooms[2].area >= rooms[3].area
    assert rooms[1].width == pytest.approx(2.7, abs=0.25)


def test_large_room_is_a_hall() -> None:
    building = build(floor_plan(("." * 40 + "\n") * 32), "0123")
    assert [room.name for room in building.rooms.values()] == ["hall 1"]
    assert building.rooms[1].area == pytest.approx(12.0 * 9.6, abs=0.5)


def test_house_that_is_smaller_than_a_table_is_no_furniture() -> None:
    hut = floor_plan(
        """
        ########
        #......#
        #......#
        #......#
        #......#
        #......#
        #......#
        ########
        """
    )
    params = SpaceParams(least_area=2.0)
    is_free = space_of(hut, params).is_free
    assert is_free[1:-1, 1:-1].tolist() == hut.is_free.tolist()
