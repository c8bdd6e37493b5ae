"""When to look elsewhere: augmented MCL (Thrun et al. 2005, table 8.3).

A robot that was carried off sees what fits none of its particles. So the fit of the measurements
is remembered over a short and over a long time; the share by which the short memory falls below
the long one is how much one should reckon, before the measurement, with being elsewhere.

The book gives so large a share to poses drawn anew, whatever they are worth. Here Bayes decides:
the share counts as a prior, and what the measurement says of any place against what it says of the
particles makes it the share after. That is the paper's M2 (Wu & Bell 2003, eq. 8), sampled.
"""

import math
from dataclasses import dataclass, field

FEW = 10
"""Parts of a measurement that have half the say of very many: one sighting may be an outlier."""


@dataclass(frozen=True)
class RecoveryParams:
    """Parameters of the recovery.

    `slow`, `fast`: share of a new measurement in either memory (AMCL: recovery_alpha_slow and
    recovery_alpha_fast); at zero only a surprise recovers. `surprised`: prior share of being
    elsewhere when a measurement contradicts a localized robot's pose. `most`: particles drawn
    anew for a share of 1.
    """

    slow: float = 0.05
    fast: float = 0.5
    surprised: float = 0.5
    most: int = 50_000

    def __post_init__(self) -> None:
        """Refuse what is no memory (ValueError)."""
        if not 0.0 <= self.slow <= self.fast <= 1.0:
            raise ValueError(f"0 <= slow <= fast <= 1 does not hold for {self.slow}, {self.fast}")


@dataclass
class FitMemory:
    """How well measurements fitted the particles, over a long and over a short time."""

    params: RecoveryParams = field(default_factory=RecoveryParams)
    slow: float | None = None
    fast: float | None = None

    def note(self, fit: float, parts: int) -> None:
        """Take the mean likelihood, in (0, 1], of the parts (beams, sightings) of a measurement."""
        slow = fit if self.slow is None else self.slow
        fast = fit if self.fast is None else self.fast
        share = parts / (parts + FEW)
        self.slow = slow + share * self.params.slow * (fit - slow)
        self.fast = fast + share * self.params.fast * (fit - fast)

    @property
    def share(self) -> float:
        """Return the prior share of being elsewhere, in [0, 1)."""
        if self.slow is None or self.fast is None or self.params.slow == 0.0:
            return 0.0
        return max(0.0, 1.0 - self.fast / self.slow)

    def forget(self) -> None:
        """Begin anew."""
        self.slow = self.fast = None


def share_after(prior: float, log_elsewhere: float, log_here: float) -> float:
    """Return the share of being elsewhere after a measurement (Bayes).

    Args:
        prior: share before it, in [0, 1].
        log_elsewhere: logarithm of the measurement's mean likelihood over all free space.
        log_here: the same, over what was believed.
    """
    if prior in (0.0, 1.0):
        return prior
    odds = math.log(prior / (1.0 - prior)) + log_elsewhere - log_here
    return 1.0 / (1.0 + math.exp(-odds)) if odds > -700.0 else 0.0
