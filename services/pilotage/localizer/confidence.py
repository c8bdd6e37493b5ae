"""How probable it is that the best place is the right one: a number that can be trusted.

Posterior probabilities of places are too sure of themselves, for beams are correlated and the
map is never right. So what the evidence says is translated into how often such evidence
was right, by logistic regression.
"""

from dataclasses import dataclass

import numpy as np

MOST_AHEAD = 14.0
"""Evidence [nat] ahead of all other places beyond which more makes no difference."""

MOST_SUPPORT = 0.25
"""Support [nat a beam] beyond which more makes no difference."""

ODDS_COUNT = 0.75
"""Power of the place's odds that the confidence may follow: beams and scans are correlated."""

EXACT = 0.45, 0.49
"""Supports [nat a beam] from which on, and up to which, beams count more, up to twice: where nearly
every one ends within half a cell of a wall, the map is right, and small differences tell."""

BETTER_COUNTS = 50.0
"""Log-odds for each [nat a beam] that the place is better supported than any other one: maps and
doors are never quite right, so where another fits as well now ..."""

HISTORY, HISTORY_COUNTS = 8.0, 0.5
"""... it takes so much evidence [nat] of the past, of which a part counts, to prefer one."""

RIVALLED = -1.7
"""Log-odds of a place that many others fit better than, at least: it is still the likeliest."""


@dataclass(frozen=True)
class Signs:
    """What speaks for the best place.

    `ahead`: log of its probability over that of all others [nat]; `support`: mean evidence of
    what was new to see in the last scans [nat a beam]; `mass`: share of the belief there;
    `better`: by how much it is better supported than any other place that is followed.
    """

    ahead: float
    support: float
    mass: float
    better: float

    @property
    def counted(self) -> float:
        """How far ahead the place is [nat], where the map is exact counted up to twice."""
        least, most = EXACT
        exact = min(max((self.support - least) / (most - least), 0.0), 1.0)
        return self.ahead * (1.0 + exact) if self.ahead > 0.0 else self.ahead


WEIGHTS = (0.43, 5.2, 1.9)
BIAS = -1.9
"""Found by tests/benchmarks/fit_confidence.py, scans in other buildings counting half."""


SLOPE, OFFSET = 1.6, 1.2
"""From those log-odds to those found in the trials of mapped buildings (building_trials.py): limits
that keep like places apart make them too low by so much."""


def confidence_of(signs: Signs) -> float:
    """Return the probability that the best place is right within 0.5 m and 15 degrees.

    Held down by the place's odds against all others, of which a power counts: of like ones none is
    certain. So it is where another one fits what is seen now as well.
    """
    log_odds = BIAS + float(np.dot(WEIGHTS, features(signs)))
    past = HISTORY_COUNTS * max(0.0, signs.counted - HISTORY)
    rivalled = max(BETTER_COUNTS * signs.better + past, RIVALLED)
    log_odds = min(log_odds, ODDS_COUNT * signs.counted, rivalled)
    return _probability(log_odds)


def confidence_of_mass(mass: float) -> float:
    """Return the probability that a mode of this share of the belief is right, without a laser.

    Measurements are correlated: a belief is surer of itself than it is right, so its square counts.
    """
    odds = mass**2 / max(1.0 - mass**2, 1e-9)
    return _probability(float(np.log(max(odds, 1e-9))))


def _probability(log_odds: float) -> float:
    """Return what log-odds by the limits are worth."""
    return float(1.0 / (1.0 + np.exp(-SLOPE * log_odds - OFFSET)))


def features(signs: Signs) -> tuple[float, float, float]:
    """Return what the regression weighs: how far ahead, how well supported, with what mass."""
    return (
        min(max(signs.counted, -MOST_AHEAD), MOST_AHEAD),
        min(max(signs.support, -MOST_SUPPORT), MOST_SUPPORT),
        signs.mass,
    )
