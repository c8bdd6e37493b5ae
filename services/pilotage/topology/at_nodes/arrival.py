"""When the robot has reached a node, and whether its features say that the pose is wrong.

While tracking works a node is reached by the estimate; what is seen there is matched with what
the node is bound to. Where the two disagree, or tracking has failed (collision, crowd), the
features decide: near the node, or at any node that odometry says can have been reached, so that a
wrong pose does not hide the right node (Zhuang et al. 2005, section 3.2).
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.topology.at_nodes.arrival_search import Departure, NodeSearch, SearchParams
from pilotage.topology.at_nodes.matching import (
    MatchParams,
    NodeMatch,
    expected_in_sight,
    match_features,
)
from pilotage.topology.at_nodes.matching_hypotheses import Window
from pilotage.topology.features import Features
from pilotage.topology.seeing.seen_features_memory import SeenMemory
from pilotage.topology.topological_map import Node, TopologicalMap


@dataclass(frozen=True)
class ArrivalParams:
    """When a node is reached, and when its features are trusted more than the estimate."""

    reach: float = 0.8
    """m from a node at which it is reached."""
    leave: float = 1.2
    """m from it at which it is left."""
    window: Window = (0.7, 0.5)
    """m and rad by which the estimate may be wrong while it is not known to be."""
    least_pairs: int = 3
    """Two features fit by chance too easily."""
    least_off: Window = (0.12, 0.05)
    """m or rad below which an estimate is left alone."""
    surprise: float = 11.3
    """Squared Mahalanobis distance that 99 % of right estimates stay below."""
    least_gain: float = 2.0
    """Pairs by which the features must fit better elsewhere than where the estimate says."""
    agreeing: int = 2
    """Scans that must say the same before the pose is changed."""
    agreement: Window = (0.25, 0.1)
    """m and rad within which two scans say the same."""
    tight: Window = (0.25, 0.12)
    """m and rad by which the estimate may be wrong between nodes if it is right at all."""
    sight: float = 3.0
    """m from a node up to which its features ought to be seen where the estimate says."""
    blind: int = 5
    """Scans without the features nearby after which tracking is taken to have failed."""
    match: MatchParams = field(default_factory=MatchParams)
    search: SearchParams = field(default_factory=SearchParams)


@dataclass(frozen=True)
class Now:
    """One scan's moment.

    `map_from_base` (3,) as estimated, NaN if nobody knows, with its `covariance` (3, 3) if known;
    `odom_from_base` (3,); `seen` in base_link; `has_failed`: the localizer says that it is lost.
    """

    map_from_base: NDArray[np.float64]
    covariance: NDArray[np.float64] | None
    odom_from_base: NDArray[np.float64]
    seen: Features
    has_failed: bool = False


@dataclass(frozen=True)
class Arrival:
    """The robot is at `node`; `is_new` on reaching it.

    `match` of its features, None without any pair; its pairs are of `seen` (base_link), which is
    what was seen over the last metre. `relocalizes`: the pose of the match is to replace the
    estimate.
    """

    node: int
    is_new: bool
    match: NodeMatch | None
    relocalizes: bool
    seen: Features


class NodeWatch:
    """Follows the robot from node to node of one map."""

    def __init__(self, topology: TopologicalMap, params: ArrivalParams | None = None) -> None:
        self.params = params or ArrivalParams()
        self._nodes = {node.id: node for node in topology.nodes}
        self._ids = np.array([node.id for node in topology.nodes], np.int64)
        self._places = topology.places
        self._search = NodeSearch(topology, self.params.search, self.params.match)
        self._memory = SeenMemory()
        self._at: int | None = None
        self._departure: Departure | None = None
        self._driven = 0.0
        self._last_odom: NDArray[np.float64] | None = None
        self._blind = 0
        self._agreeing: list[NDArray[np.float64]] = []

    def update(self, now: Now) -> Arrival | None:
        """Return the node that the robot is at, if at one; call for every scan."""
        self._drive(now.odom_from_base)
        # One scan shows two or three features, the last metre twice as many.
        now = replace(now, seen=self._memory.add(now.odom_from_base, now.seen))
        is_lost = now.has_failed or not np.isfinite(now.map_from_base).all()
        if is_lost or self._blind >= self.params.blind:
            found = self._found(now)
            # Without a word from elsewhere an estimate is followed, however little supports it.
            if found is not None or is_lost or self._agreeing:
                return found
        return self._tracked(now)

    def forget_odometry(self) -> None:
        """Begin anew after odometry was: how far the robot has come since is not known."""
        self._departure = self._last_odom = None
        self._memory.clear()
        self._agreeing.clear()

    def _drive(self, odom: NDArray[np.float64]) -> None:
        if self._last_odom is not None:
            self._driven += float(np.hypot(*(odom[:2] - self._last_odom[:2])))
        self._last_odom = odom.copy()

    def _tracked(self, now: Now) -> Arrival | None:
        """Return the node near the estimate."""
        node, is_new = self._near(now.map_from_base)
        if node is None:
            self._watch_out(now)
            return None
        match = self._match(now, node, self.params.window)
        self._notice(now, node, match)
        if match is not None and self._is_trusted(match) and not self._disagrees(now, match):
            self._depart(node.id, now.map_from_base, now.odom_from_base)
        wrong = match is not None and self._is_better(now, node, match)
        relocalizes = match is not None and self._repeats(now, match if wrong else None)
        if match is not None and relocalizes:
            self._depart(node.id, match.pose, now.odom_from_base)
        elif self._departure is None:
            self._depart(node.id, now.map_from_base, now.odom_from_base)
        return Arrival(node.id, is_new, match, relocalizes, now.seen)

    def _found(self, now: Now) -> Arrival | None:
        """Return the node whose features are seen, wherever the estimate is."""
        if self._departure is None or len(now.seen) < self.params.least_pairs:
            return None
        found = self._search.find(self._departure, self._driven, now.odom_from_base, now.seen)
        if found is None or not self._is_trusted(found[1]):
            self._agreeing.clear()
            return None
        number, match = found
        is_known = not now.has_failed and np.isfinite(now.map_from_base).all()
        if is_known and not self._is_better(now, self._nodes[number], match):
            self._blind = 0
            return None
        if not self._repeats(now, match):
            return None
        is_new, self._at = number != self._at, number
        self._depart(number, match.pose, now.odom_from_base)
        return Arrival(number, is_new, match, relocalizes=True, seen=now.seen)

    def _near(self, pose: NDArray[np.float64]) -> tuple[Node | None, bool]:
        """Return the node at a pose and whether it has just been reached."""
        apart = np.hypot(*(self._places[:, :2] - pose[:2]).T)
        if len(apart) == 0:
            return None, False
        nearest = int(np.argmin(apart))
        last = self._at
        if apart[nearest] <= self.params.reach:
            self._at = int(self._ids[nearest])
        elif last is not None and apart[self._ids == last][0] > self.params.leave:
            self._at = None
        if self._at != last:
            self._blind = 0
            self._agreeing.clear()
        return (None if self._at is None else self._nodes[self._at]), self._at != last

    def _watch_out(self, now: Now) -> None:
        """Notice between nodes that what the nearest one shows is not where it ought to be."""
        apart = np.hypot(*(self._places[:, :2] - now.map_from_base[:2]).T)
        if len(apart) and apart.min() < self.params.sight:
            node = self._nodes[int(self._ids[np.argmin(apart)])]
            self._notice(now, node, self._match(now, node, self.params.tight))

    def _match(self, now: Now, node: Node, window: Window) -> NodeMatch | None:
        return match_features(now.seen, node.features, now.map_from_base, window, self.params.match)

    def _notice(self, now: Now, node: Node, match: NodeMatch | None) -> None:
        """Count the scans in which nothing of the node is seen, though it ought to be."""
        expected = expected_in_sight(node.features, now.map_from_base, self.params.match)
        is_blind = expected.sum() >= self.params.least_pairs and (
            match is None or len(match.pairs) < 2
        )
        self._blind = self._blind + 1 if is_blind else 0

    def _is_trusted(self, match: NodeMatch) -> bool:
        return match.is_clear and len(match.pairs) >= self.params.least_pairs

    def _is_better(self, now: Now, node: Node, match: NodeMatch) -> bool:
        """Say whether a match explains by far more than the estimate, which it contradicts."""
        if not (self._is_trusted(match) and self._disagrees(now, match)):
            return False
        here = self._match(now, node, self.params.tight)
        return here is None or match.score - here.score >= self.params.least_gain

    def _disagrees(self, now: Now, match: NodeMatch) -> bool:
        """Say whether the estimate is farther from the match than both allow."""
        off = match.pose - now.map_from_base
        if not np.isfinite(off).all():
            return True
        off[2] = wrap(float(off[2]))
        least = self.params.least_off
        if np.hypot(off[0], off[1]) < least[0] and abs(off[2]) < least[1]:
            return False
        if now.covariance is None:
            return True
        spread = match.covariance + now.covariance
        return bool(off @ np.linalg.solve(spread, off) > self.params.surprise)

    def _repeats(self, now: Now, match: NodeMatch | None) -> bool:
        """Say whether enough scans in a row have put the robot at the same place."""
        if match is None:
            self._agreeing.clear()
            return False
        map_from_odom = se2.compose(match.pose, se2.inverse(now.odom_from_base))
        # Compared where the robot is: far from odom's origin a small turn looks like a long way.
        poses = [se2.compose(one, now.odom_from_base) for one in self._agreeing]
        off = np.array(poses).reshape(-1, 3) - match.pose
        apart = np.hypot(off[:, 0], off[:, 1]) > self.params.agreement[0]
        if (apart | (np.abs(wrap(off[:, 2])) > self.params.agreement[1])).any():
            self._agreeing.clear()
        self._agreeing.append(map_from_odom)
        if len(self._agreeing) < self.params.agreeing:
            return False
        self._agreeing.clear()
        return True

    def _depart(self, node: int, pose: NDArray[np.float64], odom: NDArray[np.float64]) -> None:
        """Remember where the robot knew itself."""
        self._departure = Departure(node, pose.copy(), odom.copy())
        self._driven = 0.0
        self._blind = 0
