"""Wandering: go where it is open and where one has not been lately, and touch nothing; pure.

Ways are straight, so a way is free if no measured point lies within a strip along it. From time
to time the robot looks at the free ways around it and picks the end of one: the longer, the
straighter ahead and the less visited, the better. Then it turns towards it and drives.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.robot.watchdog import AT_REST, Speeds

Points = NDArray[np.float64]

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
    speed: float = 0.45
    """m/s."""
    turn_rate: float = 1.0
    """rad/s."""
    sight: float = 5.0
    """Longest way that is planned at once, m."""
    period: float = 0.5
    """Time between two looks around, s."""
    memory: float = 240.0
    """Time after which a visit is half forgotten, s."""
    hysteresis: float = 1.2
    """How much better a new aim must be than the present one."""


@dataclass
class WanderState:
    """What the robot remembers: its aim and its visits, in odom."""

    aim: Points | None = None
    aim_score: float = 0.0
    aim_gap: float = 0.0
    since_look: float = np.inf
    spin: float = 1.0
    visits: Points = field(default_factory=lambda: np.zeros((0, 3)))
    """(n, 3): x, y, age in s."""


@dataclass(frozen=True)
class View:
    """What the laser sees, in base_link: `points` (n, 2) in m, and where it sees at all.

    `bearings` (m,) rad of directions that the laser covers.
    """

    points: Points
    bearings: NDArray[np.float64]

    @classmethod
    def of(cls, ranges: ArrayLike, bearings: ArrayLike, mount: ArrayLike) -> "View":
        """Return the view of a laser at `mount` (3,) from its ranges (n,) and bearings (n,)."""
        distances, angles = np.asarray(ranges, float), np.asarray(bearings, float)
        hit = np.isfinite(distances)
        rays = distances[hit, None] * np.stack([np.cos(angles[hit]), np.sin(angles[hit])], axis=1)
        candidates = wrap(np.linspace(angles[0], angles[-1], 73) + float(np.asarray(mount)[2]))
        return cls(se2.transform_points(mount, rays), candidates)

    def with_contact(self, bearing: float) -> "View":
        """Return the view with a point where the body touches what the laser does not see."""
        point = 0.1 * np.array([[np.cos(bearing), np.sin(bearing)]])
        return View(np.vstack([self.points, point]), self.bearings)

    def reach(self, bearings: ArrayLike, half_width: float) -> NDArray[np.float64]:
        """Return how far (m,) strips of this half width at `bearings` (m,) are free, m.

        Measured from the centre of the robot to the first point in the strip.
        """
        angles = np.atleast_1d(np.asarray(bearings, float))
        along = np.outer(np.cos(angles), self.points[:, 0]) + np.outer(
            np.sin(angles), self.points[:, 1]
        )
        across = np.outer(-np.sin(angles), self.points[:, 0]) + np.outer(
            np.cos(angles), self.points[:, 1]
        )
        blocks = (np.abs(across) < half_width) & (along > 0.0)
        nearest: NDArray[np.float64] = np.where(blocks, along, np.inf).min(axis=1, initial=np.inf)
        return nearest

    @property
    def gap(self) -> float:
        """Distance in m from the robot's centre to the nearest point."""
        return float(np.hypot(self.points[:, 0], self.points[:, 1]).min(initial=np.inf))


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
        ends, gaps, bearings = self._free_ways(view)
        if len(ends) == 0:
            state.aim = None
            return
        in_odom = se2.transform_points(here, ends)
        scores = self._scores(in_odom, ends, bearings)
        best = int(np.argmax(scores + self._rng.gumbel(0.0, 0.15, len(scores))))
        if self._keeps_aim(view, here, float(scores[best])):
            return
        state.aim, state.aim_score, state.aim_gap = in_odom[best], float(scores[best]), gaps[best]
        state.spin = 1.0 if bearings[best] >= 0.0 else -1.0

    def _free_ways(self, view: View) -> tuple[Points, NDArray[np.float64], NDArray[np.float64]]:
        """Return ends (n, 2) of free ways in base_link, their gaps (n,) and bearings (n,)."""
        params = self.params
        ends, gaps, bearings = [], [], []
        for gap in (params.keep_clear, params.squeeze):
            half_width = params.radius + gap
            lengths = np.minimum(view.reach(view.bearings, half_width) - half_width, params.sight)
            for share in (1.0, 0.6):
                worth = share * lengths > 0.5
                ways = share * lengths[worth]
                angles = view.bearings[worth]
                ends.append(ways[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))
                gaps.append(np.full(len(ways), gap))
                bearings.append(angles)
        return np.vstack(ends), np.concatenate(gaps), np.concatenate(bearings)

    def _scores(
        self, in_odom: Points, ends: Points, bearings: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return how good each end (n, 2) is as an aim."""
        visits = self.state.visits
        squared = ((in_odom[:, None, :] - visits[None, :, :2]) ** 2).sum(axis=2)
        freshness = 0.5 ** (visits[:, 2] / self.params.memory)
        visited = (np.exp(-squared / (2.0 * 0.8**2)) * freshness).sum(axis=1)
        length = np.hypot(ends[:, 0], ends[:, 1])
        scores: NDArray[np.float64] = 0.25 * length + 0.4 * np.cos(bearings) - 1.0 * visited
        return scores

    def _keeps_aim(self, view: View, here: Points, best: float) -> bool:
        """Say whether the present aim is worth going on with."""
        state = self.state
        if state.aim is None:
            return False
        ahead = se2.transform_points(se2.inverse(here), state.aim[None])[0]
        left = float(np.hypot(*ahead))
        if left < 0.3:
            return False
        bearing = float(np.arctan2(ahead[1], ahead[0]))
        half_width = self.params.radius + min(state.aim_gap, self.params.squeeze)
        is_free = view.reach(bearing, half_width)[0] > min(left, 0.8)
        return bool(is_free) and best < state.aim_score + self.params.hysteresis

    def _approach(self, view: View, here: Points) -> Speeds:
        """Turn towards the aim and drive as fast as the free way ahead allows."""
        if self.state.aim is None:
            return AT_REST
        params = self.params
        ahead = se2.transform_points(se2.inverse(here), self.state.aim[None])[0]
        bearing = self._clear_bearing(view, float(np.arctan2(ahead[1], ahead[0])))
        angular = float(np.clip(2.5 * bearing, -params.turn_rate, params.turn_rate))
        if abs(bearing) > 0.5:
            return 0.0, angular
        free = float(view.reach(0.0, params.radius + 0.05)[0]) - params.radius - params.squeeze
        allowed = np.sqrt(max(0.0, 2.0 * 0.3 * free))
        linear = min(params.speed * np.cos(2.0 * bearing), allowed, 0.15 + view.gap - params.radius)
        return float(max(0.0, linear)), angular

    def _clear_bearing(self, view: View, wanted: float) -> float:
        """Return the bearing nearest to the wanted one whose strip is free for a metre or two."""
        params = self.params
        angles = wanted + np.deg2rad(np.arange(-30.0, 31.0, 3.0))
        half_width = params.radius + params.squeeze
        reach = view.reach(angles, half_width)
        wide = view.reach(angles, params.radius + params.keep_clear)
        cost = np.abs(angles - wanted) + 0.6 * (wide < LOOK_AHEAD) + 3.0 * (reach < LOOK_AHEAD)
        return float(wrap(angles[int(np.argmin(cost))]))
