"""What whoever plans a way knows: the belief, what the laser sees, and the odometry; pure."""

from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.laser_view import View

State = Literal["unknown", "ambiguous", "localized", "lost"]
Speeds = tuple[float, float]
"""Linear [m/s] and angular [rad/s]."""


@dataclass(frozen=True)
class Hypotheses:
    """Where the robot could be: `poses` (n, 3), base_link in map, `weights` (n,) summing to one."""

    poses: NDArray[np.float64]
    weights: NDArray[np.float64]

    def moved(self, displacement: ArrayLike) -> "Hypotheses":
        """Return them after a move (3,), given in base_link: all of them make the same one."""
        return replace(self, poses=se2.compose(self.poses, displacement))

    @property
    def best(self) -> NDArray[np.float64]:
        """The heaviest pose (3,)."""
        best: NDArray[np.float64] = self.poses[int(np.argmax(self.weights))]
        return best


@dataclass(frozen=True)
class Situation:
    """What is known at time `now` [s].

    `odom_from_base` (3,): odometry. `view`: what the laser sees, in base_link. `belief`: where
    the robot could be now; `state`: what the localizer says of it.
    """

    now: float
    odom_from_base: NDArray[np.float64]
    view: View
    belief: Hypotheses
    state: State


class Policy(Protocol):
    """A way of going about: asked ten times a second, it says how fast to drive now."""

    def step(self, situation: Situation) -> Speeds:
        """Return the speeds until the next step."""
        ...
