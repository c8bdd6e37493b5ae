"""Which of four words the estimate deserves: unknown, ambiguous, localized, lost.

`localized` follows from the confidence alone, which has to be high twice in a row; a lower limit
keeps it, so that it does not flicker. Short of it, several likely places are `ambiguous`. A robot
that was localized and is no longer anywhere in particular is `lost`; one that never was is
`unknown`, as is one that is on its way back.
"""

from dataclasses import dataclass, field
from typing import Literal

State = Literal["unknown", "ambiguous", "localized", "lost"]


@dataclass(frozen=True)
class VerdictParams:
    """Parameters of the verdict.

    `enter`, `stay`: confidence to become (three sigma), and to stay, localized; `earned_by`:
    measurements in a row that have to give it. `rival_mass`: places of this share are rivals;
    several make the belief ambiguous if they hold `named_mass` of it together. `hope`: confidence
    from which a lost robot is rather on its way back.
    """

    enter: float = 0.9973
    stay: float = 0.77
    earned_by: int = 2
    rival_mass: float = 0.10
    named_mass: float = 0.5
    hope: float = 0.45


@dataclass
class Verdict:
    """Judges confidence after confidence; `state` is its last word."""

    params: VerdictParams = field(default_factory=VerdictParams)
    state: State = "unknown"
    _was_localized: bool = False
    _in_a_row: int = 0

    def begin(self, *, was_localized: bool = False) -> None:
        """Begin anew: nothing is known; an earlier run may have known it."""
        self.state, self._was_localized = "unknown", was_localized
        self._in_a_row = self.params.earned_by - 1 if was_localized else 0

    def judge(self, confidence: float, masses: list[float], *, surprise: bool) -> State:
        """Return the state after a measurement.

        Args:
            confidence: probability that the best place is right.
            masses: of all places, by falling mass.
            surprise: whether the measurement contradicts the last best place.
        """
        is_high = confidence >= self.params.enter and not surprise
        self._in_a_row = self._in_a_row + 1 if is_high else 0
        stays = self.state == "localized" and confidence >= self.params.stay and not surprise
        if stays or self._in_a_row >= self.params.earned_by:
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
