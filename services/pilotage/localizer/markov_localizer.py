"""Markov localization from odometry, scans, ranges and compass (Wu & Bell 2003), with a verdict.

Pure: stamps come with the measurements, poses with the odometry. The service and the offline
command feed it alike.
"""

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.dead_reckoning import says_nothing
from pilotage.localizer.estimate import Memory
from pilotage.localizer.focus import FocusParams
from pilotage.localizer.judge import Judge
from pilotage.localizer.judged_method import JudgedMethod
from pilotage.localizer.landmark_model import weigh_landmarks
from pilotage.localizer.last_measurement import Novelty
from pilotage.localizer.likelihood_field import LikelihoodFieldParams, likelihood_field
from pilotage.localizer.markov_grid import MarkovGrid, MotionSpread
from pilotage.localizer.measurement import Measurement, Ranges
from pilotage.localizer.method import MethodName
from pilotage.localizer.modes import Mode
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


class MarkovLocalizer(JudgedMethod):
    """The belief on a map, moved by odometry and weighed by measurements.

    `sight` is the map's table of optimistic ranges, if it is at hand from an earlier run;
    `landmarks` says where those stand that the robot sees.
    """

    name: MethodName = "markov"
    samples = 20_000
    remembered = 5_000

    def __init__(
        self,
        world: OccupancyMap,
        params: MarkovParams,
        sight: RangeTable | None = None,
        landmarks: LandmarkMap | None = None,
    ) -> None:
        super().__init__(Judge(world, params.verdict, landmarks), params)
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
        self._recovery_weight = 0.0
        self.choose_algorithm(params.algorithm, params.recovery_weight)

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
        self._go_on(self._modes(), memory)

    def choose_algorithm(self, algorithm: Literal["m1", "m2"], recovery_weight: float) -> None:
        """Use M1, or M2 with this weight of its floor, from the next measurement on."""
        self._recovery_weight = recovery_weight if algorithm == "m2" else 0.0

    def _modes(self) -> list[Mode]:
        """Return the modes; each pose is known no better than a state is wide (w^2 / 12)."""
        resolution, step = self._states.geometry.resolution, self._states.heading_step
        return self._modes_in_bins(resolution, step)

    def _predict(self, increment: NDArray[np.float64]) -> None:
        self.grid.predict(increment)

    def _correct(self, measurement: Measurement, novelty: Novelty, *, surprise: bool) -> None:
        """Weigh the belief: Bel <- a P(s | l) P(b | l) (Bel + P0), eq. 8, 13 and 15."""
        anywhere = surprise or (self._judge.is_searching and not says_nothing(measurement))
        carried_off = anywhere and self._recovery_weight > 0.0
        weight = CARRIED_OFF if carried_off else self._recovery_weight
        self.grid.add_floor(weight, _weakened(measurement.compass, novelty.of_ranges))
        if measurement.ends is not None and len(measurement.ends):
            tempering = self.params.tempering * novelty.of_scan
            self.grid.weigh_scan(measurement.ends, self._field, tempering)
            self.grid.settle()
            penalty = self.params.visibility.penalty * novelty.of_scan
            sight = replace(self.params.visibility, penalty=penalty)
            self.grid.weigh_visibility(measurement.ends, self.sight, sight)
        if measurement.ranges is not None:
            self._weigh_ranges(measurement.ranges, novelty.of_ranges)
        if measurement.landmarks is not None and self._landmarks is not None:
            weigh_landmarks(self.grid, measurement.landmarks, self._landmarks, novelty.of_ranges)
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
