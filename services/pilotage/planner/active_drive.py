"""Drives so as to find out: decide where to look from, go there, look, decide anew; pure."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.planner.active_localization import ActiveLocalization, Decision
from pilotage.planner.hypotheses import merged
from pilotage.planner.information import entropy
from pilotage.planner.path_follower import PathFollower
from pilotage.planner.path_params import FollowerParams, Tolerances
from pilotage.planner.situation import Situation, Speeds

NEWS = 0.5
"""Change of the belief's entropy [bit] that is worth a new decision."""
AS_LONG = 2.0
"""Way [m] after which the decision is thought over."""
NEAR_ENOUGH = Tolerances(position=0.25, heading=0.2)
"""From which the same is seen."""
PERIOD = 1.0
"""Least time [s] between two decisions, that the robot does not stand and think."""


@dataclass
class ActiveDrive:
    """A policy. `decision` is the last one taken, `decided_at` the odometry (3,) of that moment."""

    active: ActiveLocalization
    rng: np.random.Generator
    limits: FollowerParams = field(default_factory=FollowerParams)
    decision: Decision | None = None
    decided_at: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))

    def __post_init__(self) -> None:
        """Begin with nowhere to go."""
        self._follower = PathFollower(self.limits)
        self._tried = np.zeros((0, 2))
        self._decided = -np.inf
        self._before = 0.0

    def step(self, situation: Situation) -> Speeds:
        """Return the speeds until the next step."""
        dt, self._before = situation.now - self._before, situation.now
        if self.decision is None or self._is_news(situation, self.decision):
            self._decide(situation)
        followed = self._follower.step(situation.odom_from_base, situation.view, dt)
        if followed.state != "following":
            self._tried = np.vstack([self._tried, self._target()])
            self.decision = None
        return followed.speeds

    def _is_news(self, situation: Situation, decision: Decision) -> bool:
        """Say whether the belief or the way since the decision asks for another."""
        if situation.now < self._decided + PERIOD:
            return False
        moved = se2.between(self.decided_at, situation.odom_from_base)
        if np.hypot(moved[0], moved[1]) > AS_LONG:
            return True
        left = entropy(merged(situation.belief).weights)
        return abs(left - decision.uncertainty) > NEWS

    def _decide(self, situation: Situation) -> None:
        here = situation.odom_from_base
        tried = se2.transform_points(se2.inverse(here), self._tried)
        decision = self.active.decide(situation.belief, situation.view, self.rng, tried)
        self.decision, self.decided_at, self._decided = decision, here, situation.now
        heading = None if decision.heading is None else float(wrap(here[2] + decision.heading))
        self._follower.begin(se2.transform_points(here, decision.path), heading, NEAR_ENOUGH)

    def _target(self) -> NDArray[np.float64]:
        """Return the end (1, 2) of the path in odom."""
        path = np.zeros((1, 2)) if self.decision is None else self.decision.path
        return se2.transform_points(self.decided_at, path[-1:])
