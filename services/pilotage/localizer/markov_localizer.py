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
from pilotage.localizer.landmark_model import weigh_landmarks
from pilotage.localizer.likelihood_field import LikelihoodFieldParams, likelihood_field
from pilotage.localizer.markov_grid import MarkovGrid, MotionSpread
from pilotage.localizer.measurement import Measurement, Ranges
from pilotage.localizer.method import MethodName
from pilotage.localizer.modes import Mode, apart, find_modes
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid
from pilotage.localizer.range_model import (
    RangeModelParams,
    RangeTable,
    range_likelihoods,
    range_table,
)
from pilotage.localizer.refinement import matched_share, refine, wall_distance
from pilotage.localizer.surprise import ScanFit
from pilotage.localizer.verdict import Doubts, Verdict, VerdictParams
from pilotage.localizer.visibility import VisibilityParams, optimistic_ranges

SAMPLES = 20_000
"""States that the modes are looked for in."""

REMEMBERED = 5_000
"""States kept in a memory; what they leave out comes back as uniform belief."""

ALIKE = 0.03
"""Difference in the share of matching beams below which two places fit a scan alike."""

MOST_RIVALS = 6
"""Places, by mass, that are looked at for that."""

STANDING = 0.1
"""Novelty of a measurement from the same place: people move, the noise is new."""

CARRIED_OFF = 1.0
"""Weight of the floor after a surprise under M2: exactly the paper's P0 (eq. 8)."""

LEAST_ENDS = 8
"""Fewer beams than this cannot tell a pose beyond the cell."""

