"""Towards an aim in sight without touching anything on the way; pure."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.laser_view import View
from pilotage.planner.situation import Speeds

TURN_FIRST = 0.5
"""Turn [rad] beyond which the robot turns on the spot."""

TIGHT = 0.02
"""Gap [m] with which the robot leaves a nook that it cannot leave otherwise."""

LOOK_AHEAD = 0.9
"""Length [m] of the strip that has to be free in the direction of travel."""

SIDESTEP = np.deg2rad(np.arange(-60.0, 61.0, 4.0))
"""By how much [rad] the robot may deviate from the straight way to its aim."""


@dataclass(frozen=True)
class Body:
    """The robot that is steered: `radius` [m], and the gap [m] it keeps to what it passes."""

    radius: float = 0.165
    gap: float = 0.10
    speed: float = 0.5
    """m/s."""
    turn_rate: float = 1.2
    """rad/s."""

    @property
    def half_width(self) -> float:
        """Half width [m] of a strip that the robot may drive along."""
        return self.radius + self.gap

    def fitting(self, view: View, shortest: float) -> "Body":
        """Return the body with less of a gap, if it needs that to find any way of this length."""
        tighter = [replace(self, gap=gap) for gap in (self.gap, 0.5 * self.gap, TIGHT)]
        for body in tighter:
            if (body.way(view, view.bearings) > shortest).any():
                return body
        return tighter[-1]

    def way(self, view: View, bearings: ArrayLike) -> NDArray[np.float64]:
        """Return how far (n,) [m] the robot may go straight on along `bearings` (n,)."""
        ways: NDArray[np.float64] = view.reach(bearings, self.half_width) - self.half_width
        return np.maximum(ways, 0.0)


def polar(point_odom: NDArray[np.float64], odom_from_base: ArrayLike) -> tuple[float, float]:
    """Return distance [m] and bearing [rad] of a point (2,) seen from base_link."""
    x, y = se2.transform_points(se2.inverse(odom_from_base), point_odom[None])[0]
    return float(np.hypot(x, y)), float(np.arctan2(y, x))


def towards(view: View, aim: tuple[float, float], body: Body) -> Speeds:
    """Return the speeds towards an aim at distance [m] and bearing [rad], round what is near."""
    left, wanted = aim
    angles = wanted + SIDESTEP
    is_free = view.reach(angles, body.half_width) > min(LOOK_AHEAD, left + body.radius)
    cost = np.abs(SIDESTEP) + 10.0 * ~is_free
    return along(view, float(wrap(angles[int(np.argmin(cost))])), body)


def along(view: View, bearing: float, body: Body) -> Speeds:
    """Return the speeds that turn the robot to a bearing [rad] and drive as what is free allows."""
    angular = float(np.clip(2.5 * bearing, -body.turn_rate, body.turn_rate))
    if abs(bearing) > TURN_FIRST:
        return 0.0, angular
    strip = body.radius + min(0.04, 0.5 * body.gap)
    free = float(view.reach(0.0, strip)[0]) - body.radius - 0.08
    # It stops from v within v^2 / 2a, were it to brake no harder than at a = 0.4 m/s^2.
    allowed = np.sqrt(max(0.0, 0.8 * free))
    slow = 0.15 + max(0.0, view.gap - body.radius)
    return float(min(body.speed * np.cos(2.0 * bearing), allowed, slow)), angular
