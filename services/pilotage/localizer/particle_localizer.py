"""Monte Carlo localization with a verdict: the same offer as MarkovLocalizer, by particles.

Pure: chance is an argument, stamps come with the measurements, poses with odometry.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.estimate import Memory
from pilotage.localizer.judge import Judge
from pilotage.localizer.judged_method import JudgedMethod
from pilotage.localizer.last_measurement import Novelty
from pilotage.localizer.markov_grid import MotionSpread
from pilotage.localizer.measurement import Measurement
from pilotage.localizer.method import MethodName
from pilotage.localizer.modes import Mode
from pilotage.localizer.particle_belief import (
    BIN_SIZE,
    BIN_TURN,
    ParticleBelief,
    particle_belief,
)
from pilotage.localizer.particle_evidence import EvidenceParams, ParticleEvidence
from pilotage.localizer.particle_filter import ParticleFilter
from pilotage.localizer.particle_motion import MotionModel
from pilotage.localizer.particle_recovery import FitMemory, RecoveryParams, share_after
from pilotage.localizer.particle_resampling import KldParams
from pilotage.localizer.particle_search import ParticleSearch, SearchParams
from pilotage.localizer.particle_start import free_space
from pilotage.localizer.range_model import RangeTable
from pilotage.localizer.verdict import VerdictParams

NEGLIGIBLE = 1e-4
"""Share of the belief that is not worth any particles."""

THOROUGH = 0.5
"""Prior share of being elsewhere from which on the search is that for an unknown start."""


@dataclass(frozen=True)
class ParticleParams:
    """Parameters of the particle filter.

    `beams`: beams of a scan that are used. `update_way` [m], `update_turn` [rad],
    `update_after` [s]: as in MarkovParams.
    """

    beams: int = 60
    update_way: float = 0.25
    update_turn: float = 0.20
    update_after: float = 1.0
    motion: MotionModel = field(default_factory=MotionSpread)
    kld: KldParams = field(default_factory=KldParams)
    recovery: RecoveryParams = field(default_factory=RecoveryParams)
    evidence: EvidenceParams = field(default_factory=EvidenceParams)
    search: SearchParams = field(default_factory=SearchParams)
    verdict: VerdictParams = field(default_factory=VerdictParams)


class ParticleLocalizer(JudgedMethod):
    """Particles on a map, moved by odometry and weighed by measurements.

    `sight` is the map's table of optimistic ranges, if it is at hand from an earlier run.
    """

    name: MethodName = "mcl"
    samples = 5_000
    remembered = 2_000

    def __init__(
        self,
        world: OccupancyMap,
        params: ParticleParams,
        rng: np.random.Generator,
        sight: RangeTable | None = None,
        landmarks: LandmarkMap | None = None,
    ) -> None:
        super().__init__(Judge(world, params.verdict, landmarks), params)
        self.params = params
        self.world = world
        self._rng = rng
        self._free = free_space(world)
        self._evidence = ParticleEvidence(world, params.evidence, sight, landmarks)
        self._search = ParticleSearch(self._free, self._evidence, params.search)
        self.sight = self._evidence.sight
        self.filter = ParticleFilter(self._free, params.motion, params.kld)
        self._fits = FitMemory(params.recovery)
        self._recovers = True
        self.start_anywhere()

    @property
    def belief(self) -> ParticleBelief:
        """What the particles believe now, in bins."""
        return particle_belief(self.filter.poses, self.filter.weights, self.world.geometry)

    def start_anywhere(self) -> None:
        """Forget everything: the robot may be in any free place."""
        self.filter.set_uniform(self.params.kld.most, self._rng)
        self._begin([])
        self._is_anywhere = True

    def start_at(self, map_from_base: ArrayLike, covariance: NDArray[np.float64]) -> None:
        """Begin near a pose (3,); ValueError if it is not in free space."""
        self.filter.set_gaussian(map_from_base, covariance, self._rng)
        self._begin(self._modes())

    def resume(self, memory: Memory) -> None:
        """Go on from what an earlier run remembered; the next measurement has to confirm it."""
        self.filter.set_states(memory.poses, memory.weights, self._rng)
        self._go_on(self._modes(), memory)

    def choose_algorithm(self, algorithm: Literal["m1", "m2"], recovery_weight: float) -> None:
        """Draw particles anew when measurements do not fit (m2), or never (m1, or no weight)."""
        self._recovers = algorithm == "m2" and recovery_weight > 0.0

    def _begin(self, modes: list[Mode], *, was_localized: bool = False) -> None:
        super()._begin(modes, was_localized=was_localized)
        self._fits.forget()
        self._is_anywhere = False

    def _predict(self, increment: NDArray[np.float64]) -> None:
        self.filter.predict(increment, self._rng)

    def _correct(self, measurement: Measurement, novelty: Novelty, *, surprise: bool) -> None:
        if self._is_anywhere:
            self._find(measurement)
        else:
            self._weigh(measurement, novelty, surprise=surprise)

    def _find(self, measurement: Measurement) -> None:
        """Replace particles anywhere by those that the first measurement speaks for."""
        self.filter.take(self._search.anywhere(measurement, Novelty(), self._rng))
        if self.filter.is_depleted:
            self.filter.resample(self._rng)
        self._is_anywhere = False

    def _weigh(self, measurement: Measurement, novelty: Novelty, *, surprise: bool) -> None:
        """Weigh the particles, and let in others where the measurement fits none of them."""
        word = self._evidence.weigh(self.filter.poses, measurement, novelty)
        if word.parts:
            self._fits.note(float(self.filter.weights @ word.fits), word.parts)
        log_here = self.filter.weigh(word.logs)
        if self.filter.is_depleted:
            self.filter.resample(self._rng)
        surprised = self.params.recovery.surprised if surprise else 0.0
        if self._recovers:
            self._recover(measurement, novelty, (max(self._fits.share, surprised), log_here))

    def _recover(
        self, measurement: Measurement, novelty: Novelty, reckoned: tuple[float, float]
    ) -> None:
        """Give its share of the belief to any place that the measurement speaks for.

        `reckoned`: prior share of being elsewhere; log likelihood of the measurement here.
        """
        prior, log_here = reckoned
        count = round(prior * self.params.recovery.most)
        if count:
            effort = min(1.0, prior / THOROUGH)
            finds = self._search.anywhere(measurement, novelty, self._rng, effort)
            share = share_after(prior, finds.log_mean, log_here)
            if share > NEGLIGIBLE:
                self.filter.admit(finds.drawn(count, self._rng), share)

    def _modes(self) -> list[Mode]:
        """Return the modes; each pose is known no better than a bin is wide (w^2 / 12)."""
        return self._modes_in_bins(BIN_SIZE, BIN_TURN)
