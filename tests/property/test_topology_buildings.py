"""Laws of the topological maps of whole buildings, drawn at random."""

import itertools

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from floor_plans import mirrored, random_building, turned
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import OccupancyMap
from pilotage.topology.from_map.bound_features import FAR, NEAR_WALL
from pilotage.topology.from_map.building import BuildParams, build, build_topology
from pilotage.topology.from_map.nodes import NodeParams
from pilotage.topology.topological_map import TopologicalMap

Points = NDArray[np.float64]
FEW = settings(max_examples=15, deadline=None)
SEEDS = st.integers(0, 2**32 - 1)
WITHIN = 0.35
"""m: a wall 0.1 m beside a door, as some have here, draws its line askew."""


def furnished(seed: int) -> OccupancyMap:
    """A building with tables, and with patches where nothing is known."""
    rng = np.random.default_rng(seed)
    world, _ = random_building(rng)
    for value in (100, -1, 100, -1):
        row, col = rng.integers(5, 60, 2)
        high, wide = rng.integers(3, 15, 2)
        world.cells[row : row + high, col : col + wide] = value
    return world


def doors_of(world: OccupancyMap) -> Points:
    openings = build(world, "0123").openings
    assert openings.is_door.all()
    return openings.chords.middles


def assert_same(found: Points, expected: Points, within: float) -> None:
    """Each point has one of the other kind near it."""
    assert len(found) == len(expected)
    gaps = found[:, None] - expected
    away = np.hypot(gaps[..., 0], gaps[..., 1])
    assert (away.min(axis=0, initial=np.inf) <= within).all()
    assert (away.min(axis=1, initial=np.inf) <= within).all()


@given(SEEDS)
@FEW
def test_all_doors_of_a_building_are_found_and_nothing_else(seed: int) -> None:
    world, doors = random_building(np.random.default_rng(seed))
    assert_same(doors_of(world), doors, WITHIN)


@given(SEEDS)
@FEW
def test_doors_turn_with_the_map(seed: int) -> None:
    world, doors = random_building(np.random.default_rng(seed))
    _, height = world.geometry.size_m
    expected = np.column_stack([height - doors[:, 1], doors[:, 0]])
    assert_same(doors_of(turned(world)), expected, WITHIN)


@given(SEEDS)
@FEW
def test_doors_are_mirrored_with_the_map(seed: int) -> None:
    world, doors = random_building(np.random.default_rng(seed))
    width, _ = world.geometry.size_m
    expected = np.column_stack([width - doors[:, 0], doors[:, 1]])
    assert_same(doors_of(mirrored(world)), expected, WITHIN)


@given(SEEDS, st.sampled_from(["variable", "equal"]))
@FEW
def test_nodes_and_edges_fit_together(seed: int, spacing: str) -> None:
    nodes = NodeParams("equal" if spacing == "equal" else "variable")
    world = build_topology(furnished(seed), "0123", BuildParams(nodes=nodes))
    ids = [node.id for node in world.nodes] + [edge.id for edge in world.edges]
    assert len(set(ids)) == len(ids)
    assert len({node.name for node in world.nodes}) == len(world.nodes)
    by_id = {node.id: node for node in world.nodes}
    for edge in world.edges:
        assert edge.start != edge.end
        assert edge.way[0].tolist() == by_id[edge.start].pose[:2].tolist()
        assert edge.way[-1].tolist() == by_id[edge.end].pose[:2].tolist()
        length = float(np.hypot(*np.diff(edge.way, axis=0).T).sum())
        assert edge.length == pytest.approx(length)


@given(SEEDS)
@FEW
def test_robot_fits_at_all_nodes_and_on_all_ways(seed: int) -> None:
    drawn = furnished(seed)
    body, cell = BuildParams().ground.body, drawn.geometry.resolution
    clearance = distance_to_walls(~drawn.is_free, cell)
    world = build_topology(drawn, "0123")
    for node in world.nodes:
        assert clearance[tuple(drawn.geometry.cells_of([node.pose[:2]])[0])] > body
    for edge in world.edges:
        cells = drawn.geometry.cells_of(along(edge.way, cell / 4.0))
        # A straight way may cut the edge of a cell that is too near a wall, by less than a cell.
        assert (clearance[tuple(cells.T)] > body - cell).all()


def along(way: Points, step: float) -> Points:
    """Points of a way, so many m apart at most."""
    parts = [
        one
        + np.linspace(0.0, 1.0, 2 + int(np.hypot(*(other - one)) / step))[:, None] * (other - one)
        for one, other in itertools.pairwise(way)
    ]
    return np.concatenate(parts)


@given(SEEDS)
@FEW
def test_features_bound_to_a_node_can_be_seen_from_it(seed: int) -> None:
    drawn = furnished(seed)
    for node in build_topology(drawn, "0123").nodes:
        place = node.pose[:2]
        for feature in node.features.poses[:, :2]:
            distance = float(np.hypot(*(feature - place)))
            assert distance <= FAR
            share = max(0.0, 1.0 - (NEAR_WALL + 0.01) / max(distance, 0.01))
            beam = along(np.array([place, place + share * (feature - place)]), 0.05)
            assert not drawn.is_wall[tuple(drawn.geometry.cells_of(beam).T)].any()


@given(SEEDS)
@FEW
def test_rooms_with_doors_hang_together(seed: int) -> None:
    drawn, doors = random_building(np.random.default_rng(seed))
    building = build(drawn, "0123")
    graph = graph_of(building.topology)
    parts = nx.number_connected_components(graph)
    # A tree of rooms, unless a wall had no place for a door.
    assert parts == len(building.rooms) - len(doors)


def graph_of(world: TopologicalMap) -> "nx.Graph[int]":
    graph: nx.Graph[int] = nx.Graph()
    graph.add_nodes_from(node.id for node in world.nodes)
    graph.add_edges_from((edge.start, edge.end) for edge in world.edges)
    return graph
