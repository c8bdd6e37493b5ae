"""Greedy entropy over a fixed set of moves (Fox, Burgard & Thrun 1998); pure.

"Active Markov localization for mobile robots", Robotics and Autonomous Systems 25: of a few moves
relative to the robot the one is made whose expected fall of entropy, less its cost, is largest.
What a move would show is reckoned as active localization reckons it, so that only the moves differ.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.experiments.trial_steering import Body, polar, towards
from pilotage.planner.expected_scans import ExpectedScans
from pilotage.planner.hypotheses import merged
from pilotage.planner.information import drawn, expected_gain
from pilotage.planner.situation import Hypotheses, Situation, Speeds

DIRECTIONS, LENGTHS = 16, (1.0, 2.0, 4.0)
"""Straight moves: all around, and how far [m]."""

COST = 0.2
"""bit a metre."""

OBSERVATIONS = 32
"""Places that say what would be seen."""

ARRIVED = 0.15
"""m to an aim at which it counts as reached."""

Gains = Callable[[Hypotheses, NDArray[np.float64]], NDArray[np.float64]]
"""What looks from displacements (n, 2) of a robot at any of the places would tell (n,) [bit]."""


def gains_of(scans: ExpectedScans) -> Gains:
    """Return the gains expected on a map."""

    def gains(places: Hypotheses, points: NDArray[np.float64]) -> NDArray[np.float64]:
        truths = drawn(places.weights, OBSERVATIONS)
        seen = (scans.at(places.moved([x, y, 0.0]).poses) for x, y in points)
        told = [expected_gain(scans.log_likelihoods(s, truths), places.weights) for s in seen]
        return np.array(told)

    return gains


@dataclass
class GreedyEntropyPolicy:
    """Makes the move that is expected to tell most for its length; then the next."""

    gains: Gains
    body: Body = field(default_factory=Body)
    _aim: NDArray[np.float64] | None = None
    _until: float = 0.0
    """Time [s] at which it gives the aim up."""

    def step(self, situation: Situation) -> Speeds:
        """Return the speeds until the next step."""
        here = situation.odom_from_base
        if self._aim is None or situation.now > self._until or polar(self._aim, here)[0] < ARRIVED:
            self._choose(situation)
        if self._aim is None:
            return 0.0, self.body.turn_rate
        body = self.body.fitting(situation.view, min(LENGTHS))
        return towards(situation.view, polar(self._aim, here), body)

    def _choose(self, situation: Situation) -> None:
        """Take the best of the moves that are free; with none, turn on the spot."""
        moves = self._free(situation)
        if len(moves) == 0:
            self._aim = None
            return
        lengths = np.hypot(moves[:, 0], moves[:, 1])
        utility = self.gains(merged(situation.belief), moves) - COST * lengths
        best = int(np.argmax(utility))
        self._aim = se2.transform_points(situation.odom_from_base, moves[best][None])[0]
        self._until = situation.now + 6.0 + 2.0 * float(lengths[best]) / self.body.speed

    def _free(self, situation: Situation) -> NDArray[np.float64]:
        """Return the ends (n, 2) in base_link of the moves that the laser sees to be free."""
        view = situation.view
        angles = np.linspace(-np.pi, np.pi, DIRECTIONS, endpoint=False)
        angles = angles[(angles >= view.bearings.min()) & (angles <= view.bearings.max())]
        ways = self.body.fitting(view, min(LENGTHS)).way(view, angles)
        ends = [
            (length * np.cos(angle), length * np.sin(angle))
            for angle, way in zip(angles, ways, strict=True)
            for length in LENGTHS
            if length <= way
        ]
        return np.array(ends).reshape(-1, 2)
