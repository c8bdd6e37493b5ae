"""Where a robot is that knows nothing but the nodes it has come by."""

import time
from itertools import pairwise

import numpy as np
import pytest

from chain_world import DOOR, corridor, features, seen_at, walk
from pilotage.core import se2
from pilotage.topology.features import Features
from pilotage.topology.node_chains.candidates import NOWHERE, ChainParams, Link
from pilotage.topology.node_chains.chain import NodeChain
from pilotage.topology.node_chains.map import ChainMap
from pilotage.topology.topological_map import Edge, Node, TopologicalMap

UPPER = "d   d  d     d      d   d      d"
LOWER = "      d    d    d     d   d  d"
"""Doors alike, at irregular distances."""

AHEAD, BACK = 0.0, np.pi


def stops(topology: TopologicalMap) -> list[float]:
    return [float(node.pose[0]) for node in topology.nodes]


def test_a_chain_of_alike_doors_ends_on_the_right_node() -> None:
    topology = corridor(UPPER, LOWER)
    chain = NodeChain.over(topology)
    along = stops(topology)[2:7]
    arrived = walk(chain, topology, [(x, 0.1, AHEAD) for x in along])
    assert chain.is_unique
    assert chain.node == 6
    assert chain.pose == pytest.approx(arrived[-1], abs=0.03)


def test_one_door_alone_is_any_door() -> None:
    topology = corridor(UPPER, LOWER)
    chain = NodeChain.over(topology)
    walk(chain, topology, [(11.0, 0.0, AHEAD)])
    assert not chain.is_unique
    assert len(set(chain.nodes.tolist()) - {NOWHERE}) > 3


def test_a_chain_is_found_the_other_way_round() -> None:
    topology = corridor(UPPER, LOWER)
    chain = NodeChain.over(topology)
    along = stops(topology)[8:2:-1]
    arrived = walk(chain, topology, [(x, 0.0, BACK) for x in along])
    assert chain.is_unique
    assert chain.node == 3
    assert chain.pose is not None
    assert abs(se2.between(arrived[-1], chain.pose)).max() < 0.03


def test_a_corridor_alike_from_both_ends_is_never_told() -> None:
    topology = corridor("d   d  d   d", "d   d  d   d")
    chain = NodeChain.over(topology)
    ways = ((0, 0), (4, 0), (7, 0), (11, 0), (7, np.pi), (4, np.pi), (0, np.pi))
    poses = [np.array([float(x), 0.0, heading]) for x, heading in ways]
    for before, at in pairwise([poses[0], *poses]):
        chain.add(Link(seen_at(topology, at), se2.between(before, at)))
        assert not chain.is_unique
    first, second, *_ = chain.candidates.shares
    assert first == pytest.approx(second)
    assert first > 0.4
    one, other = chain.candidates.poses[:2]
    assert se2.compose([11.0, 0.0, np.pi], one) == pytest.approx(other, abs=1e-6)


def test_a_node_that_was_missed_does_not_end_the_chain() -> None:
    topology = corridor(UPPER, LOWER)
    chain = NodeChain.over(topology)
    along = stops(topology)
    walk(chain, topology, [(along[k], 0.0, AHEAD) for k in (0, 1, 3, 4, 6, 7)])
    assert chain.is_unique
    assert chain.node == 7


def test_a_node_that_is_none_does_not_end_the_chain() -> None:
    topology = corridor(UPPER, LOWER)
    chain = NodeChain.over(topology)
    along = stops(topology)
    ways = [along[0], along[1], 5.2, along[2], along[3], along[4], along[5]]
    for k, x in enumerate(ways):
        at = np.array([x, 0.0, AHEAD])
        is_none = k == 2
        seen = features(DOOR, [(0.5, 0.3, 0.7)]) if is_none else seen_at(topology, at)
        moved = np.array([x - ways[k - 1], 0.0, 0.0]) if k else np.zeros(3)
        chain.add(Link(seen, moved, np.diag([0.03, 0.03, 0.02]) ** 2))
        if is_none:
            assert not chain.is_unique
    assert chain.is_unique
    assert chain.node == 5


def test_features_that_come_and_go_do_not_end_the_chain() -> None:
    topology = corridor(UPPER, LOWER)
    rng = np.random.default_rng(3)
    wrong = right = 0
    for start in range(1, 6):
        chain = NodeChain.over(topology)
        along = stops(topology)[start : start + 6]
        poses = [(x, *rng.normal(0.0, [0.1, 0.05])) for x in along]
        walk(chain, topology, poses, rng)
        is_right = chain.node == start + len(along) - 1
        right += chain.is_unique and is_right
        wrong += chain.is_unique and not is_right
    assert wrong == 0
    assert right >= 4


def test_what_fits_nowhere_is_nowhere() -> None:
    topology = corridor(UPPER, LOWER)
    chain = NodeChain.over(topology)
    strange = features(DOOR, [(0.3, 0.2, 0.0), (0.3, -0.3, 0.0), (-1.0, 0.1, 0.0)], width=2.0)
    for _ in range(4):
        chain.add(Link(strange, np.array([1.1, 0.4, 1.0]), 1e-4 * np.eye(3)))
        assert not chain.is_unique
    assert chain.candidates.pairs.max() == 0


