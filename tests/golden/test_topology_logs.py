"""Topological maps built live from real lasers, in an office floor and in a long corridor.

The claims are modest: nobody has labelled these floors. What is counted was looked at in pictures
first (tests/benchmarks/topology_from_logs.py draws them).
"""

from functools import cache
from pathlib import Path

import networkx as nx
import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.topology.at_nodes.matching import match_features
from pilotage.topology.seeing.seen_features_memory import SeenMemory
from pilotage.topology.topological_map import TopologicalMap
from topology_logs import WEAN_START, Drive, built, cut, fr079, localized, mapped, wean

pytestmark = [pytest.mark.data, pytest.mark.timeout(180)]

WINDOW = (0.7, 0.45)
OFF = (0.5, np.deg2rad(20.0))
"""By how much the prior is wrong, m and rad."""


@cache
def office(folder: Path) -> Drive:
    """The corridor up and down, and the first offices on its way back."""
    return mapped(cut(fr079(folder), 0.0, 330.0))


@cache
def office_map(folder: Path) -> TopologicalMap:
    return built(office(folder)).topology("fr079")


@cache
def hall(folder: Path) -> Drive:
    return localized(wean(folder), folder / "wean_hall" / "wean.dat.gz", WEAN_START)


@cache
def hall_map(folder: Path) -> TopologicalMap:
    return built(hall(folder)).topology("wean")


def graph_of(topology: TopologicalMap) -> "nx.Graph[int]":
    graph: nx.Graph[int] = nx.Graph()
    graph.add_nodes_from(node.id for node in topology.nodes)
    graph.add_edges_from((edge.start, edge.end) for edge in topology.edges)
    return graph


def share_free(drive: Drive, topology: TopologicalMap) -> float:
    """Return which share of points along the edges does not lie in a wall."""
    points = np.concatenate(
        [
            begin + share * (end - begin)
            for edge in topology.edges
            for begin, end in zip(edge.way[:-1], edge.way[1:], strict=True)
            for share in [np.linspace(0.0, 1.0, 20)[:, None]]
        ]
    )
    geometry = drive.world.geometry
    local = se2.transform_points(se2.inverse(geometry.origin), points)
    cells = np.floor(local[:, ::-1] / geometry.resolution).astype(np.int64)
    return float(np.mean(drive.world.cells[cells[:, 0], cells[:, 1]] < 65))


def test_every_office_that_the_robot_entered_has_a_door(data_dir: Path) -> None:
    doors = [node for node in office_map(data_dir).nodes if node.kind == "door"]
    # Gone through: one at the end, the fire door, and those of four offices.
    assert 5 <= len(doors) <= 8


def test_the_office_map_is_one_piece_and_keeps_off_the_walls(data_dir: Path) -> None:
    topology = office_map(data_dir)
    assert nx.is_connected(graph_of(topology))
    assert share_free(office(data_dir), topology) > 0.97


def test_nodes_are_few_and_apart(data_dir: Path) -> None:
    topology = office_map(data_dir)
    driven = float(np.hypot(*np.diff(office(data_dir).poses[:, :2], axis=0).T).sum())
    assert 0.1 * driven < len(topology.nodes) < 0.6 * driven
    apart = np.hypot(*np.moveaxis(topology.places[:, None] - topology.places[None], 2, 0)[:2])
    np.fill_diagonal(apart, np.inf)
    assert np.mean(apart.min(axis=1) > 0.8) > 0.85


def test_the_corridor_is_told_from_the_offices(data_dir: Path) -> None:
    topology = office_map(data_dir)
    kinds = {edge.kind for edge in topology.edges}
    assert {"corridor", "room", "door"} <= kinds
    corridor = np.concatenate([edge.way for edge in topology.edges if edge.kind == "corridor"])
    # It runs 35 m or so from east to west, a little askew.
    assert np.ptp(corridor[:, 0]) > 20.0
    assert np.ptp(corridor[:, 1]) < 7.0


def test_most_nodes_of_the_office_bind_enough_features(data_dir: Path) -> None:
    counts = [len(node.features) for node in office_map(data_dir).nodes]
    assert np.median(counts) >= 4


def test_wrong_poses_are_made_good_at_nodes_and_hardly_ever_made_worse(data_dir: Path) -> None:
    drive, topology = office(data_dir), office_map(data_dir)
    rng, memory = np.random.default_rng(0), SeenMemory()
    right = wrong = 0
    for k, (_, pose, seen) in enumerate(drive.seen()):
        scan = drive.scans[k]
        assert scan.odom_pose is not None
        remembered = memory.add(np.array(scan.odom_pose), seen)
        apart = np.hypot(*(topology.places[:, :2] - pose[:2]).T)
        if apart.min() > 1.0 or k % 3:
            continue
        bearing = rng.uniform(-np.pi, np.pi)
        off = np.array([*OFF[0] * np.array([np.cos(bearing), np.sin(bearing)]), OFF[1]])
        bound = topology.nodes[int(np.argmin(apart))].features
        match = match_features(remembered, bound, pose + off, WINDOW)
        if match is None or not match.is_clear or len(match.pairs) < 3:
            continue
        is_right = np.hypot(*(match.pose - pose)[:2]) < 0.3
        is_right &= abs(wrap(float(match.pose[2] - pose[2]))) < 0.15
        right, wrong = right + is_right, wrong + (not is_right)
    assert right >= 60
    assert wrong <= 0.02 * right


def test_the_hall_is_a_corridor_with_doors(data_dir: Path) -> None:
    topology = hall_map(data_dir)
    assert nx.is_connected(graph_of(topology))
    assert {edge.kind for edge in topology.edges} <= {"corridor", "passage", "door"}
    assert 5 <= len(topology.nodes) <= 16
    features = built(hall(data_dir)).features
    assert np.sum(features.kinds != 0) >= 3
    assert np.sum(features.kinds == 0) >= 8


def test_ways_in_the_hall_keep_off_its_walls(data_dir: Path) -> None:
    assert share_free(hall(data_dir), hall_map(data_dir)) > 0.97
