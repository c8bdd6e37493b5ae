"""A topological map as chains of nodes are searched in it: arrays, made once per map."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.topology.features import Features
from pilotage.topology.node_chains.kernels import Bound
from pilotage.topology.node_chains.ways import distinct, leaving, places_along
from pilotage.topology.topological_map import TopologicalMap


@dataclass(frozen=True, eq=False)
class ChainMap:
    """Places: each node, each way round that a robot may arrive; then places along the edges.

    `ids` (n,) of the nodes; `nodes` (m,) index of each place's node, rising for the places at
    nodes, the nearest for those along edges; `at_node` (m,); `poses` (m, 3) of base_link expected
    there, map frame; `bound`: the nodes' features; `links` (k, 2): nodes joined by an edge, both
    ways.
    """

    ids: NDArray[np.int64]
    nodes: NDArray[np.int64]
    at_node: NDArray[np.bool_]
    poses: NDArray[np.float64]
    bound: Bound
    links: NDArray[np.int64]

    @classmethod
    def of(cls, topology: TopologicalMap) -> "ChainMap":
        """Return the places of a map, in the order of its nodes and of its edges."""
        index = {node.id: k for k, node in enumerate(topology.nodes)}
        joined = [(index[edge.start], index[edge.end]) for edge in topology.edges]
        links = np.array(joined, np.int64).reshape(-1, 2)
        rounds = _rounds(topology, links)
        nodes = np.repeat(np.arange(len(rounds)), [len(each) for each in rounds])
        poses = topology.places[nodes]
        poses[:, 2] = np.concatenate([np.empty(0), *rounds])
        beside, between = _between(topology, links)
        at_node = np.arange(len(nodes) + len(beside)) < len(nodes)
        return cls(
            np.array([node.id for node in topology.nodes], np.int64),
            np.concatenate([nodes, beside]),
            at_node,
            np.concatenate([poses, between]),
            _bound(topology),
            np.concatenate([links, links[:, ::-1]]),
        )

    @cached_property
    def _firsts(self) -> NDArray[np.int64]:
        """Where each node's places begin (n + 1,)."""
        return np.searchsorted(self.nodes[self.at_node], np.arange(len(self.ids) + 1))

    def reached(self, starts: NDArray[np.int64], most: int) -> NDArray[np.int64]:
        """Return the nodes that can be reached from nodes (k,) over at most so many edges.

        Rows (index of the start in `starts`, node, least number of edges); the start itself is
        reached over none.
        """
        reached = np.stack([np.arange(len(starts)), starts, np.zeros_like(starts)], axis=1)
        frontier = reached
        for edges in range(1, most + 1):
            rows, targets = self._neighbours(frontier[:, 1])
            steps = np.stack([frontier[rows, 0], targets, np.full_like(targets, edges)], axis=1)
            reached = np.concatenate([reached, steps])
            key = reached[:, 0] * len(self.ids) + reached[:, 1]
            # The first of equal keys is the one over the fewest edges.
            _, first = np.unique(key, return_index=True)
            frontier = reached[first[reached[first, 2] == edges]]
            reached = reached[first]
        return reached

    def nearest(self, reached: NDArray[np.int64], poses: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return for each pose (k, 3) a place at the nearest node that `reached` has of its start.

        Of its ways round that which the pose heads for.
        """
        starts, nodes, _ = reached.T
        x, y, _ = (self.poses[self._firsts[nodes]] - poses[starts]).T
        order = np.lexsort((nodes, np.round(np.hypot(x, y), 9), starts))
        _, first = np.unique(starts[order], return_index=True)
        places, of_pose = self.places_of(nodes[order[first]])
        off = np.abs(wrap(self.poses[places, 2] - poses[of_pose, 2]))
        order = np.lexsort((off, of_pose))
        _, first = np.unique(of_pose[order], return_index=True)
        nearest: NDArray[np.int64] = places[order[first]]
        return nearest

    def places_of(self, nodes: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return for nodes (k,) their places, and of which of the k each is one."""
        counts = np.diff(self._firsts)[nodes]
        return _runs(self._firsts[nodes], counts), np.repeat(np.arange(len(nodes)), counts)

    def _neighbours(self, nodes: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return of which of nodes (k,) each neighbour is one, and the neighbours."""
        links, firsts = self._sorted_links
        counts = np.diff(firsts)[nodes]
        return np.repeat(np.arange(len(nodes)), counts), links[_runs(firsts[nodes], counts), 1]

    @cached_property
    def _sorted_links(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The links by their start, and where each node's begin (n + 1,)."""
        links = self.links[np.lexsort(self.links.T[::-1])]
        return links, np.searchsorted(links[:, 0], np.arange(len(self.ids) + 1))


def _runs(firsts: NDArray[np.int64], counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return first, first + 1, ... for each of several runs, one after the other."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) + np.repeat(firsts - ends + counts, counts)


def _bound(topology: TopologicalMap) -> Bound:
    features = Features.joined([node.features for node in topology.nodes])
    counts = [len(node.features) for node in topology.nodes]
    variances = np.trace(features.covariances, axis1=1, axis2=2) / 2.0
    firsts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    return Bound(features.kinds, features.poses, features.widths, variances, firsts)


def _rounds(topology: TopologicalMap, links: NDArray[np.int64]) -> list[NDArray[np.float64]]:
    """Return the ways round each node: along it, and along its edges, there and back."""
    directions = [[node.pose[2], node.pose[2] + np.pi] for node in topology.nodes]
    for edge, (start, end) in zip(topology.edges, links, strict=True):
        out, back = leaving(edge)
        directions[start] += [out, out + np.pi]
        directions[end] += [back, back + np.pi]
    return [distinct(each) for each in directions]


def _between(
    topology: TopologicalMap, links: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the places along all edges: the node (k,) each is nearest to, and poses (k, 3)."""
    nodes, poses = [np.empty(0, np.int64)], [np.empty((0, 3))]
    for edge, (start, end) in zip(topology.edges, links, strict=True):
        along, is_nearer = places_along(edge)
        nodes.append(np.where(is_nearer, start, end))
        poses.append(along)
    return np.concatenate(nodes), np.concatenate(poses)
