"""Ways of going about that a trial compares: at random, along walls; pure."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import difference
from pilotage.experiments.trial_steering import Body, along, polar, towards
from pilotage.planner.situation import Situation, Speeds

ARRIVED = 0.15
"""m to an aim at which it counts as reached."""

SHORTEST, LONGEST = 0.5, 5.0
"""Ways [m] that are gone at random: what is free, within these."""

NEAR_WALL = 1.0
"""A wall this near [m] on the right is followed."""

AHEAD = 0.7
"""Length [m] of the strip that has to be free along a wall."""

LEFTMOST = np.deg2rad(110.0)
"""Bearing [rad] up to which lasers usually see: what lies beyond only seems to be free."""

ROUND_TRIP = 3.0
"""Way [m] after which being back where it began means that it goes round and round."""


@dataclass
class RandomPolicy:
    """Picks a free bearing and a length within what is free at random, goes there, picks anew."""

    rng: np.random.Generator
    body: Body = field(default_factory=Body)
    _aim: NDArray[np.float64] | None = None
    _until: float = 0.0
    """Time [s] at which it gives the aim up."""

    def step(self, situation: Situation) -> Speeds:
        """Return the speeds until the next step."""
        here = situation.odom_from_base
        if self._aim is None or situation.now > self._until or polar(self._aim, here)[0] < ARRIVED:
            self._pick(situation)
        if self._aim is None:
            return 0.0, self.body.turn_rate
        view = situation.view
        return towards(view, polar(self._aim, here), self.body.fitting(view, SHORTEST))

    def _pick(self, situation: Situation) -> None:
        view = situation.view
        body = self.body.fitting(view, SHORTEST)
        lengths = np.minimum(body.way(view, view.bearings), LONGEST)
        free = np.nonzero(lengths > SHORTEST)[0]
        if len(free) == 0:
            self._aim = None
            return
        chosen = int(self.rng.choice(free))
        length = float(self.rng.uniform(SHORTEST, lengths[chosen]))
        bearing = view.bearings[chosen]
        there = length * np.array([[np.cos(bearing), np.sin(bearing)]])
        self._aim = se2.transform_points(situation.odom_from_base, there)[0]
        self._until = situation.now + 6.0 + 2.0 * length / self.body.speed


@dataclass
class FixedPolicy:
    """Follows the wall on its right at a fixed distance; without one it goes straight on.

    It takes the rightmost way that is free: past the end of a wall that leads round it and
    through doors, in a corner to the left. Back where it began it has gone round a pillar: then
    it leaves for another wall.
    """

    body: Body = field(default_factory=lambda: Body(gap=0.14, speed=0.45))
    _began: NDArray[np.float64] | None = None
    """Odometry (3,) where it began to follow this wall."""
    _way: float = 0.0
    _last: NDArray[np.float64] | None = None
    _leaving: float | None = None
    """Heading [rad] in odom with which it leaves a wall."""

    def step(self, situation: Situation) -> Speeds:
        """Return the speeds until the next step."""
        here = situation.odom_from_base
        self._way += 0.0 if self._last is None else float(np.hypot(*(here - self._last)[:2]))
        self._last = here
        if self._leaving is not None:
            return self._leave(situation, self._leaving)
        if self._is_round(here):
            self._leaving = float(here[2]) + np.pi / 2.0
            self._began = None
        return self._follow(situation)

    def _follow(self, situation: Situation) -> Speeds:
        view, here = situation.view, situation.odom_from_base
        x, y = view.points.T
        is_right = (y < 0.0) & (np.abs(x) < -2.0 * y)
        is_along = bool((np.hypot(x, y)[is_right] < NEAR_WALL).any())
        if is_along and self._began is None:
            self._began, self._way = here, 0.0
        body = self.body.fitting(view, AHEAD - self.body.half_width)
        rightmost = -np.pi / 2.0 if is_along else 0.0
        angles = np.arange(rightmost, LEFTMOST, np.deg2rad(3.0))
        free = np.nonzero(view.reach(angles, body.half_width) > AHEAD)[0]
        if len(free) == 0:
            return 0.0, body.turn_rate
        return along(view, float(angles[free[0]]), body)

    def _is_round(self, here: NDArray[np.float64]) -> bool:
        if self._began is None or self._way < ROUND_TRIP:
            return False
        off = here - self._began
        return bool(np.hypot(off[0], off[1]) < 0.4) and abs(difference(here[2], self._began[2])) < 1

    def _leave(self, situation: Situation, heading: float) -> Speeds:
        """Turn away from the wall and go straight on until something is ahead."""
        view, here = situation.view, situation.odom_from_base
        bearing = difference(heading, float(here[2]))
        if abs(bearing) < 0.2 and float(self.body.way(view, 0.0)[0]) < AHEAD:
            self._leaving = None
        return along(view, bearing, self.body)
