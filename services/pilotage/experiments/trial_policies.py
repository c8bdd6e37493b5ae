"""Ways of going about that a trial compares: at random, along walls; pure."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import difference
from pilotage.core.laser_view import View
from pilotage.experiments.trial_steering import TURN_FIRST, Body, along, polar, towards
from pilotage.planner.situation import Situation, Speeds

ARRIVED = 0.15
"""m to an aim at which it counts as reached."""

SHORTEST, LONGEST = 0.5, 5.0
"""Ways [m] that are gone at random: what is free, within these."""

NEAR_WALL, FRONT_LEFT = 1.0, float(np.deg2rad(45.0))
"""What is this near [m], and not farther left than this [rad], is the wall that is followed."""

AHEAD = 0.7
"""Length [m] of the strip that has to be free along a wall."""

LEFTMOST = float(np.deg2rad(110.0))
"""Bearing [rad] up to which lasers usually see: what lies beyond only seems to be free."""

TRAIL_STEP = 0.5
"""Way [m] between two poses that are remembered along a wall."""

ROUND_TRIP, ROUND, ROUND_TURN = 6, 0.4, 1.0
"""Being back within so many m and rad of a pose so many steps ago is to go round and round."""


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

    It takes the first free way to the left of the wall: past the end of a wall that leads round it
    and through doors, in a corner to the left. Back where it began it has gone round a pillar: then
    it leaves for another wall.
    """

    body: Body = field(default_factory=lambda: Body(gap=0.14, speed=0.45))
    _trail: list[NDArray[np.float64]] = field(default_factory=list)
    """Odometry (3,) along this wall, a step of the trail apart."""
    _heading: float | None = None
    """Heading [rad] in odom to which it turns on the spot, whatever it sees meanwhile."""
    _is_leaving: bool = False

    def step(self, situation: Situation) -> Speeds:
        """Return the speeds until the next step."""
        view, here = situation.view, situation.odom_from_base
        if self._is_round(here):
            self._trail, self._is_leaving = [], True
            self._heading = float(here[2]) + np.pi / 2.0
        bearing = self._left_to_turn(here)
        if bearing is None:
            bearing = self._wanted(view)
            if abs(bearing) > TURN_FIRST:
                self._heading = float(here[2]) + bearing
        return along(view, bearing, self.body)

    def _left_to_turn(self, here: NDArray[np.float64]) -> float | None:
        """Return the rest of a turn [rad]: what is seen on the way must not turn it back."""
        if self._heading is None:
            return None
        left = float(difference(self._heading, float(here[2])))
        if abs(left) <= TURN_FIRST:
            self._heading = None
            return None
        return left

    def _wanted(self, view: View) -> float:
        """Return the bearing [rad] of the first free way to the left of the wall, or 0 without."""
        body = self.body.fitting(view, AHEAD - self.body.half_width)
        self._is_leaving &= bool(view.reach(0.0, body.half_width)[0] > AHEAD)
        wall = None if self._is_leaving else _wall_at(view)
        angles = np.arange(0.0 if wall is None else wall, LEFTMOST, np.deg2rad(3.0))
        free = np.nonzero(view.reach(angles, body.half_width) > AHEAD)[0]
        return float(angles[free[0]]) if len(free) else LEFTMOST

    def _is_round(self, here: NDArray[np.float64]) -> bool:
        """Say whether it has been here before, going the same way, and note that it has now."""
        if self._is_leaving:
            return False
        if not self._trail or np.hypot(*(here - self._trail[-1])[:2]) > TRAIL_STEP:
            self._trail.append(here)
        return any(
            np.hypot(*(here - then)[:2]) < ROUND and abs(difference(here[2], then[2])) < ROUND_TURN
            for then in self._trail[:-ROUND_TRIP]
        )


def _wall_at(view: View) -> float | None:
    """Return the bearing [rad] of the nearest point that is near, on the right or ahead."""
    x, y = view.points.T
    bearings, distances = np.arctan2(y, x), np.hypot(x, y)
    is_wall = (bearings < FRONT_LEFT) & (bearings > -LEFTMOST) & (distances < NEAR_WALL)
    if not is_wall.any():
        return None
    return float(bearings[is_wall][np.argmin(distances[is_wall])])
