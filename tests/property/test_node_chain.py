"""Laws of chains of nodes on random graphs, and the plain twin that tries every history."""

from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chain_world import edge
from naive.node_chain import Place, edges_between, fit_place, weigh_chain
from pilotage.core import se2
from pilotage.topology.features import Features
from pilotage.topology.node_chains.candidates import NOWHERE, ChainParams, Link
from pilotage.topology.node_chains.chain import NodeChain
from pilotage.topology.node_chains.fits import _model
from pilotage.topology.node_chains.kernels import Arrivals, weigh_places
from pilotage.topology.node_chains.map import ChainMap
from pilotage.topology.node_chains.pairs import Seen
from pilotage.topology.topological_map import Node, TopologicalMap

EVERYTHING = ChainParams(prune=1e6)
"""Nothing that is possible is given up."""

SEEDS = st.integers(0, 2**32 - 1)


def some_features(rng: np.random.Generator, count: int) -> Features:
    kinds = rng.integers(0, 3, count)
    poses = rng.uniform([-3.0, -2.0, -np.pi], [3.0, 2.0, np.pi], (count, 3))
    widths = np.where(kinds == 0, np.nan, rng.uniform(0.7, 1.5, count))
    roots = rng.normal(0.0, 0.03, (count, 2, 2))
    return Features(kinds, poses, widths, roots @ roots.transpose(0, 2, 1) + 1e-4 * np.eye(2))


