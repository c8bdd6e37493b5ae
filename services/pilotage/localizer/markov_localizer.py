"""Markov localization from odometry, scans, ranges and compass (Wu & Bell 2003), with a verdict.

Pure: stamps come with the measurements, poses with the odometry. The service and the offline
command feed it alike.
"""

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.estimate import Estimate, Memory
from pilotage.localizer.focus import FocusParams
from pilotage.localizer.judge import Judge
from pilotage.localizer.landmark_model import weigh_landmarks
from pilotage.localizer.likelihood_field import LikelihoodFieldParams, likelihood_field
from pilotage.localizer.markov_grid import MarkovGrid, MotionSpread
from pilotage.localizer.measurement import Measurement, Ranges
from pilotage.localizer.method import MethodName
from pilotage.localizer.modes import Mode, apart, find_modes
from pilotage.localizer.obstacles import enclosed
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid
from pilotage.localizer.range_model import (
    RangeModelParams,
    RangeTable,
    range_likelihoods,
    range_table,
)
from pilotage.localizer.verdict import VerdictParams
from pilotage.localizer.visibility import VisibilityParams, optimistic_ranges

SAMPLES = 20_000
"""States that the modes are looked for in."""

REMEMBERED = 5_000
"""States kept in a memory; what they leave out comes back as uniform belief."""

STANDING = 0.1
"""Novelty of a measurement from the same place: people move, the noise is new."""

CARRIED_OFF = 1.0
"""Weight of the floor after a surprise under M2: exactly the paper's P0 (eq. 8)."""


PROPOSING = FocusParams(dropped=1e-9, woken=1e-7, most=1e-3)
"""What is lighter would be no summit among so many others: it need not be worked on."""


@dataclass(frozen=True)
class MarkovParams:
    """Parameters of the localizer.

    `algorithm`: m1 (eq. 3) or m2 (eq. 8, the paper's).
    `recovery_weight`: weight of M2's floor; 1.0 is exactly the paper's P0 = 1 / |Omega|. The paper
        has four ranges a step; 60 beams outweigh a floor of a millionth in one to three scans,
        and so small a floor does not let chance likenesses grow (Wean Hall: wrong while
        localized in 4 % of the scans instead of 20 %).
    `beams`: beams of a scan that are used.
    `tempering`: exponent of a scan's likelihood; neighbouring beams meet the same wall and the
        same error of the map, so 60 of them do not count as 60 measurements.
    `update_way`, `update_turn`: [m], [rad] the robot moves between two measurements; standing, it
        measures again after `update_after` seconds. Scans from closer together repeat the map's
        errors rather than measure anew.
    """

    algorithm: Literal["m1", "m2"] = "m2"
    recovery_weight: float = 1e-6
    beams: int = 60
    tempering: float = 0.15
    update_way: float = 0.25
    update_turn: float = 0.20
    update_after: float = 1.0
    grid: PoseGridParams = field(default_factory=PoseGridParams)
    spread: MotionSpread = field(default_factory=MotionSpread)
    scan: LikelihoodFieldParams = field(default_factory=LikelihoodFieldParams)
    visibility: VisibilityParams = field(default_factory=VisibilityParams)
    ranges: RangeModelParams = field(default_factory=RangeModelParams)
    verdict: VerdictParams = field(default_factory=VerdictParams)
    focus: FocusParams = field(default_factory=lambda: PROPOSING)


