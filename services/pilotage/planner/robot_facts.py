"""What one has to know of a robot before one drives it; pure."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

ASSUMED_RADIUS = 0.25
"""m: the body of a robot that does not say how large it is."""


@dataclass(frozen=True)
class RobotBuild:
    """How a robot is built: `radius` of its body round base_link [m], its limits [m/s, rad/s].

    `lasers`: their poses (3,) in base_link by frame. `sight`: how far they see [m], None before
    the first scan, for only scans say.
    """

    name: str
    radius: float = ASSUMED_RADIUS
    max_linear: float = 1.0
    max_angular: float = 2.0
    commands: frozenset[str] = frozenset()
    lasers: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    sight: float | None = None


@dataclass(frozen=True)
class RobotSaid:
    """What a robot says of itself: how many `orders` people gave it; `is_held` by the last."""

    is_log: bool
    orders: int
    is_held: bool
    activity: str


@dataclass
class RobotFacts:
    """What has been heard of the robot so far."""

    build: RobotBuild | None = None
    said: RobotSaid | None = None

    @property
    def orders(self) -> int:
        """How many orders people gave it."""
        return 0 if self.said is None else self.said.orders

    @property
    def activity(self) -> str:
        """What it does, in its own words."""
        return "" if self.said is None else self.said.activity

    @property
    def is_held(self) -> bool:
        """Whether a person's order keeps it from being driven unasked."""
        return self.said is None or self.said.is_held

    @property
    def obstacle(self) -> str | None:
        """Why it cannot be driven at all, in words; None if it can."""
        if self.build is None or self.said is None:
            return "the robot has not been heard of yet"
        if self.said.is_log:
            return "a recorded log cannot be driven"
        if "velocity" not in self.build.commands:
            return f"{self.build.name} has no command velocity"
        if min(self.build.max_linear, self.build.max_angular) <= 0.0:
            return f"{self.build.name} says that it cannot move or turn"
        return None


def radius_of(footprint: NDArray[np.float32]) -> float:
    """Return the radius [m] of a footprint (n, 2); the assumed one if it has no corners."""
    if len(footprint) == 0:
        return ASSUMED_RADIUS
    return float(np.clip(np.hypot(*footprint.T).max(), 0.05, 2.0))