def some_map(rng: np.random.Generator, count: int, size: float = 4.0) -> TopologicalMap:
    """A random tree with some further edges; nodes often bound to the same constellation.

    Within `size` m of the origin along either axis.
    """
    constellations = [some_features(rng, int(rng.integers(1, 4))) for _ in range(2)]
    nodes = []
    for k in range(count):
        pose = rng.uniform([-size, -size, -np.pi], [size, size, np.pi])
        like = constellations[rng.integers(2)].moved(pose)
        nodes.append(Node(10 + k, "node", "", pose, like))
    pairs = {(int(rng.integers(k)), k) for k in range(1, count)}
    pairs |= {(a, b) for a, b in rng.integers(0, count, (count // 2, 2)).tolist() if a < b}
    edges = [edge(100 + k, nodes[a], nodes[b]) for k, (a, b) in enumerate(sorted(pairs))]
    return TopologicalMap("random", tuple(nodes), tuple(edges))


def some_walk(rng: np.random.Generator, topology: TopologicalMap, count: int) -> list[Link]:
    """What a robot sees that goes from node to node, now and then to one that is none."""
    places = ChainMap.of(topology)
    index = {node.id: k for k, node in enumerate(topology.nodes)}
    neighbours = defaultdict(list)
    for one in topology.edges:
        neighbours[index[one.start]].append(index[one.end])
        neighbours[index[one.end]].append(index[one.start])
    node, last, links = int(rng.integers(len(topology.nodes))), np.zeros(3), []
    for _ in range(count):
        expected = places.poses[rng.choice(np.flatnonzero(places.nodes == node))]
        at = se2.compose(expected, rng.normal(0.0, [0.15, 0.15, 0.08]))
        seen = topology.nodes[node].features.moved(se2.inverse(at))
        seen = Features.joined(
            [seen.chosen(rng.random(len(seen)) < 0.8), some_features(rng, int(rng.integers(2)))]
        )
        moved = se2.between(last, at) + rng.normal(0.0, [0.05, 0.05, 0.03])
        links.append(Link(seen, moved, np.diag([0.05, 0.05, 0.03]) ** 2))
        node, last = int(rng.choice(neighbours[node])), at
    return links


def chain_of(topology: TopologicalMap, links: list[Link], params: ChainParams) -> NodeChain:
    chain = NodeChain.over(topology, params)
    for link in links:
        chain.add(link)
    return chain


@given(SEEDS)
@settings(max_examples=60, deadline=None)
def test_constellations_weigh_as_in_the_plain_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    topology = some_map(rng, 4)
    link = some_walk(rng, topology, 1)[0]
    places = ChainMap.of(topology)
    seen = link.seen
    near = seen.chosen(np.hypot(*seen.poses[:, :2].T) <= EVERYTHING.seen_within)
    variances = np.trace(near.covariances, axis1=1, axis2=2) / 2.0 + EVERYTHING.blur**2
    about = Seen(near.kinds, near.poses, near.widths, variances)
    spreads = np.tile([EVERYTHING.place, EVERYTHING.turn], (len(places.nodes), 1))
    arrivals = Arrivals(places.nodes, places.poses, spreads)
    evidence, offsets, _, pairs = weigh_places(about, places.bound, arrivals, _model(EVERYTHING))
    for k, node in enumerate(places.nodes):
        fit = fit_place(seen, topology.nodes[node].features, places.poses[k], EVERYTHING)
        assert evidence[k] == pytest.approx(fit.evidence, rel=1e-7, abs=1e-7)
        assert pairs[k] == fit.pairs
        off = se2.between(se2.compose(places.poses[k], offsets[k]), fit.pose)
        assert off == pytest.approx([0.0, 0.0, 0.0], abs=1e-7)


@given(SEEDS, st.integers(1, 2))
@settings(max_examples=12, deadline=None)
def test_candidates_weigh_as_the_sum_of_all_their_histories(seed: int, length: int) -> None:
    rng = np.random.default_rng(seed)
    topology = some_map(rng, 2, size=0.6)
    links = some_walk(rng, topology, length)
    params = replace(EVERYTHING, most_missed=int(rng.integers(0, 2)))
    chain = chain_of(topology, links, params)
    places = [
        Place(int(node), pose, bool(at_node))
        for node, pose, at_node in zip(
            chain.places.nodes, chain.places.poses, chain.places.at_node, strict=True
        )
    ]
    histories = weigh_chain(topology, places, links, params)
    expected: dict[tuple[int, bool], float] = defaultdict(float)
    for history, (weight, node) in histories.items():
        last = history[-1]
        is_node = last is not None and places[last].at_node
        expected[NOWHERE if node is None else node, is_node] += weight
    total = sum(expected.values())
    found: dict[tuple[int, bool], float] = defaultdict(float)
    for place, at_node, share in zip(
        chain.candidates.places, chain.candidates.at_node, chain.candidates.shares, strict=True
    ):
        node = NOWHERE if place == NOWHERE else int(chain.places.nodes[place])
        found[node, bool(at_node)] += share
    assert set(found) == set(expected)
    for key, weight in expected.items():
        assert found[key] == pytest.approx(weight / total, rel=1e-6, abs=1e-12)


@given(SEEDS)
@settings(max_examples=30, deadline=None)
def test_the_numbers_of_nodes_decide_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    topology = some_map(rng, 6)
    links = some_walk(rng, topology, 3)
    order = rng.permutation(len(topology.nodes))
    renamed = {topology.nodes[k].id: 1_000 + rank for rank, k in enumerate(order)}
    nodes = tuple(replace(topology.nodes[k], id=renamed[topology.nodes[k].id]) for k in order)
    edges = tuple(
        replace(one, start=renamed[one.end], end=renamed[one.start], way=one.way[::-1])
        for one in topology.edges[::-1]
    )
    one = chain_of(topology, links, ChainParams())
    other = chain_of(TopologicalMap("", nodes, edges), links, ChainParams())
    assert one.candidates.log_weights == pytest.approx(other.candidates.log_weights, abs=1e-6)
    assert one.candidates.poses == pytest.approx(other.candidates.poses, abs=1e-6, nan_ok=True)
    assert [renamed.get(k, NOWHERE) for k in one.nodes.tolist()] == other.nodes.tolist()
    assert one.is_unique == other.is_unique


@given(SEEDS)
@settings(max_examples=30, deadline=None)
def test_a_further_link_never_brings_back_what_was_given_up(seed: int) -> None:
    rng = np.random.default_rng(seed)
    topology = some_map(rng, 8)
    links = some_walk(rng, topology, 4)
    params = ChainParams(prune=6.0, most_missed=1)
    chain = NodeChain.over(topology, params)
    for link in links:
        before, places_before = chain.candidates, chain.candidates.places
        chain.add(link)
        nodes = chain.places.nodes
        for place, parent in zip(chain.candidates.places, chain.candidates.parents, strict=True):
            assert 0 <= parent < len(before)
            origin = places_before[parent]
            if origin != NOWHERE:
                start, end = int(nodes[origin]), int(nodes[place])
                assert edges_between(topology, start, end) <= params.most_missed + 1
            elif place != NOWHERE:
                assert NOWHERE in places_before


@given(SEEDS)
@settings(max_examples=30, deadline=None)
def test_shares_sum_to_one_and_fall(seed: int) -> None:
    rng = np.random.default_rng(seed)
    topology = some_map(rng, 5)
    chain = chain_of(topology, some_walk(rng, topology, 3), ChainParams())
    assert chain.candidates.shares.sum() == pytest.approx(1.0)
    assert np.all(np.diff(chain.candidates.log_weights) <= 1e-9)
    assert np.isfinite(chain.candidates.log_weights).all()
    assert chain.candidates.covariances == pytest.approx(
        chain.candidates.covariances.transpose(0, 2, 1), abs=1e-9
    )


@given(SEEDS, st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(-np.pi, np.pi))
@settings(max_examples=20, deadline=None)
def test_where_the_map_lies_decides_nothing(seed: int, x: float, y: float, theta: float) -> None:
    rng = np.random.default_rng(seed)
    topology = some_map(rng, 4)
    links = some_walk(rng, topology, 3)
    frame = np.array([x, y, theta])
    nodes = tuple(
        replace(node, pose=se2.compose(frame, node.pose), features=node.features.moved(frame))
        for node in topology.nodes
    )
    edges = tuple(replace(one, way=se2.transform_points(frame, one.way)) for one in topology.edges)
    here = chain_of(topology, links, ChainParams())
    there = chain_of(TopologicalMap("", nodes, edges), links, ChainParams())
    assert np.sort(here.candidates.log_weights) == pytest.approx(
        np.sort(there.candidates.log_weights), abs=1e-6
    )
