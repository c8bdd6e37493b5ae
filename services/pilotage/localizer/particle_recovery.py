"""When to look elsewhere: augmented MCL (Thrun et al. 2005, table 8.3).

A robot that was carried off sees what fits none of its particles. So the fit of the measurements
is remembered over a short and over a long time; the share by which the short memory falls below
the long one is the share of particles that are drawn anew.
"""

from dataclasses import dataclass, field

FEW = 10
"""Parts of a measurement that have half the say of very many: one sighting may be an outlier."""


@dataclass(frozen=True)
class RecoveryParams:
    """Parameters of the recovery.

    `slow`, `fast`: share of a new measurement in either memory (AMCL: recovery_alpha_slow and
    recovery_alpha_fast); zero is no recovery. `surprised`: share drawn anew when a measurement
    contradicts a localized robot's pose. `most`: particles that are drawn anew at the most.
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
        """Return the share of particles to be drawn anew, in [0, 1)."""
        if self.slow is None or self.fast is None or self.params.slow == 0.0:
            return 0.0
        return max(0.0, 1.0 - self.fast / self.slow)

    def forget(self) -> None:
        """Begin anew."""
        self.slow = self.fast = None
