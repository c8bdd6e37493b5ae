"""How probable it is that the best place is the right one: a number that can be trusted.

Posterior probabilities of places are too sure of themselves, for beams are correlated and the
map is never right. So what the evidence says is translated into how often such evidence
was right, by logistic regression.
"""

from dataclasses import astuple, dataclass

import numpy as np

MOST_AHEAD = 14.0
"""Evidence [nat] ahead of all other places beyond which more makes no difference."""

MOST_SUPPORT = 0.5
"""Support [nat a beam] beyond which more makes no difference."""

LONG_FOLLOWED = 12.0
"""Scans after which a place was followed for long."""


@dataclass(frozen=True)
class Signs:
    """What speaks for the best place.

    `ahead`: log of its probability over that of all others [nat]; `support`: mean evidence of
    what was new to see in the last scans [nat]; `fit`: usual mean evidence of a beam [nat];
    `through`: share of beams that usually go through walls; `scans`: how many it was
    followed for; `mass`: share of the belief there.
    """

    ahead: float
    support: float
    fit: float
    through: float
    scans: float
    mass: float


WEIGHTS = Signs(ahead=0.5, support=2.0, fit=3.0, through=-5.0, scans=0.0, mass=1.0)
BIAS = -1.0


def confidence_of(signs: Signs) -> float:
    """Return the probability that the best place is right within 0.5 m and 15 degrees.

    It is never more than the place's share of all places: of like ones none is certain.
    """
    log_odds = BIAS + float(np.dot(astuple(WEIGHTS), features(signs)))
    return float(1.0 / (1.0 + np.exp(-min(log_odds, signs.ahead))))


def features(signs: Signs) -> tuple[float, ...]:
    """Return what the regression weighs, in the order of Signs."""
    return (
        min(max(signs.ahead, -MOST_AHEAD), MOST_AHEAD),
        min(max(signs.support, -MOST_SUPPORT), MOST_SUPPORT),
        signs.fit,
        signs.through,
        float(np.log(min(max(signs.scans, 1.0), LONG_FOLLOWED))),
        signs.mass,
    )