def test_nothing_is_known_before_the_first_node() -> None:
    chain = NodeChain.over(corridor(UPPER, LOWER))
    assert chain.node is None
    assert chain.pose is None
    assert chain.share == 0.0
    assert not chain.is_unique


def test_a_map_without_nodes_has_no_candidates() -> None:
    chain = NodeChain.over(TopologicalMap("empty", (), ()))
    chain.add(Link(features(DOOR, [(1.0, 1.0, 0.0)])))
    assert chain.node is None
    assert not chain.is_unique
    assert chain.nodes.tolist() == [NOWHERE]


def test_a_single_node_is_still_two_ways_round() -> None:
    topology = corridor("d", "d")
    chain = NodeChain.over(topology)
    chain.add(Link(seen_at(topology, (0.0, 0.0, 0.0), reach=2.0)))
    assert not chain.is_unique


def test_a_crossing_has_a_way_round_for_each_of_its_edges() -> None:
    middle = Node(0, "node", "", np.zeros(3), Features.none())
    north = Node(1, "node", "", np.array([0.0, 5.0, 0.0]), Features.none())
    way = np.array([[0.0, 0.0], [0.0, 2.0], [0.0, 5.0]])
    places = ChainMap.of(
        TopologicalMap("", (middle, north), (Edge(2, 0, 1, "corridor", 5.0, way),))
    )
    headings = np.sort(places.poses[places.at_node & (places.nodes == 0), 2])
    assert headings == pytest.approx([-np.pi, -np.pi / 2.0, 0.0, np.pi / 2.0])


def test_places_along_an_edge_look_both_ways_and_belong_to_the_nearer_node() -> None:
    places = ChainMap.of(corridor("d   d", ""))
    x, _, heading = places.poses[~places.at_node].T
    assert np.diff(np.unique(x.round(6))).max() <= 0.5
    assert x.min() > 0.0
    assert x.max() < 4.0
    assert ((x < 2.0) == (places.nodes[~places.at_node] == 0)).all()
    assert np.count_nonzero(np.cos(heading) > 0.0) == len(x) / 2


def test_a_robot_that_begins_between_nodes_is_found() -> None:
    topology = corridor(UPPER, LOWER)
    chain = NodeChain.over(topology)
    along = stops(topology)
    walk(chain, topology, [(x, 0.0, AHEAD) for x in (along[1] + 0.9, *along[2:7])])
    assert chain.is_unique
    assert chain.node == 6


def test_a_map_that_lacks_most_of_what_is_seen_tells_nothing() -> None:
    topology = corridor("d   d  d     d      d   d      d", " " * 32)
    whole = corridor(UPPER, "dd dd dd d dd dd d dd d dd dd d dd")
    chain = NodeChain.over(topology)
    for k, x in enumerate(stops(topology)):
        at = np.array([x, 0.0, AHEAD])
        step = np.array([x - stops(topology)[k - 1] if k else 0.0, 0.0, 0.0])
        chain.add(Link(seen_at(whole, at), step, np.diag([0.03, 0.03, 0.02]) ** 2))
        assert not chain.is_unique
    assert chain.explained < chain.params.explained


def test_nodes_are_reached_over_the_fewest_edges() -> None:
    places = ChainMap.of(corridor("d d d d d", ""))
    rows = places.reached(np.array([1, 4]), 2)
    assert rows[rows[:, 0] == 0][:, 1:].tolist() == [[0, 1], [1, 0], [2, 1], [3, 2]]
    assert rows[rows[:, 0] == 1][:, 1:].tolist() == [[2, 2], [3, 1], [4, 0]]


def test_pairs_are_counted_and_the_pose_is_theirs() -> None:
    topology = corridor("  d  c", "d   p ")
    pose = (1.85, -0.1, 0.05)
    chain = NodeChain.over(topology, ChainParams(half_view=np.pi / 2.0))
    chain.add(Link(seen_at(topology, pose, reach=4.0)))
    best = chain.best
    assert best is not None
    assert chain.candidates.pairs[best] == 3
    assert chain.pose == pytest.approx(pose, abs=0.02)


def test_ten_thousand_nodes_are_searched_within_seconds() -> None:
    rng = np.random.default_rng(0)
    letters = ["".join(rng.choice(list("d  "), 18_000)) for _ in range(2)]
    topology = corridor(*letters)
    assert len(topology.nodes) >= 9_900
    places = ChainMap.of(topology)
    along = stops(topology)[2_000:2_020]
    walk(NodeChain(places), topology, [(along[0], 0.0, AHEAD)])
    started = time.process_time()
    chain = NodeChain(places)
    walk(chain, topology, [(along[0], 0.0, AHEAD)])
    assert time.process_time() - started < 3.0
    walk(chain, topology, [(x, 0.0, AHEAD) for x in along[1:]])
    assert chain.is_unique
    assert chain.node == 2_019