REFINEMENT_LIMIT = 0.3
"""A refined pose farther than this [m, rad] from its mode is another place: not believed."""


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
        self.grid = MarkovGrid(self._states, params.spread)
        step = self._states.heading_step
        self._field = likelihood_field(world, self._states.geometry, step, params.scan)
        self.sight = sight or optimistic_ranges(
            world, self._states.geometry, self._states.headings, params.visibility
        )
        self._walls = wall_distance(world)
        self._table: RangeTable | None = None
        self._verdict = Verdict(params.verdict)
        self._fit = ScanFit()
        self._odom_from_base: NDArray[np.float64] | None = None
        self._stamp_ns = 0
        self._judged = False
        self._recovery_weight = 0.0
        self.choose_algorithm(params.algorithm, params.recovery_weight)
        self.estimate = self._no_estimate()

    @property
    def belief(self) -> MarkovGrid:
        """What is believed now."""
        return self.grid

    def start_anywhere(self) -> None:
        """Forget everything: the robot may be in any free place."""
        self.grid.set_uniform()
        self._begin()

    def start_at(self, map_from_base: ArrayLike, covariance: NDArray[np.float64]) -> None:
        """Begin near a pose (3,); ValueError if it is not in free space."""
        self.grid.set_gaussian(map_from_base, covariance)
        self._begin()
        modes = self._modes()
        self.estimate = self._estimate(modes, modes[0].pose, None)

    def resume(self, memory: Memory) -> None:
        """Go on from what an earlier run remembered; the next measurement has to confirm it."""
        self.grid.set_states(memory.poses, memory.weights)
        self._begin()
        self._odom_from_base, self._stamp_ns = memory.odom_from_base, memory.stamp_ns
        modes = self._modes()
        self._verdict.resume(was_localized=memory.was_localized)
        self._judged = bool(modes)
        pose = modes[0].pose if modes else self.estimate.pose
        self.estimate = self._estimate(modes, pose, None)

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

    def wants(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], measurement: Measurement
    ) -> bool:
        """Say whether a measurement tells more than the last one did: by motion or surprise."""
        if self._odom_from_base is None:
            return True
        increment = self._increment_to(odom_from_base)
        waited = (stamp_ns - self._stamp_ns) / 1e9
        is_due = self._moved(increment) >= 1.0 or not 0.0 <= waited < self.params.update_after
        return is_due or self._is_surprising(increment, measurement)

    def update(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], measurement: Measurement
    ) -> Estimate:
        """Predict up to `odom_from_base` (3,), correct by the measurement, judge the belief."""
        increment = self._increment_to(odom_from_base)
        surprise = self._is_surprising(increment, measurement)
        self.grid.predict(increment)
        self._correct(measurement, increment, surprise=surprise)
        modes = self._modes()
        pose, matched = self._refined(modes, measurement)
        expected = se2.compose(self.estimate.pose, increment) if self._judged else None
        rivals = self._rivals(modes, matched, measurement)
        self._verdict.judge(modes, matched, expected, Doubts(rivals, surprise=surprise))
        self._odom_from_base, self._stamp_ns = odom_from_base.copy(), stamp_ns
        self._judged = bool(modes)
        self.estimate = self._estimate(modes, pose, matched)
        self._note_fit(matched)
        return self.estimate

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last estimated pose (3,) moved on by odometry since."""
        return se2.compose(self.estimate.pose, self._increment_to(odom_from_base))

    def choose_algorithm(self, algorithm: Literal["m1", "m2"], recovery_weight: float) -> None:
        """Use M1, or M2 with this weight of its floor, from the next measurement on."""
        self._recovery_weight = recovery_weight if algorithm == "m2" else 0.0

    def _begin(self) -> None:
        self._verdict.reset()
        self._fit.forget()
        self.restart_odometry()
        self._judged = False
        self.estimate = self._no_estimate()

    def _no_estimate(self) -> Estimate:
        width, height = self.world.geometry.size_m
        middle = se2.compose(self.world.geometry.origin, [width / 2.0, height / 2.0, 0.0])
        spread = np.diag([width**2 / 12.0, height**2 / 12.0, np.pi**2 / 3.0])
        return Estimate(middle, spread, "unknown", 0.0, [], None)

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

    def _is_surprising(self, increment: NDArray[np.float64], measurement: Measurement) -> bool:
        """Say whether a scan contradicts the pose where odometry puts a localized robot."""
        ends = measurement.all_ends
        if self.estimate.state != "localized" or ends is None or len(ends) < LEAST_ENDS:
            return False
        expected = se2.compose(self.estimate.pose, increment)
        return self._fit.is_surprising(matched_share(expected, ends, self._walls))

    def _rivals(self, modes: list[Mode], matched: float | None, measurement: Measurement) -> int:
        """Return how many of the next places fit the scan as well as the best one does."""
        ends = measurement.all_ends
        if matched is None or ends is None:
            return 0
        others = (refine(mode.pose, ends, self._walls) for mode in modes[1:MOST_RIVALS])
        fits = (matched_share(pose, ends, self._walls) for pose in others)
        return sum(fit >= matched - ALIKE for fit in fits)

    def _note_fit(self, matched: float | None) -> None:
        if self.estimate.state != "localized":
            self._fit.forget()
        elif matched is not None:
            self._fit.learn(matched)

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
        carried_off = surprise and self._recovery_weight > 0.0
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
            self._table = range_table(self.world, geometry, headings, seen.range_max)
        likelihoods = range_likelihoods(seen.ranges, seen.range_max, self.params.ranges)
        weakened = likelihoods ** np.float32(novelty)
        self.grid.weigh_ranges(seen.bearings, weakened, self._table)

    def _refined(
        self, modes: list[Mode], measurement: Measurement
    ) -> tuple[NDArray[np.float64], float | None]:
        """Return the best mode's pose, beyond the cell where a scan allows, and its match."""
        if not modes:
            return self.estimate.pose, None
        pose, ends = modes[0].pose, measurement.all_ends
        if ends is None or len(ends) < LEAST_ENDS:
            return pose, None
        refined = refine(pose, ends, self._walls)
        if max(apart(refined, pose)) > REFINEMENT_LIMIT:
            refined = pose
        return refined, matched_share(refined, ends, self._walls)

    def _estimate(
        self, modes: list[Mode], pose: NDArray[np.float64], matched: float | None
    ) -> Estimate:
        covariance = modes[0].covariance if modes else self.estimate.covariance
        verdict = self._verdict
        return Estimate(pose, covariance, verdict.state, verdict.confidence, modes, matched)


def _weakened(compass: tuple[float, float] | None, novelty: float) -> tuple[float, float] | None:
    """Return the compass's word with its variance divided by the novelty."""
    return None if compass is None else (compass[0], compass[1] / float(np.sqrt(novelty)))
