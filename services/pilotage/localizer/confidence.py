"""How probable it is that the best place is the right one: a number that can be trusted.

Posterior probabilities of places are too sure of themselves, for beams are correlated and the
map is never right. So what the evidence says is translated into how often such evidence
was right, by logistic regression.
"""

from dataclasses import astuple, dataclass

import numpy as np

MOST_AHEAD = 14.0
"""Evidence [nat] ahead of all other places beyond which more makes no difference."""

MOST_SUPPORT = 0.25
"""Support [nat a beam] beyond which more makes no difference."""

LEAST_MASS = 1e-3
"""Mass below which less, or up to one above which more, makes no difference."""

ODDS_COUNT = 0.75
"""Power of the place's odds that the confidence may follow: beams and scans are correlated."""

DISSENT = 3.0
"""Log-odds by which a place may be surer than its share of the belief ..."""

FAR_AHEAD = 6.0
"""... and by half of what it is farther ahead of all others than this [nat]."""


@dataclass(frozen=True)
class Signs:
    """What speaks for the best place.

    `ahead`: log of its probability over that of all others [nat]; `support`: mean evidence of
    what was new to see in the last scans [nat a beam]; `mass`: share of the belief there.
    """

    ahead: float
    support: float
    mass: float


WEIGHTS = Signs(ahead=0.375, support=14.2, mass=7.7)
BIAS = -2.6
"""Found by logistic regression on an earlier state of the evidence, scans in other buildings
counting half; tests/benchmarks/fit_confidence.py finds them anew."""


def confidence_of(signs: Signs) -> float:
    """Return the probability that the best place is right within 0.5 m and 15 degrees.

    It never says more than the place's odds against all others do, of which a power counts: of
    like ones none is certain. Nor is it high where the belief, which sees less but forgets no
    state, holds nearly nothing.
    """
    log_odds = BIAS + float(np.dot(astuple(WEIGHTS), features(signs)))
    mass = min(max(signs.mass, LEAST_MASS), 1.0 - LEAST_MASS)
    by_mass = float(np.log(mass / (1.0 - mass))) + DISSENT
    by_mass += max(0.0, signs.ahead - FAR_AHEAD) / 2.0
    return float(1.0 / (1.0 + np.exp(-min(log_odds, ODDS_COUNT * signs.ahead, by_mass))))


def features(signs: Signs) -> tuple[float, ...]:
    """Return what the regression weighs, in the order of Signs."""
    return (
        min(max(signs.ahead, -MOST_AHEAD), MOST_AHEAD),
        min(max(signs.support, -MOST_SUPPORT), MOST_SUPPORT),
        signs.mass,
    )
