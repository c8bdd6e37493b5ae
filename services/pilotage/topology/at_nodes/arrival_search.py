"""Which node the robot is at when its pose has been lost: odometry and the map say which may be."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.topology.at_nodes.matching import MatchParams, NodeMatch, match_features
from pilotage.topology.at_nodes.matching_hypotheses import Window
from pilotage.topology.features import Features
from pilotage.topology.routes.route import Graph
from pilotage.topology.topological_map import Node, TopologicalMap


@dataclass(frozen=True)
class SearchParams:
    """How far the robot may have got since it last knew where it was; lengths in m."""

    window: Window = (2.5, 0.6)
    """How far from a node the robot may be, and by how much (rad) a collision turned it."""
    slip: float = 0.15
    """Of the way driven, by which odometry may err."""
    shift: float = 0.8
    """By which a collision may have moved the robot."""
    farthest: float = 25.0
    """After so long a way without a node, too many places are possible: nothing is sought."""


@dataclass(frozen=True)
class Departure:
    """Where the robot last knew itself: at `node`, at `pose` (3,) in map and `odom` (3,)."""

    node: int
    pose: NDArray[np.float64]
    odom: NDArray[np.float64]


class NodeSearch:
    """Looks for the robot at the nodes that it can have reached."""

    def __init__(self, topology: TopologicalMap, params: SearchParams, match: MatchParams) -> None:
        self.params, self.match = params, match
        self._nodes = {node.id: node for node in topology.nodes}
        self._index = {number: index for index, number in enumerate(self._nodes)}
        lengths = [
            (self._index[edge.start], self._index[edge.end], edge.length) for edge in topology.edges
        ]
        self._ways = Graph(len(self._nodes), lengths, landmarks=0)

    def find(
        self, departure: Departure, driven: float, odom: NDArray[np.float64], seen: Features
    ) -> tuple[int, NodeMatch] | None:
        """Return the node and the match if one place, and only one, explains what is seen.

        Args:
            departure: where the robot last knew itself.
            driven: way since then by odometry, m.
            odom: odom_from_base (3,) now.
            seen: features in base_link.
        """
        if driven > self.params.farthest:
            return None
        moved = se2.between(departure.odom, odom)
        heading = float(departure.pose[2] + moved[2])
        found = [
            (node.id, match)
            for node in self._reachable(departure.node, driven)
            if (match := self._matched(node, heading, seen)) is not None
            and self._could_be(departure, match.pose, float(np.hypot(*moved[:2])), driven)
        ]
        return self._only_one(found)

    def _reachable(self, start: int, driven: float) -> list[Node]:
        """Return the nodes that lie so far from a node along the edges, or nearer."""
        limit = driven * (1.0 + self.params.slip) + self.params.shift + self.params.window[0]
        lengths = self._ways.costs_from(self._index[start])
        return [node for node in self._nodes.values() if lengths[self._index[node.id]] <= limit]

    def _matched(self, node: Node, heading: float, seen: Features) -> NodeMatch | None:
        prior = np.array([*node.pose[:2], wrap(heading)])
        return match_features(seen, node.features, prior, self.params.window, self.match)

    def _could_be(
        self, departure: Departure, pose: NDArray[np.float64], moved: float, driven: float
    ) -> bool:
        """Say whether a pose is as far from the departure as odometry says, as the crow flies."""
        apart = float(np.hypot(*(pose[:2] - departure.pose[:2])))
        return abs(apart - moved) <= self.params.shift + self.params.slip * driven

    def _only_one(self, found: list[tuple[int, NodeMatch]]) -> tuple[int, NodeMatch] | None:
        """Return the best match if no other node's speaks nearly as well for another pose."""
        if not found:
            return None
        number, best = max(found, key=lambda one: one[1].score)
        rivals = [other.score for _, other in found if self._differs(other.pose, best.pose)]
        rival = max([best.rival_score, *rivals])
        is_clear = best.score - rival >= self.match.least_lead
        return (number, best) if is_clear and rival <= self.match.best_share * best.score else None

    def _differs(self, one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
        off = one - other
        return bool(
            np.hypot(off[0], off[1]) > self.match.apart[0]
            or abs(wrap(float(off[2]))) > self.match.apart[1]
        )
