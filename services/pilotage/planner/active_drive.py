"""Drives so as to find out: decide where to look from, go there, look, decide anew; pure."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.planner.active_localization import ActiveLocalization, Decision
from pilotage.planner.hypotheses import likely, merged
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
FRUITLESS = 3
"""Far places in a row that told nothing, after which it admits that nothing will."""
GAZE_PERIOD = 0.6
"""s: the joint turns, and a picture or two are taken."""
LONGEST_STEP = 0.2
"""s: what is longer between two steps was a pause, in which the robot was not on this path."""


@dataclass
class ActiveDrive:
    """A policy. `decision` is the last one taken, `decided_at` the odometry (3,) of that moment.

    `gaze`: where to point the sensor off the heading [rad], None if it is fixed.
    """

    active: ActiveLocalization
    rng: np.random.Generator
    limits: FollowerParams = field(default_factory=FollowerParams)
    decision: Decision | None = None
    decided_at: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    gaze: float | None = None

    def __post_init__(self) -> None:
        """Begin with nowhere to go."""
        self._follower = PathFollower(self.limits)
        self._tried = np.zeros((0, 2))
        self._decided = -np.inf
        self._before = -np.inf
        self._is_under_way = False
        self._gazed = -np.inf
        self._fruitless = 0
        self._least = np.inf

    @property
    def failure(self) -> str | None:
        """Why it looks no further, in words; None as long as there is hope."""
        if self._fruitless < FRUITLESS or self.decision is None:
            return None
        count = len(likely(self.decision.places).weights)
        return f"nothing within reach tells the {count} places apart"

    def step(self, situation: Situation) -> Speeds:
        """Return the speeds until the next step."""
        dt, self._before = min(situation.now - self._before, LONGEST_STEP), situation.now
        if self._is_time(situation):
            self._decide(situation)
        self._look(situation)
        if not self._is_under_way or self.failure is not None:
            return 0.0, 0.0
        followed = self._follower.step(situation.odom_from_base, situation.view, dt)
        if followed.state != "following":
            self._tried = np.vstack([self._tried, self._target()])
            self._is_under_way = False
            self._fruitless += self._tells_nothing
        return followed.speeds

    def _is_time(self, situation: Situation) -> bool:
        """Say whether there is nowhere to go, or the belief or the way asks for a new decision."""
        if situation.now < self._decided + PERIOD:
            return False
        if self.decision is None or not self._is_under_way:
            return True
        moved = se2.between(self.decided_at, situation.odom_from_base)
        # Where nothing tells the farthest is chosen: thought over on the way, it would be behind.
        if not self._tells_nothing and np.hypot(moved[0], moved[1]) > AS_LONG:
            return True
        left = entropy(merged(situation.belief).weights)
        return abs(left - self.decision.uncertainty) > NEWS

    @property
    def _tells_nothing(self) -> bool:
        """Whether several places are likely, and no look that was found tells them apart."""
        params, decision = self.active.params, self.decision
        if decision is None or decision.uncertainty < params.settled:
            return False
        return decision.looks[0].gain < params.negligible

    def _decide(self, situation: Situation) -> None:
        here = situation.odom_from_base
        tried = se2.transform_points(se2.inverse(here), self._tried)
        decision = self.active.decide(situation.belief, situation.view, self.rng, tried)
        self.decision, self.decided_at, self._decided = decision, here, situation.now
        self._is_under_way = True
        if decision.uncertainty < self._least - NEWS:
            self._least, self._fruitless = decision.uncertainty, 0
        heading = None if decision.heading is None else float(wrap(here[2] + decision.heading))
        self._follower.begin(se2.transform_points(here, decision.path), heading, NEAR_ENOUGH)

    def _look(self, situation: Situation) -> None:
        """Point the sensor anew, if it can be and has seen something since."""
        if situation.now >= self._gazed + GAZE_PERIOD:
            self._gazed = situation.now
            self.gaze = self.active.gaze(situation.belief, situation.view)

    def _target(self) -> NDArray[np.float64]:
        """Return the end (1, 2) of the path in odom."""
        path = np.zeros((1, 2)) if self.decision is None else self.decision.path
        return se2.transform_points(self.decided_at, path[-1:])
