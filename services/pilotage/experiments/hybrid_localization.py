"""The hybrid localization of Zhuang et al. 2005, section 3: walls between nodes, features at nodes.

Between nodes a Kalman filter follows the pose on the lines of walls. At a node the features bound
to it are matched, which corrects the pose, or, if tracking has failed, begins it anew. Filter and
matching are those of the localizer and of the topology server.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.experiments.corridor_ride import LASER, Look, increment_between
from pilotage.localizer.ekf_walls import Walls
from pilotage.localizer.line_ekf import GaussianPose, LineEkfParams, track
from pilotage.localizer.motion_spread import MotionSpread
from pilotage.topology.at_nodes.matching import match_features
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.seeing.seen_features import seen_features
from pilotage.topology.topological_map import Node, TopologicalMap

MOUNT = np.array([LASER.mount_x, 0.0, 0.0])
BEARINGS = LASER.bearings
ANGLES = float(BEARINGS[0]), float(BEARINGS[1] - BEARINGS[0])


PAPER_FILTER = LineEkfParams(
    motion=MotionSpread(0.02, 0.01, 0.02, 0.01), wide=float("inf"), wide_turn=float("inf")
)
"""The filter of the paper: pairs from the predicted pose alone, trusting this robot's odometry."""

OWN_FILTER = LineEkfParams()
"""The localizer's: it doubts odometry more, and tries several poses when it is in doubt."""


@dataclass(frozen=True)
class HybridParams:
    """When a node is reached, and when a match there overrules the filter."""

    filter: LineEkfParams = PAPER_FILTER
    reached: float = 1.8
    """m before a node at which it counts as reached: beside it, a laser of 180 degrees does not see
    the doors any more that the node is bound to."""
    window: tuple[float, float] = (1.5, float(np.deg2rad(35.0)))
    """m and rad by which the filter may be wrong when a node is reached."""
    floor: tuple[float, float] = (0.03, float(np.deg2rad(1.0)))
    """Standard deviations, m and rad, that a match is not more exact than."""
    disagrees: float = 16.3
    """Squared Mahalanobis distance of match and filter at which tracking has failed: 0.1 %."""
    lost_below: int = 2
    """Pairs of walls; when fewer were matched last, tracking has failed."""
    least_features: int = 2
    """Features that must be matched for tracking to begin anew: doors are alike."""


@dataclass(frozen=True)
class Tracked:
    """A cycle of the filter: `pairs` of lines and `corners` matched, `node` reached, or -1."""

    pairs: int
    corners: int
    node: int


@dataclass(frozen=True)
class Correction:
    """What a look at a node did: how many `features` were matched, and if tracking began anew."""

    features: int = 0
    began_anew: bool = False


class HybridLocalizer:
    """Passes the nodes of a corridor in the order of `topology`, from a known pose.

    `walls` are those of the map.
    """

    def __init__(
        self,
        walls: Walls,
        topology: TopologicalMap,
        start: GaussianPose,
        params: HybridParams | None = None,
    ) -> None:
        self.params = params or HybridParams()
        self.belief = start
        self.has_failed = False
        self._walls = walls
        self._nodes = topology.nodes
        self._next = 0

    def track(self, before: Look, now: Look) -> Tracked:
        """Predict, observe, predict the measurement, match, update (section 3.1)."""
        seen = Walls.of(_view(now).lines.moved(MOUNT))
        increment = increment_between(before, now)
        step = track(self.belief, increment, seen, self._walls, self.params.filter)
        self.belief = step.belief
        self.has_failed = len(step.pairs.lines) < self.params.lost_below
        return Tracked(len(step.pairs.lines), len(step.pairs.corners), self._reached())

    def correct(self, look: Look, node: int) -> Correction:
        """Match the features bound to a node, where the robot stands (section 3.2)."""
        bound = self._nodes[node].features
        match = match_features(
            seen_features(_view(look)), bound, self.belief.mean, self.params.window
        )
        if match is None or not match.is_clear:
            return Correction()
        found = GaussianPose(match.pose, match.covariance + self._least_covariance)
        if not self.has_failed and not self._disagree(found):
            self.belief = fused(self.belief, found)
            return Correction(len(match.pairs))
        if len(match.pairs) < self.params.least_features:
            return Correction()
        self.belief, self.has_failed = found, False
        return Correction(len(match.pairs), began_anew=True)

    def _reached(self) -> int:
        """Return the node that the robot has come to, by its pose along the corridor, or -1."""
        reached = -1
        while self._next < len(self._nodes) and self._is_at(self._nodes[self._next]):
            reached = self._next
            self._next += 1
        return reached

    def _is_at(self, node: Node) -> bool:
        ahead = se2.between(node.pose, self.belief.mean)
        return bool(ahead[0] >= -self.params.reached)

    @property
    def _least_covariance(self) -> NDArray[np.float64]:
        metres, radians = self.params.floor
        return np.diag([metres, metres, radians]) ** 2

    def _disagree(self, found: GaussianPose) -> bool:
        off = _difference(found.mean, self.belief.mean)
        spread = found.covariance + self.belief.covariance
        return float(off @ np.linalg.solve(spread, off)) > self.params.disagrees


def fused(one: GaussianPose, other: GaussianPose) -> GaussianPose:
    """Return what two independent beliefs in one pose say together."""
    gain = np.linalg.solve(one.covariance + other.covariance, one.covariance).T
    mean = one.mean + gain @ _difference(other.mean, one.mean)
    mean[2] = wrap(float(mean[2]))
    left = np.eye(3) - gain
    covariance = left @ one.covariance @ left.T + gain @ other.covariance @ gain.T
    return GaussianPose(mean, covariance)


def _difference(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    off = one - other
    off[2] = wrap(float(off[2]))
    return off


def _view(look: Look) -> ScanView:
    return ScanView.of(look.ranges, ANGLES, MOUNT)
