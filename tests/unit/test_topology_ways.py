"""Ways between the nodes of drawn maps."""

import numpy as np
import pytest
from numpy.typing import NDArray

from floor_plans import FLAT, TWO_ROOMS, floor_plan
from pilotage.core.grid import OccupancyMap
from pilotage.topology.from_map.building import build, build_topology
from pilotage.topology.from_map.ground import GroundParams, cell_costs
from pilotage.topology.from_map.space import drivable_space
from pilotage.topology.from_map.ways import Gates, Way, find_ways

Place = tuple[float, float]

TABLE_IN_THE_WAY = """
    #################################
    #...............................#
    #...............................#
    #...............................#
    #...............................#
    #..............###..............#
    #..............###..............#
    #..............###..............#
    #...............................#
    #...............................#
    #################################
"""

SEALED = """
    ############################
    #............#.............#
    #............#.............#
    #............#.............#
    #............#.............#
    #............#.............#
    #............#.............#
    #............#.............#
    #............#.............#
    ############################
"""


def ways_between(world: OccupancyMap, *places: Place) -> list[Way]:
    ground = drivable_space(world)
    cells = ground.geometry.cells_of(np.array(places))
    gates = Gates.none(len(cells), ground)
    return find_ways(ground, cells, cell_costs(ground, GroundParams()), gates)


def ends_of(ways: list[Way]) -> list[tuple[int, int]]:
    return sorted((way.start, way.end) for way in ways)


def offsets(way: Way, *places: Place) -> NDArray[np.float64]:
    """How far the ends of a way are from places, m."""
    return np.asarray(np.hypot(*(way.points[[0, -1]] - np.array(places)).T))


def test_way_between_two_places_in_sight_of_each_other_is_straight() -> None:
    (way,) = ways_between(floor_plan(TWO_ROOMS), (1.55, 1.05), (3.55, 3.05))
    assert way.points == pytest.approx(np.array([[1.55, 1.05], [3.55, 3.05]]), abs=0.06)
    assert way.length == pytest.approx(np.hypot(2.0, 2.0), abs=0.1)


def test_way_leads_from_the_first_place_to_the_second() -> None:
    places = (8.05, 3.05), (1.55, 1.05)
    (way,) = ways_between(floor_plan(TWO_ROOMS), *places)
    assert (way.start, way.end) == (0, 1)
    assert (offsets(way, *places) < 0.08).all()


def test_way_to_the_next_room_leads_through_the_middle_of_the_door() -> None:
    (way,) = ways_between(floor_plan(TWO_ROOMS), (2.55, 3.05), (7.55, 3.05))
    x, y = way.points.T
    at_door = np.interp(4.95, x, y)
    assert at_door == pytest.approx(1.95, abs=0.16)


def test_way_leads_round_a_table_and_keeps_off_it() -> None:
    places = (1.05, 1.35), (8.55, 1.35)
    (way,) = ways_between(floor_plan(TABLE_IN_THE_WAY), *places)
    assert way.length > 7.55
    for one, other in zip(way.points[:-1], way.points[1:], strict=True):
        for share in np.linspace(0.0, 1.0, 50):
            x, y = one + share * (other - one)
            # The table fills 4.8 < x < 5.7 and 0.9 < y < 1.8.
            assert not (4.7 < x < 5.8 and 0.8 < y < 1.9)


def test_no_way_leads_into_a_room_without_a_door() -> None:
    assert ways_between(floor_plan(SEALED), (2.0, 1.5), (6.0, 1.5)) == []


def test_no_way_leads_through_what_is_unknown() -> None:
    unknown = floor_plan(
        SEALED.replace("#............#.............#", "#............?.............#")
    )
    assert ways_between(unknown, (2.0, 1.5), (6.0, 1.5)) == []


def test_no_way_leads_through_a_gap_narrower_than_the_robot() -> None:
    gap = TWO_ROOMS.replace(
        "#...............................#", "#...............#...............#", 2
    )
    assert ways_between(floor_plan(gap), (2.0, 1.5), (8.0, 1.5)) == []


def test_a_single_place_and_none_have_no_ways() -> None:
    world = floor_plan(TWO_ROOMS)
    assert ways_between(world, (2.0, 1.5)) == []
    ground = drivable_space(world)
    costs = cell_costs(ground, GroundParams())
    nowhere = np.empty((0, 2), np.int64)
    assert find_ways(ground, nowhere, costs, Gates.none(0, ground)) == []


