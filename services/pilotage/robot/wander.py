"""Wandering: go where it is open and where one has not been lately, and touch nothing; pure.

Ways are straight, so a way is free if no measured point lies within a strip along it. From time
to time the robot looks at the free ways around it and picks the end of one: the longer, the
straighter ahead and the less visited, the better. Then it turns towards it and drives.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.laser_view import Points, View
from pilotage.robot.watchdog import AT_REST, Speeds

ARRIVED = 0.35
"""m to the aim at which it counts as reached."""
TURN_FIRST = 0.6
"""rad to the aim beyond which the robot turns on the spot."""
SHORTEST = 0.5
"""Length in m below which a way is not worth going."""
TIGHT = 0.04
"""Gap in m with which the robot leaves a nook that it cannot leave otherwise."""
LOOK_AHEAD = 1.0
"""Length in m of the strip that has to be free in the direction of travel."""


@dataclass(frozen=True)
class WanderParams:
    """How the robot wanders."""

    radius: float = 0.165
    """Radius of its body, m."""
    keep_clear: float = 0.25
    """Gap to everything in open space, m."""
    squeeze: float = 0.09
    """Gap with which it goes through doors, m."""
    speed: float = 0.55
    """m/s."""
    turn_rate: float = 1.2
    """rad/s."""
    sight: float = 5.0
    """Longest way that is planned at once, m."""
    period: float = 0.5
    """Time between two looks around, s."""
    memory: float = 400.0
    """Time after which a visit is half forgotten, s."""
    length_worth: float = 0.12
    """Worth of a metre of way."""
    ahead_worth: float = 0.15
    """Worth of going straight ahead."""
    door_worth: float = 0.9
    """Worth of going through a door."""
    visited_cost: float = 1.2
    """Cost of having been there just now."""
    hysteresis: float = 0.35
    """How much better a new aim must be than the present one."""


@dataclass
class WanderState:
    """What the robot remembers: its aim and its visits, in odom."""

    aim: Points | None = None
    aim_score: float = 0.0
    patience: float = 0.0
    """Time left to reach the aim, s."""
    since_look: float = np.inf
    spin: float = 1.0
    visits: Points = field(default_factory=lambda: np.zeros((0, 3)))
    """(n, 3): x, y, age in s."""


@dataclass(frozen=True)
class Ways:
    """Free ways: `ends` (n, 2) in base_link, `bearings` (n,) rad, which lead through a door."""

    ends: Points
    bearings: NDArray[np.float64]
    is_door: NDArray[np.bool_]


class Wanderer:
    """Wanders; `step` is called with every look at the world."""

    def __init__(self, params: WanderParams, rng: np.random.Generator) -> None:
        self.params = params
        self.state = WanderState()
        self._rng = rng

    def step(self, view: View, pose: ArrayLike, dt: float) -> Speeds:
        """Return the speeds to drive with now.

        Args:
            view: what the laser sees.
            pose: (3,) base_link in odom.
            dt: time since the last step, s.
        """
        here = np.asarray(pose, float)
        self._remember(here, dt)
        self.state.since_look += dt
        self.state.patience -= dt
        if self.state.since_look >= self.params.period:
            self.state.since_look = 0.0
            self._look_around(view, here)
        if self.state.aim is None:
            return 0.0, self.state.spin * self.params.turn_rate
        return self._approach(view, here)

    def _remember(self, here: Points, dt: float) -> None:
        visits = self.state.visits
        visits[:, 2] += dt
        if len(visits) and np.hypot(*(visits[:, :2] - here[:2]).T).min() < 0.4:
            nearest = int(np.argmin(np.hypot(*(visits[:, :2] - here[:2]).T)))
            visits[nearest, 2] = 0.0
            return
        kept = visits[visits[:, 2] < 5.0 * self.params.memory]
        self.state.visits = np.vstack([kept, [here[0], here[1], 0.0]])

    def _look_around(self, view: View, here: Points) -> None:
        """Choose an aim, unless the present one is as good and still free."""
        state = self.state
        ways = self._free_ways(view)
        if len(ways.ends) == 0:
            state.aim = None
            return
        in_odom = se2.transform_points(here, ways.ends)
        scores = self._scores(in_odom, ways)
        if self._keeps_aim(view, here, float(scores.max())):
            return
        best = int(np.argmax(scores + self._rng.gumbel(0.0, 0.1, len(scores))))
        length = float(np.hypot(*ways.ends[best]))
        state.aim, state.aim_score = in_odom[best], float(scores[best])
        state.patience = 4.0 + length / (0.4 * self.params.speed)
        state.spin = 1.0 if ways.bearings[best] >= 0.0 else -1.0

    def _free_ways(self, view: View) -> Ways:
        """Return ways with room to spare and through doors; if there are none, tighter ones."""
        ways = self._open_ways(view)
        for gap in (self.params.squeeze, TIGHT):
            if len(ways.ends) > 0:
                break
            ways = _ways(view.bearings, self._lengths(view, gap), SHORTEST / 2.0)
        return ways

    def _open_ways(self, view: View) -> Ways:
        """Return the ways at the laser's bearings, whole and in part, and those through doors."""
        params, angles = self.params, view.bearings
        wide = self._lengths(view, params.keep_clear)
        is_door = view.is_door(angles, params.radius + params.squeeze)
        narrow = self._lengths(view, params.squeeze)[is_door]
        lengths = np.concatenate([wide, 0.6 * wide, narrow])
        ways = _ways(np.concatenate([angles, angles, angles[is_door]]), lengths, SHORTEST)
        is_narrow = np.arange(len(lengths)) >= 2 * len(angles)
        return replace(ways, is_door=is_narrow[lengths > SHORTEST])

    def _lengths(self, view: View, gap: float) -> NDArray[np.float64]:
        """Return how far (n,) the robot may go at the view's bearings with this gap, m."""
        half_width = self.params.radius + gap
        reach = view.reach(view.bearings, half_width) - half_width
        return np.minimum(reach, self.params.sight)

    def _scores(self, in_odom: Points, ways: Ways) -> NDArray[np.float64]:
        """Return how good each end (n, 2) in odom is as an aim."""
        visits = self.state.visits
        squared = ((in_odom[:, None, :] - visits[None, :, :2]) ** 2).sum(axis=2)
        freshness = 0.5 ** (visits[:, 2] / self.params.memory)
        visited = (np.exp(-squared / (2.0 * 0.8**2)) * freshness).sum(axis=1)
        length = np.hypot(ways.ends[:, 0], ways.ends[:, 1])
        scores: NDArray[np.float64] = (
            self.params.length_worth * length
            + self.params.ahead_worth * np.cos(ways.bearings)
            + self.params.door_worth * ways.is_door
            - self.params.visited_cost * visited
        )
        return scores

    def _keeps_aim(self, view: View, here: Points, best: float) -> bool:
        """Say whether the present aim is worth going on with."""
        state = self.state
        if state.aim is None:
            return False
        left, bearing = _polar(state.aim, here)
        if left < ARRIVED:
            return False
        half_width = self.params.radius + self.params.squeeze
        is_blocked = view.reach(bearing, half_width)[0] <= min(left, 0.8)
        if is_blocked or state.patience <= 0.0:
            # Counted as visited, so that it is not the next aim as well.
            state.visits = np.vstack([state.visits, [state.aim[0], state.aim[1], 0.0]])
            return False
        is_turning = abs(bearing) > TURN_FIRST
        return is_turning or best < state.aim_score + self.params.hysteresis

    def _approach(self, view: View, here: Points) -> Speeds:
        """Turn towards the aim and drive as fast as the free way ahead allows."""
        if self.state.aim is None:
            return AT_REST
        params = self.params
        left, wanted = _polar(self.state.aim, here)
        bearing = self._clear_bearing(view, wanted, min(LOOK_AHEAD, left))
        angular = float(np.clip(2.5 * bearing, -params.turn_rate, params.turn_rate))
        if abs(bearing) > TURN_FIRST:
            return 0.0, angular
        free = float(view.reach(0.0, params.radius + 0.05)[0]) - params.radius - 0.08
        allowed = np.sqrt(max(0.0, 2.0 * 0.4 * free))
        linear = min(params.speed * np.cos(2.0 * bearing), allowed, 0.2 + view.gap - params.radius)
        return float(max(0.0, linear)), angular

    def _clear_bearing(self, view: View, wanted: float, ahead: float) -> float:
        """Return the bearing nearest to the wanted one whose strip is free for `ahead` m."""
        params = self.params
        angles = wanted + np.deg2rad(np.arange(-40.0, 41.0, 4.0))
        narrow = view.reach(angles, params.radius + params.squeeze)
        wide = view.reach(angles, params.radius + params.keep_clear)
        cost = np.abs(angles - wanted) + 0.7 * (wide < ahead) + 3.0 * (narrow < ahead)
        return float(wrap(angles[int(np.argmin(cost))]))


def _ways(bearings: NDArray[np.float64], lengths: NDArray[np.float64], shortest: float) -> Ways:
    """Return the ways (n,) that are longer than `shortest` m."""
    directions = np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
    ends, worth = lengths[:, None] * directions, lengths > shortest
    return Ways(ends[worth], bearings[worth], np.zeros(worth.sum(), bool))


def _polar(point: Points, here: Points) -> tuple[float, float]:
    """Return distance in m and bearing in rad of a point (2,) in odom seen from a pose (3,)."""
    x, y = se2.transform_points(se2.inverse(here), point[None])[0]
    return float(np.hypot(x, y)), float(np.arctan2(y, x))
