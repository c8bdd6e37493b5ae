"""Finds the robot on the topological map: at which node it is, and where when nobody knows."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.grid import OccupancyMap
from pilotage.topology.at_nodes.arrival import Arrival, NodeWatch, Now
from pilotage.topology.features import Features
from pilotage.topology.node_chains.map import ChainMap
from pilotage.topology.seeing.scan_fit import scan_fits
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.topological_map import Node, TopologicalMap
from pilotage.topology.unknown_start import UnknownStart

Cause = Literal["corrected", "recovered", "chain"]

CORRECTION = (0.3, 0.17)
"""m and rad beyond which a pose was not corrected but found again: tracking had failed."""


@dataclass(frozen=True)
class Sight:
    """What is `seen` in base_link in a scan, `view`, at `stamp` [s]; `odom_from_base` (3,).

    `map_from_base` (3,) with its `covariance` (3, 3) as it is estimated; None if nobody is sure.
    """

    stamp: float
    view: ScanView
    seen: Features
    odom_from_base: NDArray[np.float64]
    map_from_base: NDArray[np.float64] | None
    covariance: NDArray[np.float64] | None


@dataclass(frozen=True)
class FoundPose:
    """A pose (3,) of base_link in map, found at a node by so many `matched` features."""

    node: int
    pose: NDArray[np.float64]
    covariance: NDArray[np.float64]
    matched: int
    cause: Cause


@dataclass(frozen=True)
class Finding:
    """What one scan tells.

    `node`: the one that the robot is at, reached just now if `is_new`; `seen` (in map, from
    `pose` (3,)) and `expected`: its features seen again, pair by pair.
    """

    node: Node | None = None
    is_new: bool = False
    pose: NDArray[np.float64] | None = None
    seen: Features | None = None
    expected: Features | None = None
    found: FoundPose | None = None


class Finder:
    """Follows the robot on one topological map.

    A pose that is found is told only if the whole scan fits the occupancy map there, if there is
    one: a robot that was carried away sees alike doors where odometry cannot have brought it.
    """

    def __init__(self, world: TopologicalMap, cells: OccupancyMap | None = None) -> None:
        self._world, self._cells = world, cells
        self._nodes = {node.id: node for node in world.nodes}
        self._start = UnknownStart(ChainMap.of(world))
        self.forget()

    def forget(self) -> None:
        """Begin anew: odometry is counted anew."""
        self._watch = NodeWatch(self._world)
        self._start.forget()

    def look(self, sight: Sight) -> Finding:
        """Return what a scan tells; call for every scan."""
        here = sight.map_from_base
        has_failed = here is None
        pose = np.zeros(3) if here is None else here
        now = Now(pose, sight.covariance, sight.odom_from_base, sight.seen, has_failed)
        arrival = self._watch.update(now)
        by_chain = self._by_chain(sight)
        if arrival is None:
            return Finding(found=by_chain)
        return self._at_node(arrival, sight, by_chain)

    def _by_chain(self, sight: Sight) -> FoundPose | None:
        if sight.map_from_base is not None:
            if self._start.is_begun:
                self._start.forget()
            return None
        found = self._start.add(sight.stamp, sight.odom_from_base, sight.seen)
        if found is None or not self._fits(found.pose, sight):
            return None
        return FoundPose(found.node, found.pose, found.covariance, found.matched, "chain")

    def _fits(self, pose: NDArray[np.float64], sight: Sight) -> bool:
        return self._cells is None or scan_fits(self._cells, pose, sight.view)

    def _at_node(self, arrival: Arrival, sight: Sight, by_chain: FoundPose | None) -> Finding:
        node, match = self._nodes[arrival.node], arrival.match
        if match is None:
            return Finding(node, arrival.is_new, sight.map_from_base, found=by_chain)
        found = by_chain
        if arrival.relocalizes and not self._fits(match.pose, sight):
            self._watch = NodeWatch(self._world)
            return Finding(found=by_chain)
        if arrival.relocalizes:
            cause = _cause(sight.map_from_base, match.pose)
            count = len(match.pairs)
            found = FoundPose(node.id, match.pose, match.covariance, count, cause)
        is_kept = sight.map_from_base is not None and not arrival.relocalizes
        pose = sight.map_from_base if is_kept else match.pose
        assert pose is not None  # noqa: S101 - an estimate that is kept is one
        seen = arrival.seen.chosen(match.pairs[:, 0]).moved(pose)
        expected = node.features.chosen(match.pairs[:, 1])
        return Finding(node, arrival.is_new, pose, seen, expected, found)


def _cause(estimate: NDArray[np.float64] | None, pose: NDArray[np.float64]) -> Cause:
    if estimate is None:
        return "recovered"
    off = pose - estimate
    is_near = np.hypot(off[0], off[1]) <= CORRECTION[0] and abs(wrap(off[2])) <= CORRECTION[1]
    return "corrected" if is_near else "recovered"
