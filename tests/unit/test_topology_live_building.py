"""A map that grows while the robot drives: nodes, ways, doors; and poses corrected afterwards."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from feature_scenes import corner, door
from pilotage.core import se2
from pilotage.topology.features import Features
from pilotage.topology.from_drive.building import LiveBuilder, LiveParams
from pilotage.topology.from_drive.nodes import NodeParams
from pilotage.topology.topological_map import TopologicalMap
from topology_world import DOORS, ROUND, Glimpse, drive, floor

CORRIDOR = [(0.8, 3.3), (13.0, 3.3)]


@cache
def ride() -> tuple[Glimpse, ...]:
    return tuple(drive(floor(), ROUND))


def built(
    glimpses: tuple[Glimpse, ...], params: LiveParams | None = None, *, finished: bool = True
) -> LiveBuilder:
    builder = LiveBuilder(params)
    for glimpse in glimpses:
        builder.add(glimpse.stamp, glimpse.pose, glimpse.seen)
    if finished:
        builder.finish()
    return builder


@cache
def world() -> TopologicalMap:
    return built(ride()).topology("floor")


def blind(corners: list[tuple[float, float]]) -> tuple[Glimpse, ...]:
    """A drive on which nothing is ever seen."""
    points = np.array(corners, float)
    poses = []
    for begin, end in pairwise(points):
        steps = max(round(float(np.hypot(*(end - begin))) / 0.1), 1)
        heading = np.arctan2(*(end - begin)[::-1])
        poses += [[*(begin + k / steps * (end - begin)), heading] for k in range(steps + 1)]
    return tuple(Glimpse(0.2 * k, np.array(p), Features.none()) for k, p in enumerate(poses))


def near(topology: TopologicalMap, place: tuple[float, float], within: float = 0.4) -> list[int]:
    off = np.hypot(*(topology.places[:, :2] - place).T)
    return [topology.nodes[k].id for k in np.flatnonzero(off < within)]


def test_all_doors_along_a_corridor_are_known_in_the_end() -> None:
    features = built(ride()).features
    places = features.poses[features.kinds == 1, :2]
    assert len(places) == len(DOORS)
    for middle in DOORS:
        assert np.hypot(*(places - middle).T).min() < 0.2


def test_a_door_that_was_gone_through_is_a_node() -> None:
    doors = [node for node in world().nodes if node.kind == "door"]
    assert len(doors) == 1
    np.testing.assert_allclose(doors[0].pose[:2], (5.75, 4.375), atol=0.2)
    # Its heading is that of going through.
    assert abs(np.sin(doors[0].pose[2])) > 0.99


def test_doors_passed_have_a_node_abreast() -> None:
    for place in [(2.0, 3.3), (4.25, 3.3), (9.25, 3.3)]:
        assert near(world(), place), place


def test_the_way_through_a_door_leaves_the_corridor() -> None:
    topology = world()
    door_id = next(node.id for node in topology.nodes if node.kind == "door")
    kinds = {edge.kind for edge in topology.edges if door_id in (edge.start, edge.end)}
    assert kinds == {"door"}
    rest = {edge.kind for edge in topology.edges if door_id not in (edge.start, edge.end)}
    assert rest == {"corridor"}


def test_edges_are_as_long_as_their_ways_and_end_at_their_nodes() -> None:
    topology = world()
    for edge in topology.edges:
        assert edge.length == pytest.approx(np.hypot(*np.diff(edge.way, axis=0).T).sum())
        np.testing.assert_allclose(edge.way[0], topology.nodes[edge.start].pose[:2])
        np.testing.assert_allclose(edge.way[-1], topology.nodes[edge.end].pose[:2])


def test_driving_back_makes_no_second_corridor() -> None:
    once = built(tuple(drive(floor(), CORRIDOR)))
    there_and_back = built(tuple(drive(floor(), [*CORRIDOR, CORRIDOR[0]])))
    first, both = once.topology("a"), there_and_back.topology("b")
    assert len(both.nodes) <= len(first.nodes) + 2
    apart = both.places[:, None, :2] - both.places[None, :, :2]
    np.fill_diagonal(apart[..., 0], np.inf)
    assert np.hypot(apart[..., 0], apart[..., 1]).min() > 0.5


def test_ids_are_unique_over_nodes_and_edges() -> None:
    topology = world()
    ids = [node.id for node in topology.nodes] + [edge.id for edge in topology.edges]
    assert len(set(ids)) == len(ids)


def test_the_map_is_one_piece() -> None:
    topology = world()
    reached, new = {0}, {0}
    while new:
        pairs = [(e.start, e.end) for e in topology.edges]
        new = {b for a, b in pairs if a in reached} | {a for a, b in pairs if b in reached}
        new -= reached
        reached |= new
    assert reached == {node.id for node in topology.nodes}


def test_nodes_are_bound_to_what_is_seen_from_them() -> None:
    for node in world().nodes:
        off = np.hypot(*(node.features.poses[:, :2] - node.pose[:2]).T)
        assert (off < 5.5).all()
    assert np.mean([len(node.features) for node in world().nodes]) >= 4


def test_nodes_keep_their_ids_while_the_robot_drives_on() -> None:
    builder = LiveBuilder()
    known: dict[int, np.ndarray] = {}
    for glimpse in ride():
        if builder.add(glimpse.stamp, glimpse.pose, glimpse.seen):
            now = {node.id: node.pose for node in builder.topology("floor").nodes}
            assert known.keys() <= now.keys()
            for number, pose in known.items():
                np.testing.assert_array_equal(now[number], pose)
            known = now
    assert len(known) >= 5


def test_a_change_is_told() -> None:
    builder = LiveBuilder()
    for glimpse in ride():
        before = builder.topology("floor")
        told = builder.add(glimpse.stamp, glimpse.pose, glimpse.seen)
        after = builder.topology("floor")
        if len(after.nodes) != len(before.nodes) or len(after.edges) != len(before.edges):
            assert told


def test_where_nothing_is_to_be_bound_nodes_are_far_apart() -> None:
    topology = built(blind([(0.0, 0.0), (20.0, 0.0)])).topology("empty")
    spacing = np.diff(topology.places[:, 0])
    assert len(topology.nodes) == 3
    np.testing.assert_allclose(spacing, 8.0, atol=0.3)


def test_equal_spacing_sets_nodes_whatever_is_seen() -> None:
    params = LiveParams(nodes=NodeParams(spacing="equal", usual=2.0))
    topology = built(blind([(0.0, 0.0), (9.0, 0.0)]), params).topology("equal")
    np.testing.assert_allclose(topology.places[:, 0], [0.0, 2.0, 4.0, 6.0, 8.0], atol=0.3)


def test_a_loop_is_closed() -> None:
    square = [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0), (0.0, 0.0), (5.0, 0.0)]
    topology = built(blind(square)).topology("loop")
    degree = [
        sum(number in (edge.start, edge.end) for edge in topology.edges)
        for number in range(len(topology.nodes))
    ]
    assert degree == [2] * len(topology.nodes)
    assert sum(edge.length for edge in topology.edges) == pytest.approx(36.0, rel=0.03)


def test_people_seen_once_are_no_features() -> None:
    glimpses = [
        Glimpse(g.stamp, g.pose, corner(2.0, 0.5, 1.0) if k == 30 else g.seen)
        for k, g in enumerate(blind([(0.0, 0.0), (9.0, 0.0)]))
    ]
    assert len(built(tuple(glimpses)).features) == 0


def test_standing_still_adds_nothing() -> None:
    builder = LiveBuilder()
    pose = np.array([1.0, 1.0, 0.0])
    told = [builder.add(0.2 * k, pose, door(2.0, 1.0)) for k in range(50)]
    assert not any(told[1:])
    assert len(builder.features) == 0


def test_corrected_poses_move_the_map() -> None:
    builder = built(ride())
    before = builder.topology("floor")
    move = np.array([3.0, -1.0, 0.5])
    stamps = np.array([glimpse.stamp for glimpse in ride()])[::7]
    poses = se2.compose(move, np.array([glimpse.pose for glimpse in ride()]))[::7]
    assert builder.correct(stamps, poses)
    builder.finish()
    after = builder.topology("floor")
    moved = se2.compose(move, before.places)
    off = np.hypot(*np.moveaxis(moved[:, None, :2] - after.places[None, :, :2], 2, 0))
    # A node for which there was hardly room may be set or not.
    assert np.sum(off.min(axis=1) < 0.3) >= len(before.nodes) - 1
    kinds = [after.nodes[k].kind for k in off.argmin(axis=1)]
    doors = [k for k, node in enumerate(before.nodes) if node.kind == "door"]
    assert [kinds[k] for k in doors] == ["door"] * len(doors)


@pytest.mark.parametrize("every", [1, 7])
def test_small_corrections_change_nothing(every: int) -> None:
    builder = built(ride())
    stamps = np.array([glimpse.stamp for glimpse in ride()])[::every]
    poses = np.array([glimpse.pose + np.array([0.02, 0.01, 0.002]) for glimpse in ride()])
    assert not builder.correct(stamps, poses[::every])


def test_a_correction_before_the_drive_changes_nothing() -> None:
    assert not LiveBuilder().correct(np.array([1.0]), np.zeros((1, 3)))


def test_a_correction_closes_a_loop_that_drift_had_left_open() -> None:
    square = blind([(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0), (0.0, 0.0), (5.0, 0.0)])
    drift = [np.array([0.02 * k, 0.015 * k, 0.0]) for k in range(len(square))]
    builder = LiveBuilder()
    for glimpse, off in zip(square, drift, strict=True):
        builder.add(glimpse.stamp, glimpse.pose + off, glimpse.seen)
    open_nodes = len(builder.topology("loop").nodes)
    stamps = np.array([glimpse.stamp for glimpse in square])
    assert builder.correct(stamps, np.array([glimpse.pose for glimpse in square]))
    builder.finish()
    assert len(builder.topology("loop").nodes) <= open_nodes
    assert len(builder.topology("loop").edges) == len(builder.topology("loop").nodes)


def test_an_empty_drive_is_an_empty_map() -> None:
    builder = LiveBuilder()
    builder.finish()
    assert builder.topology("nothing") == TopologicalMap("nothing", (), ())
