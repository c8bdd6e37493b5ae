"""Honesty: whether what the belief shows may be called a pose.

A sharp belief is not yet a true one: a scan of a place that the map lacks, or the first scans
after a kidnapping, can make some wrong pose look certain. So `localized` must be earned, by
several scans in a row that put the mass in one place, agree with the map there, and agree with
each other over the motion between them; and it is lost at once when the place jumps.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer.modes import Mode, apart

State = Literal["unknown", "ambiguous", "localized", "lost"]


@dataclass(frozen=True)
class VerdictParams:
    """Parameters of the verdict.

    `enter_mass`, `stay_mass`: mass of the best mode to become, and to stay, localized.
    `enter_matched`, `stay_matched`: share of beams that end near a wall, likewise.
    `earned_by`: scans in a row that must agree.
    `jump`, `jump_turn`: [m], [rad] a place may move beyond odometry between two scans.
    `rival_mass`: modes of this mass are rivals; several make the belief ambiguous ...
    `named_mass`: ... if they hold this much of it together.
    """

    enter_mass: float = 0.90
    stay_mass: float = 0.70
    enter_matched: float = 0.6
    stay_matched: float = 0.4
    earned_by: int = 3
    jump: float = 0.6
    jump_turn: float = 0.35
    rival_mass: float = 0.10
    named_mass: float = 0.5


@dataclass(frozen=True)
class Doubts:
    """What speaks against the best mode, however much mass it has.

    `rivals`: other places that fit the scan as well. Small errors of the map, repeated from scan
    to scan, can move all the mass to one of two like rooms; that is no evidence.
    `surprise`: the scan contradicts the pose where the robot should be.
    """

    rivals: int = 0
    surprise: bool = False

    @property
    def any(self) -> bool:
        """Say whether there is any doubt."""
        return self.surprise or self.rivals > 0


@dataclass
class Verdict:
    """Judges belief after belief; `state` and `confidence` are its last words."""

    params: VerdictParams = field(default_factory=VerdictParams)
    state: State = "unknown"
    confidence: float = 0.0
    _agreeing: int = 0
    _was_localized: bool = False

    def reset(self) -> None:
        """Begin anew: nothing is known, nothing was lost."""
        self.state, self.confidence = "unknown", 0.0
        self._agreeing, self._was_localized = 0, False

    def resume(self, *, was_localized: bool) -> None:
        """Begin from an earlier verdict: one more agreeing scan confirms a localized robot."""
        self.reset()
        self._agreeing = self.params.earned_by - 1 if was_localized else 0

    def judge(
        self,
        modes: list[Mode],
        matched: float | None,
        expected: NDArray[np.float64] | None,
        doubts: Doubts | None = None,
    ) -> State:
        """Return the state after a measurement.

        Args:
            modes: by falling mass; empty when every state is excluded.
            matched: share of the scan's beams that agree with the map at the best mode; None
                where there are no beams to tell by.
            expected: (3,) the last best pose moved on by odometry, or None.
            doubts: what else speaks against the best mode.
        """
        best = modes[0].mass if modes else 0.0
        fit = 1.0 if matched is None else matched
        steady = bool(modes) and expected is not None and not self._jumped(modes[0], expected)
        doubts = doubts or Doubts()
        agrees = steady and not doubts.any and self._is_good(best, fit)
        self._agreeing = self._agreeing + 1 if agrees else 0
        self.state = self._state(modes, doubts)
        fitting = min(1.0, fit / self.params.enter_matched)
        self.confidence = best * fitting * self._earned() / (1 + doubts.rivals)
        self._was_localized |= self.state == "localized"
        return self.state

    def _earned(self) -> float:
        """Return how far the present place has been confirmed, 1 when localized."""
        if self.state == "localized":
            return 1.0
        return (self._agreeing + 1) / (self.params.earned_by + 1)

    def _jumped(self, best: Mode, expected: NDArray[np.float64]) -> bool:
        distance, turn = apart(best.pose, expected)
        return distance > self.params.jump or turn > self.params.jump_turn

    def _is_good(self, best: float, matched: float) -> bool:
        p = self.params
        if self.state == "localized":
            return best >= p.stay_mass and matched >= p.stay_matched
        return best >= p.enter_mass and matched >= p.enter_matched

    def _state(self, modes: list[Mode], doubts: Doubts) -> State:
        if self._agreeing >= self.params.earned_by or (
            self.state == "localized" and self._agreeing > 0
        ):
            return "localized"
        rivals = [mode.mass for mode in modes if mode.mass >= self.params.rival_mass]
        if len(rivals) > 1 and sum(rivals) >= self.params.named_mass:
            return "ambiguous"
        if doubts.rivals and modes[0].mass >= self.params.named_mass and not doubts.surprise:
            return "ambiguous"
        return "lost" if self._was_localized else "unknown"
