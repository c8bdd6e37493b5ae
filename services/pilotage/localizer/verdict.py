"""Which of four words the estimate deserves: unknown, ambiguous, localized, lost.

`localized` follows from the confidence alone, with two limits so that it does not flicker. Short
of it, several likely places are `ambiguous`. A robot that was localized and is no longer anywhere
in particular is `lost`; one that never was is `unknown`, as is one that is on its way back.
"""

from dataclasses import dataclass, field
from typing import Literal

State = Literal["unknown", "ambiguous", "localized", "lost"]


@dataclass(frozen=True)
class VerdictParams:
    """Parameters of the verdict.

    `enter`, `stay`: confidence to become, and to stay, localized. `rival_mass`: places of this
    share are rivals; several make the belief ambiguous if they hold `named_mass` of it
    together. `hope`: confidence from which a lost robot is rather on its way back.
    """

    enter: float = 0.97
    stay: float = 0.7
    rival_mass: float = 0.10
    named_mass: float = 0.5
    hope: float = 0.3


@dataclass
class Verdict:
    """Judges confidence after confidence; `state` is its last word."""

    params: VerdictParams = field(default_factory=VerdictParams)
    state: State = "unknown"
    _was_localized: bool = False

    def begin(self, *, was_localized: bool = False) -> None:
        """Begin anew: nothing is known; an earlier run may have known it."""
        self.state, self._was_localized = "unknown", was_localized

    def judge(self, confidence: float, masses: list[float], *, surprise: bool) -> State:
        """Return the state after a measurement.

        Args:
            confidence: probability that the best place is right.
            masses: of all places, by falling mass.
            surprise: whether the measurement contradicts the last best place.
        """
        limit = self.params.stay if self.state == "localized" else self.params.enter
        if confidence >= limit and not surprise:
            self.state, self._was_localized = "localized", True
        else:
            self.state = self._without_pose(confidence, masses, surprise=surprise)
        return self.state

    def _without_pose(self, confidence: float, masses: list[float], *, surprise: bool) -> State:
        lost = self._was_localized and (surprise or confidence < self.params.hope)
        rivals = [mass for mass in masses if mass >= self.params.rival_mass]
        if len(rivals) > 1 and sum(rivals) >= self.params.named_mass and not surprise:
            return "ambiguous"
        return "lost" if lost else "unknown"
