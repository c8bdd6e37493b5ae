"""Where the nodes of drawn maps stand, how they are named, and what is bound to them."""

import numpy as np
import pytest
from numpy.typing import NDArray

from floor_plans import FLAT, TWO_ROOMS, floor_plan
from pilotage.core import se2
from pilotage.core.corners import find_corners
from pilotage.core.grid import OccupancyMap
from pilotage.core.map_lines import map_lines
from pilotage.topology.features import KINDS, Features
from pilotage.topology.from_map.bound_features import (
    FAR,
    MOST,
    corner_features,
    opening_features,
    seen_from,
)
from pilotage.topology.from_map.building import Building, BuildParams, build
from pilotage.topology.from_map.ground import GroundParams, cell_costs, on_ground
from pilotage.topology.from_map.nodes import MiddleLine, NodeParams, Site, middle_line
from pilotage.topology.from_map.space import drivable_space
from pilotage.topology.topological_map import Node, Spacing
from topology_maps import features

LONG_CORRIDOR = "\n".join(["#" * 82, *["#" + "." * 80 + "#"] * 5, "#" * 82])
"""24 m x 1.5 m; its middle lies at y = 1.05 m."""

BEND = """
    ###########################################
    #.........................................#
    #.........................................#
    #.........................................#
    #.........................................#
    #.........................................#
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    #.....#####################################
    ###########################################
"""
"""A corridor with a bend at its upper left."""


