"""Pose tracking on lines and corners with a verdict: the same offer as MarkovLocalizer.

It follows a robot whose pose is known, and finds none: nothing is known until somebody says where
the robot is, another method hands over, or a node of the topological map finds it again.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.localizer.ekf_belief import GaussianBelief, NoBelief
from pilotage.localizer.ekf_pairs import MatchedWalls, matched_walls
from pilotage.localizer.ekf_sight import seen_walls, walls_of_map
from pilotage.localizer.ekf_trust import Trust, TrustParams, Word
from pilotage.localizer.estimate import Estimate, Memory
from pilotage.localizer.last_measurement import LastMeasurement
from pilotage.localizer.line_ekf import GaussianPose, LineEkfParams, predict, track
from pilotage.localizer.measurement import Measurement
from pilotage.localizer.method import Belief, MethodName
from pilotage.localizer.modes import Mode, apart, find_modes
from pilotage.localizer.particle_belief import BIN_SIZE, BIN_TURN
from pilotage.localizer.particle_start import free_space
from pilotage.localizer.range_model import RangeTable

KNOWN_FROM = 0.5
"""Share of a memory that its heaviest place must hold: one Gaussian cannot be at two places."""

REMEMBERED = 729
"""Samples of a memory."""

SEEN_ANEW = 0.25
"""m after which a scan is a new sight, as for other methods; and half a turn is."""

LEAST_SIGMAS = 1e-3, 1e-3, 1e-4
"""Nobody knows a pose more exactly [m, m, rad], whatever is said."""

NOTHING_SAID = Word("unknown", 0.0, None)

STANDING = 0.02
"""How much of a new sight a scan from the same place is: the noise is new, and people move."""


@dataclass(frozen=True)
class EkfParams:
    """Parameters of the tracking.

    `update_way` [m], `update_turn` [rad], `update_after` [s]: as in MarkovParams, but oftener: a
    cycle takes a millisecond, and pairs are sure while little has happened since the last ones.
    `beams`: of a scan that other methods would weigh; here all of them make lines.
    """

    beams: int = 60
    update_way: float = 0.10
    update_turn: float = 0.10
    update_after: float = 0.2
    filter: LineEkfParams = field(default_factory=LineEkfParams)
    trust: TrustParams = field(default_factory=TrustParams)


class EkfLocalizer:
    """A Gaussian on a map, moved by odometry and corrected by walls."""

    name: MethodName = "ekf"
    sight: RangeTable | None = None

    def __init__(self, world: OccupancyMap, params: EkfParams | None = None) -> None:
        self.params = params or EkfParams()
        self.world = world
        self._free = free_space(world)
        self._walls = walls_of_map(world)
        self._trust = Trust(world, self.params.trust)
        self._last = LastMeasurement(self.params)
        self._nothing = _nothing_on(world.geometry)
        self._pose: GaussianPose | None = None
        self.start_anywhere()

    @property
    def belief(self) -> Belief:
        """What is believed now."""
        if self._pose is None:
            return NoBelief(self._free)
        return GaussianBelief(self._pose, _shown_on(self.world.geometry))

    @property
    def map_lines(self) -> int:
        """How many lines the map has."""
        return len(self._walls.lines)

    def start_anywhere(self) -> None:
        """Forget everything: nothing is known until somebody says where the robot is."""
        self._begin(None)

    def start_at(self, map_from_base: ArrayLike, covariance: NDArray[np.float64]) -> None:
        """Begin near a pose (3,); ValueError if it is not in free space."""
        mean = se2.compose(np.asarray(map_from_base, float), np.zeros(3))
        pose = GaussianPose(mean, _checked(covariance))
        samples, _ = GaussianBelief(pose, self.world.geometry).heaviest(REMEMBERED)
        if not self._free.holds(samples).any():
            raise ValueError("the pose is not in the map's free space")
        self._begin(pose)

    def resume(self, memory: Memory) -> None:
        """Go on from the heaviest place of a memory; nothing is known if that is not most of it."""
        best = find_modes(memory.poses, memory.weights)[0]
        if best.mass < KNOWN_FROM:
            self.start_anywhere()
            return
        # Other methods hold no place more exactly than this, and the scan has to confirm it.
        width = np.diag([BIN_SIZE, BIN_SIZE, BIN_TURN]) ** 2 / 12.0
        pose = GaussianPose(best.pose, best.covariance + width)
        self._begin(pose, was_localized=memory.was_localized)
        self._last.resume(memory)

    def remember(self) -> Memory | None:
        """Return what `resume` needs, or None before the first measurement."""
        is_localized = self.estimate.state == "localized"
        return self._last.memory(self.belief, REMEMBERED, was_localized=is_localized)

    def restart_odometry(self) -> None:
        """Odometry counts from a new origin; the belief stays where it is."""
        self._last.restart_odometry()

    def wants(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], _measurement: Measurement
    ) -> bool:
        """Say whether a measurement tells more than the last one did."""
        return self._last.is_due(stamp_ns, odom_from_base)

    def update(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], measurement: Measurement
    ) -> Estimate:
        """Predict up to `odom_from_base` (3,), correct by the walls seen, judge the belief."""
        increment = self._last.increment_to(odom_from_base)
        self._last.note(stamp_ns, odom_from_base)
        self.matched = MatchedWalls()
        if self._pose is not None:
            self._pose, word = self._cycle(self._pose, increment, measurement)
            self.estimate = _estimate(self._pose, word)
        return self.estimate

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last estimated pose (3,) moved on by odometry since."""
        return se2.compose(self.estimate.pose, self._last.increment_to(odom_from_base))

    def choose_algorithm(self, algorithm: Literal["m1", "m2"], recovery_weight: float) -> None:
        """Change nothing: by itself the filter never looks elsewhere, as under M1."""

    def _cycle(
        self, before: GaussianPose, increment: NDArray[np.float64], seen: Measurement
    ) -> tuple[GaussianPose, Word]:
        """Return the belief after one cycle, and what is to be said of it."""
        if seen.beams is None or not np.isfinite(seen.beams.ranges).any():
            predicted = predict(before, increment, self.params.filter.motion)
            return predicted, self._trust.unseen(predicted)
        walls = seen_walls(seen.beams).as_new_as(_newness(increment))
        step = track(before, increment, walls, self._walls, self.params.filter)
        self.matched = matched_walls(step, walls)
        return step.belief, self._trust.judge(step, walls, seen.beams)

    def _begin(self, pose: GaussianPose | None, *, was_localized: bool = False) -> None:
        self._pose = pose
        self._last.forget()
        self._trust.begin(was_localized=was_localized)
        self.matched = MatchedWalls()
        self.estimate = self._nothing if pose is None else _estimate(pose, NOTHING_SAID)