class MarkovLocalizer:
    """The belief on a map, moved by odometry and weighed by measurements.

    `sight` is the map's table of optimistic ranges, if it is at hand from an earlier run;
    `landmarks` says where those stand that the robot sees.
    """

    name: MethodName = "markov"

    def __init__(
        self,
        world: OccupancyMap,
        params: MarkovParams,
        sight: RangeTable | None = None,
        landmarks: LandmarkMap | None = None,
    ) -> None:
        self.params = params
        self.world = world
        self._landmarks = landmarks
        self._states = pose_grid(world, params.grid)
        self.grid = MarkovGrid(self._states, params.spread, params.focus)
        step = self._states.heading_step
        self._enclosed = enclosed(world)
        self._field = likelihood_field(self._enclosed, self._states.geometry, step, params.scan)
        self.sight = sight or optimistic_ranges(
            self._enclosed, self._states.geometry, self._states.headings, params.visibility
        )
        self._table: RangeTable | None = None
        self._judge = Judge(world, params.verdict)
        self._odom_from_base: NDArray[np.float64] | None = None
        self._stamp_ns = 0
        self._judged = False
        self._recovery_weight = 0.0
        self.choose_algorithm(params.algorithm, params.recovery_weight)

    @property
    def estimate(self) -> Estimate:
        """What was last said."""
        return self._judge.estimate

    @property
    def belief(self) -> MarkovGrid:
        """What is believed now."""
        return self.grid

    def start_anywhere(self) -> None:
        """Forget everything: the robot may be in any free place."""
        self.grid.set_uniform()
        self._begin([])

    def start_at(self, map_from_base: ArrayLike, covariance: NDArray[np.float64]) -> None:
        """Begin near a pose (3,); ValueError if it is not in free space."""
        self.grid.set_gaussian(map_from_base, covariance)
        self._begin(self._modes())

    def resume(self, memory: Memory) -> None:
        """Go on from what an earlier run remembered; the next measurement has to confirm it."""
        self.grid.set_states(memory.poses, memory.weights)
        self._begin(self._modes(), was_localized=memory.was_localized)
        self._odom_from_base, self._stamp_ns = memory.odom_from_base, memory.stamp_ns
        self._judged = True

    def remember(self) -> Memory | None:
        """Return what `resume` needs, or None before the first measurement."""
        if self._odom_from_base is None:
            return None
        poses, weights = self.grid.heaviest(REMEMBERED)
        localized = self.estimate.state == "localized"
        return Memory(poses, weights, self._odom_from_base, self._stamp_ns, localized)

    def restart_odometry(self) -> None:
        """Odometry counts from a new origin; the belief stays where it is."""
        self._odom_from_base = None
        self._judge.restart_odometry()

    def wants(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], measurement: Measurement
    ) -> bool:
        """Say whether a measurement tells more than the last one did: by motion or surprise."""
        if self._odom_from_base is None:
            return True
        increment = self._increment_to(odom_from_base)
        waited = (stamp_ns - self._stamp_ns) / 1e9
        is_due = self._moved(increment) >= 1.0 or not 0.0 <= waited < self.params.update_after
        return is_due or self._judge.is_surprised(odom_from_base, measurement)

    def update(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], measurement: Measurement
    ) -> Estimate:
        """Predict up to `odom_from_base` (3,), correct by the measurement, judge the belief."""
        increment = self._increment_to(odom_from_base)
        surprise = self._judge.is_surprised(odom_from_base, measurement)
        self.grid.predict(increment)
        self._correct(measurement, increment, surprise=surprise)
        self._odom_from_base, self._stamp_ns = odom_from_base.copy(), stamp_ns
        self._judged = True
        states = self.grid.heaviest(SAMPLES)
        return self._judge.judge(odom_from_base, states, measurement, surprise=surprise)

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last estimated pose (3,) moved on by odometry since."""
        return se2.compose(self.estimate.pose, self._increment_to(odom_from_base))

    def choose_algorithm(self, algorithm: Literal["m1", "m2"], recovery_weight: float) -> None:
        """Use M1, or M2 with this weight of its floor, from the next measurement on."""
        self._recovery_weight = recovery_weight if algorithm == "m2" else 0.0

    def _begin(self, modes: list[Mode], *, was_localized: bool = False) -> None:
        self._judge.begin(modes, was_localized=was_localized)
        self._odom_from_base = None
        self._judged = False

    def _increment_to(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        if self._odom_from_base is None:
            return np.zeros(3)
        return se2.between(self._odom_from_base, odom_from_base)

    def _modes(self) -> list[Mode]:
        """Return the modes; each pose is known no better than a state is wide (w^2 / 12)."""
        resolution, step = self._states.geometry.resolution, self._states.heading_step
        width = np.diag([resolution**2, resolution**2, step**2]) / 12.0
        found = find_modes(*self.grid.heaviest(SAMPLES))
        return [replace(mode, covariance=mode.covariance + width) for mode in found]

    def _novelty(self, increment: NDArray[np.float64], whole_turn: float) -> float:
        """Return how much of a new measurement this is, 0 to 1.

        A scan from where the last one was taken says the same again: it may not sharpen the
        belief any more. `whole_turn` [rad] brings everything that is seen into view anew.
        """
        if not self._judged:
            return 1.0
        way, turn = apart(increment, np.zeros(3))
        return min(1.0, max(way / self.params.update_way + turn / whole_turn, STANDING))

    def _moved(self, increment: NDArray[np.float64]) -> float:
        """Return the motion as a share of what calls for a new measurement, at most 1."""
        way, turn = apart(increment, np.zeros(3))
        return min(1.0, way / self.params.update_way + turn / self.params.update_turn)

    def _correct(
        self, measurement: Measurement, increment: NDArray[np.float64], *, surprise: bool
    ) -> None:
        """Weigh the belief: Bel <- a P(s | l) P(b | l) (Bel + P0), eq. 8, 13 and 15."""
        anywhere = surprise or self._judge.is_searching
        carried_off = anywhere and self._recovery_weight > 0.0
        weight = CARRIED_OFF if carried_off else self._recovery_weight
        # Few rangers see something else after a small turn, a laser the same from elsewhere.
        of_ranges = 1.0 if surprise else self._novelty(increment, self.params.update_turn)
        of_scan = 1.0 if surprise else self._novelty(increment, np.pi)
        self.grid.add_floor(weight, _weakened(measurement.compass, of_ranges))
        if measurement.ends is not None and len(measurement.ends):
            self.grid.weigh_scan(measurement.ends, self._field, self.params.tempering * of_scan)
            self.grid.settle()
            penalty = self.params.visibility.penalty * of_scan
            sight = replace(self.params.visibility, penalty=penalty)
            self.grid.weigh_visibility(measurement.ends, self.sight, sight)
        if measurement.ranges is not None:
            self._weigh_ranges(measurement.ranges, of_ranges)
        if measurement.landmarks is not None and self._landmarks is not None:
            weigh_landmarks(self.grid, measurement.landmarks, self._landmarks, of_ranges)
        self.grid.settle()

    def _weigh_ranges(self, seen: Ranges, novelty: float) -> None:
        if self._table is None or self._table.range_max != seen.range_max:
            geometry, headings = self._states.geometry, self._states.headings
            self._table = range_table(self._enclosed, geometry, headings, seen.range_max)
        likelihoods = range_likelihoods(seen.ranges, seen.range_max, self.params.ranges)
        weakened = likelihoods ** np.float32(novelty)
        self.grid.weigh_ranges(seen.bearings, weakened, self._table)


def _weakened(compass: tuple[float, float] | None, novelty: float) -> tuple[float, float] | None:
    """Return the compass's word with its variance divided by the novelty."""
    return None if compass is None else (compass[0], compass[1] / float(np.sqrt(novelty)))