def built(
    picture: str,
    spacing: Spacing = "variable",
    distance: float = 4.0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Building:
    params = BuildParams(nodes=NodeParams(spacing, distance))
    return build(floor_plan(picture, origin=origin), "0123", params)


def places(nodes: tuple[Node, ...]) -> NDArray[np.float64]:
    return np.array([node.pose[:2] for node in nodes])


def test_a_door_node_stands_in_its_door_and_looks_through_it() -> None:
    (door,) = [node for node in built(TWO_ROOMS).topology.nodes if node.kind == "door"]
    assert door.name == "door 1"
    assert door.pose[:2] == pytest.approx([4.95, 1.95], abs=0.1)
    assert abs(np.cos(door.pose[2])) == pytest.approx(1.0)


def test_each_room_has_a_node() -> None:
    names = [node.name for node in built(FLAT).topology.nodes]
    assert {"door 1", "door 2", "door 3", "room 1.1", "room 2.1", "room 3.1"} < set(names)


def test_no_two_nodes_are_named_alike() -> None:
    for spacing in ("variable", "equal"):
        names = [node.name for node in built(FLAT, spacing, 1.0).topology.nodes]
        assert len(set(names)) == len(names)


def test_a_corridor_has_a_node_before_each_door_on_its_middle_line() -> None:
    in_corridor = places(
        tuple(node for node in built(FLAT).topology.nodes if node.name.startswith("corridor"))
    )
    assert sorted(in_corridor[:, 0]) == pytest.approx([2.25, 6.45, 10.95], abs=0.15)
    assert in_corridor[:, 1] == pytest.approx([1.05] * 3, abs=0.15)


def test_nodes_of_equal_spacing_stand_equally_far_apart() -> None:
    nodes = built(LONG_CORRIDOR, "equal", 3.0).topology.nodes
    along = np.sort(places(nodes)[:, 0])
    assert len(nodes) >= 7
    assert np.diff(along) == pytest.approx([3.0] * (len(nodes) - 1), abs=0.15)
    assert places(nodes)[:, 1] == pytest.approx([1.05] * len(nodes), abs=0.11)


def test_nodes_of_a_corridor_look_along_it() -> None:
    for node in built(LONG_CORRIDOR, "equal", 3.0).topology.nodes[1:-1]:
        assert abs(np.cos(node.pose[2])) == pytest.approx(1.0, abs=0.02)


def test_variable_spacing_leaves_no_long_stretch_without_a_node() -> None:
    nodes = built(LONG_CORRIDOR, "variable", 4.0).topology.nodes
    along = np.sort(places(nodes)[:, 0])
    assert 2 <= len(nodes) <= 7
    for x in np.arange(1.0, 24.0, 0.5):
        assert np.abs(along - x).min() <= 1.5 * 4.0 + 0.2


def test_variable_spacing_places_a_node_where_a_corridor_bends() -> None:
    away = np.hypot(*(places(built(BEND).topology.nodes) - [1.05, 8.25]).T)
    assert away.min() < 0.6


def test_where_a_corridor_bends_its_node_is_a_corner_and_before_a_door_it_is_none() -> None:
    (corner,) = [node for node in built(BEND).topology.nodes if node.kind == "corner"]
    assert corner.pose[:2] == pytest.approx([1.05, 8.25], abs=0.4)
    assert {node.kind for node in built(FLAT).topology.nodes} == {"door", "node"}


def test_nodes_turn_and_move_with_the_origin_of_the_map() -> None:
    plain = built(FLAT).topology.nodes
    moved = built(FLAT, origin=(7.0, -2.0, 0.7)).topology.nodes
    assert len(moved) == len(plain)
    expected = se2.compose((7.0, -2.0, 0.7), np.array([node.pose for node in plain]))
    # Two of the rooms are alike, so which of them comes first is left to chance.
    for node in moved:
        away = np.hypot(*(expected[:, :2] - node.pose[:2]).T)
        nearest = int(np.argmin(away))
        assert away[nearest] < 0.11
        assert node.kind == plain[nearest].kind
        assert abs(np.cos(node.pose[2] - expected[nearest, 2])) == pytest.approx(1.0, abs=0.01)


def test_headings_are_wrapped() -> None:
    for origin in (2.0, -3.0):
        nodes = built(FLAT, origin=(0.0, 0.0, origin)).topology.nodes
        assert all(-np.pi <= node.pose[2] < np.pi for node in nodes)


def test_nodes_keep_apart_from_each_other_within_a_room() -> None:
    params = NodeParams()
    nodes = [node for node in built(FLAT).topology.nodes if node.name.startswith("corridor")]
    at = places(tuple(nodes))
    gaps = np.hypot(*np.moveaxis(at[:, None] - at, 2, 0)) + 9.0 * np.eye(len(at))
    assert gaps.min() >= params.apart - 0.2


def test_middle_line_of_a_corridor_lies_between_its_walls() -> None:
    building = built(LONG_CORRIDOR)
    line = middle_line(building.space, building.openings, 0.3, building.space.is_free)
    inner = line.poses[(line.poses[:, 0] > 1.5) & (line.poses[:, 0] < 23.0)]
    assert inner[:, 1] == pytest.approx(np.full(len(inner), 1.05), abs=0.11)
    assert (line.clearance >= 0.3).all()
    assert set(line.rooms) == {1}


def test_line_away_from_points_keeps_what_is_far_or_all() -> None:
    poses = np.column_stack([np.arange(5.0), np.zeros((5, 2))])
    line = MiddleLine(poses, np.ones(5, np.int64), np.ones(5))
    assert line.away_from(np.array([[0.0, 0.0]]), 1.5).poses[:, 0].tolist() == [2.0, 3.0, 4.0]
    assert len(line.away_from(np.array([[2.0, 0.0]]), 9.0).poses) == 5
    assert len(line.away_from(np.empty((0, 2)), 1.0).poses) == 5
    assert len(line.of_room(2).poses) == 0


def ground_of(world: OccupancyMap) -> tuple[list[Site], NDArray[np.int64]]:
    ground = drivable_space(world)
    sites = [
        Site("node", np.array([x, y, 0.5]), 1) for x, y in ((0.35, 1.05), (3.0, 1.05), (50.0, 50.0))
    ]
    return on_ground(ground, cell_costs(ground, GroundParams()), sites)


def test_node_beside_a_wall_moves_to_where_a_robot_fits_and_a_node_outside_is_dropped() -> None:
    sites, cells = ground_of(floor_plan(LONG_CORRIDOR))
    assert len(sites) == len(cells) == 2
    assert sites[0].pose == pytest.approx([0.55, 1.05, 0.5], abs=0.11)
    assert sites[1].pose == pytest.approx([3.0, 1.05, 0.5], abs=0.08)


def test_nothing_stands_on_ground_without_free_cells() -> None:
    world = floor_plan(LONG_CORRIDOR.replace(".", "?"))
    sites, cells = ground_of(world)
    assert sites == []
    assert cells.shape == (0, 2)


def test_features_bound_are_visible_ones_only() -> None:
    world = floor_plan(TWO_ROOMS)
    around = features(
        ("corner", 0.3, 0.3, 0.8), ("corner", 9.6, 0.3, 2.4), ("door", 4.95, 1.95, 0.0)
    )
    left = seen_from(world, np.array([3.0, 3.0, 0.0]), around)
    assert left.poses[:, :2].tolist() == [[4.95, 1.95], [0.3, 0.3]]
    right = seen_from(world, np.array([7.0, 3.0, 0.0]), around)
    assert right.poses[:, :2].tolist() == [[4.95, 1.95], [9.6, 0.3]]


def test_features_far_away_are_not_bound() -> None:
    world = floor_plan(LONG_CORRIDOR)
    row = features(*(("corner", x, 0.3, 0.0) for x in np.arange(1.0, 24.0)))
    seen = seen_from(world, np.array([12.0, 1.05, 0.0]), row)
    assert np.abs(seen.poses[:, 0] - 12.0).max() <= FAR
    assert len(seen) == 11


def test_the_nearest_features_are_bound_where_there_are_too_many() -> None:
    world = floor_plan(LONG_CORRIDOR)
    many = features(*(("corner", float(x), 1.05, 0.0) for x in np.linspace(7.0, 17.0, 101)))
    seen = seen_from(world, np.array([12.0, 1.05, 0.0]), many)
    assert len(seen) == MOST
    away = np.abs(seen.poses[:, 0] - 12.0)
    assert (np.diff(away) >= 0.0).all()
    assert away.max() == pytest.approx(2.0, abs=0.11)


def test_nothing_is_seen_where_there_are_no_features() -> None:
    world = floor_plan(TWO_ROOMS)
    assert len(seen_from(world, np.array([3.0, 3.0, 0.0]), Features.none())) == 0


def test_a_door_is_a_feature_with_its_width_and_a_corner_has_none() -> None:
    building = built(TWO_ROOMS)
    openings = opening_features(building.openings, 0.1)
    assert [KINDS[kind] for kind in openings.kinds] == ["door"]
    assert openings.widths == pytest.approx([0.9], abs=0.02)
    assert openings.covariances[0] == pytest.approx(np.eye(2) * 0.005)
    corners = corner_features(find_corners(map_lines(floor_plan(TWO_ROOMS))))
    assert {KINDS[kind] for kind in corners.kinds} == {"corner"}
    assert np.isnan(corners.widths).all()


def test_a_room_s_node_is_bound_to_its_own_corners_and_its_door() -> None:
    for node in built(TWO_ROOMS).topology.nodes:
        if node.kind != "node":
            continue
        doors = node.features.chosen(node.features.kinds == KINDS.index("door"))
        assert doors.poses[:, :2] == pytest.approx(np.array([[4.95, 1.95]]), abs=0.1)
        low, high = (0.2, 5.2) if node.pose[0] < 4.95 else (4.7, 9.7)
        corners = node.features.chosen(node.features.kinds == KINDS.index("corner"))
        assert len(corners) >= 4
        assert ((corners.poses[:, 0] > low) & (corners.poses[:, 0] < high)).all()


FURNISHED = """
    ####################
    #..................#
    #..................#
    #....##########....#
    #....##########....#
    #....##########....#
    #....##########....#
    #..................#
    #..................#
    ####################
"""


def test_room_with_a_table_in_its_middle_has_a_node_beside_the_table() -> None:
    building = built(FURNISHED)
    inside = building.topology.nodes
    assert inside
    assert (building.openings.labels > 0).sum() > 0.95 * (18 * 8 * 9)  # the table is no wall
    world = floor_plan(FURNISHED)
    cells = world.geometry.cells_of(places(inside)[:, :2])
    assert world.is_free[tuple(cells.T)].all()
