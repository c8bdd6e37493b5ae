"""How far the filter's pose is to be trusted: honest words for a belief that is always sure.

One Gaussian knows no rivals, and finds pairs wherever it is: some wall is always near. So trust is
earned scan by scan, as log-odds of being right: by how much of the walls seen is matched, and by
what each beam says of the pose. That is the evidence by which all methods are judged; it knows
beams that go through walls. What has been seen before says nothing new. Confidence is the
probability of being right within the limits of a place, which the covariance must allow, too.
"""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pilotage.core.grid import OccupancyMap
from pilotage.localizer.dead_reckoning import within_limits
from pilotage.localizer.ekf_walls import Walls
from pilotage.localizer.evidence import chosen_beams, weigh
from pilotage.localizer.line_ekf import EkfStep, GaussianPose
from pilotage.localizer.measurement import Beams
from pilotage.localizer.obstacles import obstacles
from pilotage.localizer.verdict import State, Verdict, VerdictParams


@dataclass(frozen=True)
class TrustParams:
    """Parameters of the trust; all but the limits measured on simulated tracks (see README).

    `begin`: log-odds of a pose that somebody gave. `usual_fit`, `fit_counts`: mean evidence of a
    beam [nat] that speaks neither for nor against a pose, and what one nat more says.
    `usual_share`, `share_counts`: the same of the share of the lines seen that are matched, by
    length. `loudest`: a scan says no more. `least`, `most`: log-odds go no further. `worse`: fit
    by so much below its usual value, and below nothing, is a surprise. `enough`: pairs without
    which the robot is lost after `starved` new sights.
    """

    begin: float = 0.0
    usual_fit: float = 0.12
    fit_counts: float = 8.0
    usual_share: float = 0.45
    share_counts: float = 4.0
    loudest: float = 3.0
    least: float = -4.0
    most: float = 7.5
    worse: float = 0.35
    enough: int = 2
    starved: float = 12.0
    verdict: VerdictParams = field(default_factory=VerdictParams)


class Word(NamedTuple):
    """What is said of a pose; `matched`: share of the beams that meet what the map shows."""

    state: State
    confidence: float
    matched: float | None


RATE = 0.25
"""Share by which a new scan changes how well a pose usually fits."""

LOST_AT = -1.0
"""Log-odds, at most, after a surprise or without pairs: less than any hope (VerdictParams)."""


class Trust:
    """Log-odds that the filter's pose is right, and the verdict that follows."""

    def __init__(self, world: OccupancyMap, params: TrustParams) -> None:
        self._around = obstacles(world)
        self._params = params
        self._verdict = Verdict(params.verdict)
        self.begin()

    def begin(self, *, was_localized: bool = False) -> None:
        """Begin anew with a pose that somebody gave."""
        self._verdict.begin(was_localized=was_localized)
        self._log_odds = self._params.most if was_localized else self._params.begin
        self._usual_fit = 0.0
        self._without_pairs = 0.0

    def unseen(self, pose: GaussianPose) -> Word:
        """Return what is left to say after a motion during which no scan came."""
        if self._verdict.state != "localized":
            return Word(self._verdict.state, self._confidence(pose), None)
        return self._word(pose, None, surprise=False)

    def judge(self, step: EkfStep, seen: Walls, beams: Beams) -> Word:
        """Return what is to be said after a cycle that saw a scan's walls."""
        chosen = chosen_beams(beams)
        weighed = weigh(step.belief.mean[None], beams, np.ones(len(chosen.ranges)), self._around)
        fit = float(weighed.fit[0])
        surprise = self._is_surprising(fit)
        share = step.pairs.matched_share(seen) if len(seen.lines) else None
        self._weigh(fit, share, seen.newness)
        self._starve(len(step.pairs), seen.newness)
        if surprise:
            self._log_odds = min(self._log_odds, LOST_AT)
        return self._word(step.belief, float(weighed.met[0]), surprise=surprise)

    def _is_surprising(self, fit: float) -> bool:
        """Say whether a scan contradicts the pose of a localized robot."""
        limit = min(0.0, self._usual_fit - self._params.worse)
        return self._verdict.state == "localized" and fit < limit

    def _weigh(self, fit: float, share: float | None, newness: float) -> None:
        p = self._params
        gain = p.fit_counts * (fit - p.usual_fit)
        if share is not None:
            gain += p.share_counts * (share - p.usual_share)
        gain = float(np.clip(gain, -p.loudest, p.loudest))
        self._log_odds = float(np.clip(self._log_odds + newness * gain, p.least, p.most))
        self._usual_fit += RATE * newness * (fit - self._usual_fit)

    def _starve(self, pairs: int, newness: float) -> None:
        """Lose trust when hardly any pair was matched for long."""
        self._without_pairs = 0.0 if pairs >= self._params.enough else self._without_pairs + newness
        if self._without_pairs >= self._params.starved:
            self._log_odds = min(self._log_odds, LOST_AT)

    def _word(self, pose: GaussianPose, matched: float | None, *, surprise: bool) -> Word:
        confidence = self._confidence(pose)
        state = self._verdict.judge(confidence, [1.0], surprise=surprise)
        return Word(state, confidence, matched)

    def _confidence(self, pose: GaussianPose) -> float:
        right = 1.0 / (1.0 + math.exp(-self._log_odds))
        return right * min(1.0, within_limits(pose.covariance))