def _nothing_on(geometry: GridGeometry) -> Estimate:
    """Return what is said of a robot of which nothing is known: the middle of the map."""
    width, height = geometry.size_m
    middle = se2.compose(geometry.origin, [width / 2.0, height / 2.0, 0.0])
    spread = np.diag([width**2 / 12.0, height**2 / 12.0, np.pi**2 / 3.0])
    return Estimate(middle, spread, *NOTHING_SAID[:2], [], None)


def _estimate(pose: GaussianPose, word: Word) -> Estimate:
    mode = Mode(1.0, pose.mean, pose.covariance)
    return Estimate(pose.mean, pose.covariance, word.state, word.confidence, [mode], word.matched)


def _newness(increment: NDArray[np.float64]) -> float:
    """Return how much of a new sight a scan is after a motion (3,) since the last one."""
    way, turn = apart(increment, np.zeros(3))
    return min(1.0, max(way / SEEN_ANEW + turn / np.pi, STANDING))


def _shown_on(geometry: GridGeometry) -> GridGeometry:
    """Return cells as wide as a bin (or the map's, if wider) over the same ground."""
    resolution = max(BIN_SIZE, geometry.resolution)
    cols, rows = (int(np.ceil(length / resolution - 1e-9)) for length in geometry.size_m)
    return GridGeometry(max(1, rows), max(1, cols), resolution, geometry.origin)


def _checked(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a covariance made symmetric to the last bit; ValueError if it is none."""
    symmetric = (covariance + covariance.T) / 2.0
    is_one = np.allclose(covariance, symmetric) and np.linalg.eigvalsh(symmetric)[0] >= -1e-12
    if not is_one:
        raise ValueError("the covariance is not symmetric and positive")
    widened: NDArray[np.float64] = symmetric + np.diag(LEAST_SIGMAS) ** 2
    return widened
