"""The topological map built while driving, from where the robot is and what it sees there."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.angles import wrap
from pilotage.topology.features import Features
from pilotage.topology.from_drive.landmarks import LandmarkParams, Landmarks
from pilotage.topology.from_drive.nodes import Leg, NodeParams, NodeWalk, Placed
from pilotage.topology.from_drive.record import BindParams, Record
from pilotage.topology.from_drive.regions import leg_kinds
from pilotage.topology.from_drive.trail import Trail, TrailParams
from pilotage.topology.from_drive.ways import simplified
from pilotage.topology.topological_map import Edge, Node, NodeKind, TopologicalMap

MOVED = (0.1, 0.05)
"""m and rad by which a corrected place must have moved for all to be built anew."""


@dataclass(frozen=True)
class LiveParams:
    """How a map is built while driving."""

    trail: TrailParams = field(default_factory=TrailParams)
    landmarks: LandmarkParams = field(default_factory=LandmarkParams)
    bind: BindParams = field(default_factory=BindParams)
    nodes: NodeParams = field(default_factory=NodeParams)
    way_tolerance: float = 0.08
    """m that an edge's way may cut off the bends of the way driven."""


class LiveBuilder:
    """Takes in poses and features in the order of time; a map can be had at any moment.

    Nodes keep their ids while the robot drives on. They change only when poses are corrected by
    more than a little, and at `finish`, which looks back over all that was seen.
    """

    def __init__(self, params: LiveParams | None = None) -> None:
        self.params = params or LiveParams()
        self._trail = Trail(self.params.trail)
        self._forget()

    def add(self, stamp: float, map_from_base: ArrayLike, seen: Features) -> bool:
        """Take in one scan's features (base_link) at a time [s]; say if a node or edge is new."""
        if not self._trail.add(stamp, map_from_base, seen):
            return False
        known = len(self._walk.nodes), len(self._walk.legs)
        self._take_in(len(self._trail) - 1)
        self._walk.advance(self._record())
        return known != (len(self._walk.nodes), len(self._walk.legs))

    def correct(self, stamps: ArrayLike, poses: ArrayLike) -> bool:
        """Move the trail to corrected poses (k, 3) at rising stamps (k,) [s].

        Says whether anything moved by enough for the map to be built anew.
        """
        corrected = self._trail.corrected(np.asarray(stamps, float), np.asarray(poses, float))
        off = corrected.poses - self._trail.poses
        far = np.hypot(off[:, 0], off[:, 1]) > MOVED[0]
        if not (far | (np.abs(wrap(off[:, 2])) > MOVED[1])).any():
            return False
        self._trail = corrected
        self._forget()
        for stop in range(len(self._trail)):
            self._take_in(stop)
        self._walk.advance(self._record())
        return True

    def finish(self) -> None:
        """Set the nodes anew, now that all features along the whole way are known."""
        self._walk = NodeWalk(self.params.nodes)
        self._walk.advance(self._record(), to_the_end=True)

    @property
    def features(self) -> Features:
        """All certain features in map, bound or not."""
        return self._landmarks.features.chosen(self._landmarks.is_certain)

    def topology(self, map_id: str) -> TopologicalMap:
        """Return the map as far as it is built."""
        record = self._record()
        placed, driven = self._walk.nodes, self._walk.legs
        ways = [self._way(record, leg) for leg in driven]
        kept = _shortest(driven, ways)
        kinds = leg_kinds(placed, [driven[k] for k in kept], record.poses)
        edges = [
            Edge(len(placed) + n, driven[k].start, driven[k].end, kind, _length(ways[k]), ways[k])
            for n, (k, kind) in enumerate(zip(kept, kinds, strict=True))
        ]
        ends = {end for edge in edges if edge.kind == "corridor" for end in (edge.start, edge.end)}
        nodes = [
            self._node(record, n, node, is_inside=n not in ends) for n, node in enumerate(placed)
        ]
        return TopologicalMap(map_id, tuple(nodes), tuple(edges))

    def _forget(self) -> None:
        self._landmarks = Landmarks(self.params.landmarks)
        self._sightings: list[NDArray[np.int64]] = []
        self._walk = NodeWalk(self.params.nodes)

    def _take_in(self, stop: int) -> None:
        seen = self._trail.stops[stop].seen.moved(self._trail.poses[stop])
        self._sightings.append(self._landmarks.add(seen))

    def _record(self) -> Record:
        return Record(
            self._trail.poses,
            self._trail.lengths,
            self._landmarks.features,
            self._landmarks.is_certain,
            self._sightings,
            self.params.bind,
        )

    def _node(self, record: Record, number: int, node: Placed, *, is_inside: bool) -> Node:
        """Return a node with what is seen from it; a bend inside a room is no corridor's corner."""
        kind: NodeKind = "node" if node.kind == "corner" and is_inside else node.kind
        bound = record.features.chosen(record.seen_near(node.stop))
        return Node(number, kind, f"{kind} {number}", node.pose, bound)

    def _way(self, record: Record, leg: Leg) -> NDArray[np.float64]:
        """Return the way (k, 2) of a leg from node to node."""
        way = record.poses[leg.first : leg.last + 1, :2].copy()
        ends = self._walk.nodes[leg.start].pose[:2], self._walk.nodes[leg.end].pose[:2]
        return simplified(np.vstack([ends[0], way, ends[1]]), self.params.way_tolerance)


def _shortest(legs: list[Leg], ways: list[NDArray[np.float64]]) -> list[int]:
    """Return which leg is the shortest between each two nodes, in the order of first driving."""
    best: dict[tuple[int, int], int] = {}
    for number, leg in enumerate(legs):
        pair = (min(leg.start, leg.end), max(leg.start, leg.end))
        known = best.setdefault(pair, number)
        if _length(ways[number]) < _length(ways[known]):
            best[pair] = number
    return list(best.values())


def _length(way: NDArray[np.float64]) -> float:
    return float(np.hypot(*np.diff(way, axis=0).T).sum())