def test_places_in_a_row_are_joined_to_their_neighbours_only() -> None:
    ways = ways_between(floor_plan(FLAT), (1.05, 1.05), (4.05, 1.05), (7.05, 1.05), (10.05, 1.05))
    assert ends_of(ways) == [(0, 1), (1, 2), (2, 3)]


def test_long_way_round_a_triangle_is_kept_and_a_short_one_spared() -> None:
    flat_triangle = ways_between(floor_plan(SEALED), (0.85, 1.35), (2.05, 1.45), (3.25, 1.35))
    assert ends_of(flat_triangle) == [(0, 1), (1, 2)]
    high_triangle = ways_between(floor_plan(SEALED), (0.85, 0.85), (2.05, 2.25), (3.25, 0.85))
    assert ends_of(high_triangle) == [(0, 1), (0, 2), (1, 2)]


def test_a_metre_beside_a_wall_is_dear_and_one_in_the_open_is_not() -> None:
    ground = drivable_space(floor_plan(SEALED))
    params = GroundParams(body=0.2, ease=0.6, dislike=3.0)
    costs = cell_costs(ground, params)
    assert costs[tuple(ground.geometry.cells_of([[2.0, 1.5]])[0])] == 1.0
    assert costs[tuple(ground.geometry.cells_of([[0.55, 1.5]])[0])] == pytest.approx(3.25)
    assert np.isinf(costs[tuple(ground.geometry.cells_of([[0.45, 1.5]])[0])])
    assert np.isinf(costs[[0, -1]]).all()
    assert np.isinf(costs[:, [0, -1]]).all()


def test_map_that_is_free_to_its_rim_is_not_left() -> None:
    world = floor_plan(("." * 20 + "\n") * 15)
    (way,) = ways_between(world, (0.35, 0.35), (5.65, 4.15))
    inside = world.geometry.contains(world.geometry.cells_of(way.points))
    assert inside.all()


def test_edges_say_through_what_they_lead() -> None:
    world = build_topology(floor_plan(FLAT), "0123")
    kinds = {node.id: node.kind for node in world.nodes}
    names = {node.id: node.name for node in world.nodes}
    for edge in world.edges:
        ends = {kinds[edge.start], kinds[edge.end]}
        assert (edge.kind == "door") == ("door" in ends)
        if edge.kind == "corridor":
            assert all(names[end].startswith("corridor") for end in (edge.start, edge.end))
    assert {edge.kind for edge in world.edges} == {"door", "corridor"}


def test_each_door_joins_both_its_rooms() -> None:
    building = build(floor_plan(FLAT), "0123")
    world = building.topology
    names = {node.id: node.name.split(".")[0] for node in world.nodes}
    for door in world.nodes[:3]:
        beyond = {
            names[edge.end if edge.start == door.id else edge.start]
            for edge in world.edges
            if door.id in (edge.start, edge.end)
        }
        assert "corridor 1" in beyond
        assert len(beyond) == 2


def test_an_edge_s_length_is_that_of_its_way() -> None:
    for edge in build_topology(floor_plan(FLAT), "0123").edges:
        assert edge.length == pytest.approx(float(np.hypot(*np.diff(edge.way, axis=0).T).sum()))


def test_sealed_rooms_are_two_parts_without_a_way() -> None:
    world = build_topology(floor_plan(SEALED), "0123")
    assert len(world.nodes) == 2
    assert world.edges == ()


def test_ways_along_a_corridor_pass_its_doors_by() -> None:
    topology = build_topology(floor_plan(FLAT), "flat")
    kinds = {node.id: node.kind for node in topology.nodes}
    names = {node.id: node.name for node in topology.nodes}
    corridor = [
        edge
        for edge in topology.edges
        if kinds[edge.start] == kinds[edge.end] == "node"
        and names[edge.start].split(".")[0] == names[edge.end].split(".")[0] == "corridor 1"
    ]
    assert len(corridor) >= 2
    for edge in corridor:
        straight = np.hypot(*(edge.way[-1] - edge.way[0]))
        assert edge.length <= 1.1 * straight
