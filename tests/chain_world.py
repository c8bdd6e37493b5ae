"""Corridors drawn as text, and robots that go along them from node to node."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.topology.features import Features
from pilotage.topology.node_chains.candidates import Link
from pilotage.topology.node_chains.chain import NodeChain
from pilotage.topology.topological_map import Edge, Node, TopologicalMap

HALF_WIDTH = 1.2
"""m from the middle line of a corridor to its walls."""

BOUND_WITHIN = 3.0
"""m along the corridor to the features that a node is bound to."""

DOOR, CORNER, PASSAGE = 1, 0, 2


def features(kind: int, poses: ArrayLike, width: float = 0.9) -> Features:
    """Features of one kind, known to 2 cm."""
    poses = np.asarray(poses, float).reshape(-1, 3)
    count = len(poses)
    widths = np.full(count, np.nan if kind == CORNER else width)
    return Features(np.full(count, kind), poses, widths, np.tile(4e-4 * np.eye(2), (count, 1, 1)))


def corridor(upper: str, lower: str) -> TopologicalMap:
    """A corridor along x, a metre to a letter: `d` a door, `c` a corner, `p` a passage.

    A node lies on the middle line wherever there is a door or a passage on either side.
    """
    found = Features.joined([_side(upper, 1.0), _side(lower, -1.0)])
    marks = range(max(len(upper), len(lower)))
    stops = [x for x in marks if {upper[x : x + 1], lower[x : x + 1]} & {"d", "p"}]
    nodes = [
        Node(
            k,
            "node",
            f"node {k}",
            np.array([float(x), 0.0, 0.0]),
            found.chosen(np.abs(found.poses[:, 0] - x) <= BOUND_WITHIN),
        )
        for k, x in enumerate(stops)
    ]
    return TopologicalMap("corridor", tuple(nodes), tuple(_edges(nodes)))


def _side(letters: str, side: float) -> Features:
    parts = []
    for kind, letter in ((DOOR, "d"), (CORNER, "c"), (PASSAGE, "p")):
        along = [float(x) for x, mark in enumerate(letters) if mark == letter]
        facing = -side * np.pi / 2.0
        parts.append(features(kind, [(x, side * HALF_WIDTH, facing) for x in along]))
    return Features.joined(parts)


def _edges(nodes: Sequence[Node]) -> list[Edge]:
    return [edge(len(nodes) + k, nodes[k], nodes[k + 1]) for k in range(len(nodes) - 1)]


def edge(number: int, start: Node, end: Node) -> Edge:
    """A straight edge between two nodes."""
    way = np.array([start.pose[:2], end.pose[:2]])
    length = float(np.hypot(*(way[1] - way[0])))
    return Edge(number, start.id, end.id, "corridor", length, way)


def seen_at(topology: TopologicalMap, pose: ArrayLike, reach: float = 3.0) -> Features:
    """All features of the map that lie ahead of and near a pose, in base_link, without noise."""
    everything = Features.joined([node.features for node in topology.nodes])
    _, first = np.unique(everything.poses.round(6), axis=0, return_index=True)
    near = everything.chosen(first).moved(se2.inverse(pose))
    x, y, _ = near.poses.T
    return near.chosen((np.hypot(x, y) <= reach) & (np.abs(np.arctan2(y, x)) <= np.pi / 2.0))


def noisy(seen: Features, rng: np.random.Generator, detection: float = 0.9) -> Features:
    """The same as a laser would see them."""
    seen = seen.chosen(rng.random(len(seen)) < detection)
    poses = seen.poses + rng.normal(0.0, [0.03, 0.03, 0.05], seen.poses.shape)
    widths = seen.widths + rng.normal(0.0, 0.03, len(seen))
    return Features(seen.kinds, poses, widths, seen.covariances + 9e-4 * np.eye(2))


ODOMETRY = np.diag([0.03, 0.03, 0.02]) ** 2


def walk(
    chain: NodeChain,
    topology: TopologicalMap,
    poses: Sequence[ArrayLike],
    rng: np.random.Generator | None = None,
) -> list[NDArray[np.float64]]:
    """Let a robot arrive at poses one after the other; return them. Without `rng`, no noise."""
    arrived: list[NDArray[np.float64]] = []
    for pose in poses:
        at = np.asarray(pose, float)
        seen = seen_at(topology, at)
        moved = se2.between(arrived[-1], at) if arrived else np.zeros(3)
        if rng is not None:
            seen, moved = noisy(seen, rng), moved + rng.normal(0.0, [0.03, 0.03, 0.02])
        chain.add(Link(seen, moved, ODOMETRY))
        arrived.append(at)
    return arrived
