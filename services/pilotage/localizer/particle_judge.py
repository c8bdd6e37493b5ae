"""Whether what the particles show may be called a pose, judged by the whole scan.

The seam to the evidence that the Markov grid is judged by too: modes and the measurement in, an
Estimate out.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.measurement import Measurement
from pilotage.localizer.modes import Mode, apart
from pilotage.localizer.refinement import matched_share, refine, wall_distance
from pilotage.localizer.surprise import ScanFit
from pilotage.localizer.verdict import Doubts, Verdict, VerdictParams

LEAST_ENDS = 8
"""Fewer beams than this cannot tell a pose beyond its mode."""

REFINEMENT_LIMIT = 0.3
"""A refined pose farther than this [m, rad] from its mode is another place: not believed."""

ALIKE = 0.03
"""Difference in the share of matching beams below which two places fit a scan alike."""

MOST_RIVALS = 6
"""Places, by mass, that are looked at for that."""


class ParticleJudge:
    """Judges modes by scans; `estimate` is its last word."""

    def __init__(self, world: OccupancyMap, params: VerdictParams) -> None:
        self._walls = wall_distance(world)
        self._verdict = Verdict(params)
        self._fit = ScanFit()
        width, height = world.geometry.size_m
        middle = se2.compose(world.geometry.origin, [width / 2.0, height / 2.0, 0.0])
        spread = np.diag([width**2 / 12.0, height**2 / 12.0, np.pi**2 / 3.0])
        self._nothing = Estimate(middle, spread, "unknown", 0.0, [], None)
        self.estimate = self._nothing
        self._has_judged = False

    def begin(self, modes: list[Mode], *, was_localized: bool = False) -> None:
        """Begin anew with what is believed before any measurement."""
        self._fit.forget()
        self._verdict.resume(was_localized=was_localized)
        self._has_judged = bool(modes) and was_localized
        self.estimate = self._nothing
        if modes:
            self.estimate = Estimate(
                modes[0].pose, modes[0].covariance, "unknown", 0.0, modes, None
            )

    def is_surprised(self, increment: NDArray[np.float64], seen: Measurement) -> bool:
        """Say whether a scan contradicts the pose where odometry puts a localized robot."""
        ends = seen.all_ends
        if self.estimate.state != "localized" or ends is None or len(ends) < LEAST_ENDS:
            return False
        expected = se2.compose(self.estimate.pose, increment)
        return self._fit.is_surprising(matched_share(expected, ends, self._walls))

    def judge(
        self,
        modes: list[Mode],
        increment: NDArray[np.float64],
        seen: Measurement,
        *,
        surprise: bool,
    ) -> Estimate:
        """Return the estimate after a measurement; `modes` (at least one) by falling mass."""
        pose, matched = self._refined(modes[0].pose, seen)
        expected = se2.compose(self.estimate.pose, increment) if self._has_judged else None
        rivals = self._rivals(modes, matched, seen)
        state = self._verdict.judge(modes, matched, expected, Doubts(rivals, surprise=surprise))
        confidence = self._verdict.confidence
        self.estimate = Estimate(pose, modes[0].covariance, state, confidence, modes, matched)
        self._has_judged = True
        if state != "localized":
            self._fit.forget()
        elif matched is not None:
            self._fit.learn(matched)
        return self.estimate

    def _refined(
        self, pose: NDArray[np.float64], seen: Measurement
    ) -> tuple[NDArray[np.float64], float | None]:
        """Return a pose (3,) beyond what its mode tells, where a scan allows, and its match."""
        ends = seen.all_ends
        if ends is None or len(ends) < LEAST_ENDS:
            return pose, None
        refined = refine(pose, ends, self._walls)
        if max(apart(refined, pose)) > REFINEMENT_LIMIT:
            refined = pose
        return refined, matched_share(refined, ends, self._walls)

    def _rivals(self, modes: list[Mode], matched: float | None, seen: Measurement) -> int:
        """Return how many of the next places fit the scan as well as the best one does."""
        ends = seen.all_ends
        if matched is None or ends is None:
            return 0
        others = (refine(mode.pose, ends, self._walls) for mode in modes[1:MOST_RIVALS])
        fits = (matched_share(pose, ends, self._walls) for pose in others)
        return sum(fit >= matched - ALIKE for fit in fits)
