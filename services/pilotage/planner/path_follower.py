"""Following a path with a differential drive, touching nothing; pure.

Regulated pure pursuit (Coulter 1992, "Implementation of the pure pursuit path tracking
algorithm"; Macenski et al. 2023, "Regulated pure pursuit for robot path tracking"): drive along
the arc to a point of the path ahead, slower in curves, near things and near the goal; turn on the
spot if that point is not ahead. Whatever is seen on the arc is stopped for in time.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.angles import wrap
from pilotage.core.laser_view import View
from pilotage.planner.path_braking import free_way, safe_speed
from pilotage.planner.path_params import FollowerParams, Tolerances
from pilotage.planner.path_steering import Aim, aim_on, steered_past
from pilotage.planner.path_track import Track
from pilotage.planner.situation import Speeds

Progress = Literal["following", "arrived", "blocked"]

SEARCHED = 1.0
"""m of the path, behind and ahead, in which the robot looks for where it is."""
HORIZON = 1.2
"""m ahead that the body's way is looked at."""
CRAWL = 0.03
"""m/s below which it does not count as driving."""
STRAIGHT = 0.06
"""rad within which something counts as straight ahead."""
CLOSE = 0.03
"""m from the goal at which it is not gone nearer to."""


@dataclass(frozen=True)
class FollowerStep:
    """What to do now: speeds, how it is going, and why it is not."""

    speeds: Speeds
    state: Progress
    reason: str = ""


@dataclass
class _Ride:
    """One path on its way: where the robot is along it, in m and s."""

    track: Track
    heading: float | None
    tolerances: Tolerances
    way: float = 0.0
    off_path: float = 0.0
    farthest: float = 0.0
    since_farthest: float = 0.0
    waiting: float = 0.0
    aside: float = 0.0
    turning: bool = False
    at_goal: bool = False
    turned: bool = False


class PathFollower:
    """Follows one path after the other: `begin` each, then `step` ten times a second."""

    def __init__(self, params: FollowerParams | None = None) -> None:
        self.params = params or FollowerParams()
        self._ride: _Ride | None = None
        self._speed = 0.0

    def begin(
        self,
        path: ArrayLike,
        final_heading: float | None = None,
        tolerances: Tolerances | None = None,
    ) -> None:
        """Take a path (n, 2) in m, n >= 2, and the heading in rad to end with (None: any).

        A robot that drives need not stop for a new path.
        """
        self._ride = _Ride(Track(np.array(path, float)), final_heading, tolerances or Tolerances())

    @property
    def off_path(self) -> float:
        """How far in m the robot was from its path at the last step."""
        return self._ride.off_path if self._ride else 0.0

    @property
    def left(self) -> NDArray[np.float64]:
        """The corners (n, 2) of what is left of the path, from where the robot is along it."""
        if self._ride is None:
            return np.zeros((0, 2))
        track, way = self._ride.track, self._ride.way
        return np.vstack([track.at(way), track.corners[track.ways > way]])

    def step(self, pose: ArrayLike, view: View, dt: float) -> FollowerStep:
        """Return what to do until the next step.

        Args:
            pose: (3,) base_link in the frame of the path.
            view: what is seen, in base_link; by a laser, or the echoes of a sonar ring.
            dt: time since the last step, s.
        """
        if self._ride is None:
            return self._standing("arrived")
        ride, here = self._ride, np.asarray(pose, float)
        _note_progress(ride, here, dt)
        _note_arrival(ride, here)
        if ride.at_goal:
            return self._turn_to_heading(ride, here)
        if ride.since_farthest > self.params.stuck:
            return self._standing("blocked", "it does not get on along its path")
        return self._drive(ride, here, view, dt)

    def _drive(self, ride: _Ride, here: NDArray[np.float64], view: View, dt: float) -> FollowerStep:
        aim = steered_past(view, aim_on(ride.track, ride.way, here), ride.aside, self.params)
        ride.aside = aim.aside
        free = free_way(view.points, aim.curvature, self._reach, HORIZON)
        speed = min(
            self._allowed(ride, aim, view, free), self._speed + self.params.acceleration * dt
        )
        if self._turns(ride, aim, speed):
            self._speed = ride.waiting = 0.0
            return FollowerStep((0.0, self._turn_rate(aim.bearing)), "following")
        if speed < CRAWL:
            return self._wait(ride, here, free, dt)
        self._speed, ride.waiting = speed, 0.0
        return FollowerStep((speed, speed * aim.curvature), "following")

    @property
    def _reach(self) -> float:
        return self.params.radius + self.params.least_gap

    def _allowed(self, ride: _Ride, aim: Aim, view: View, free: float) -> float:
        """Return the speed in m/s that curve, goal and surroundings allow."""
        params = self.params
        bend = max(abs(aim.curvature), 1e-6)
        left = ride.track.length - ride.way
        return min(
            params.max_linear,
            params.max_angular / bend,
            float(np.sqrt(params.sideways_acceleration / bend)),
            float(np.sqrt(2.0 * params.braking_at_goal * left)) + 2.0 * CRAWL,
            0.15 + max(0.0, view.gap - params.radius),
            safe_speed(free, params.braking, params.delay),
        )

    def _turns(self, ride: _Ride, aim: Aim, speed: float) -> bool:
        """Say whether to turn on the spot: what is steered for is not ahead, or not on an arc."""
        angle = abs(aim.bearing)
        limit = self.params.turned if ride.turning else self.params.turn_first
        if speed < CRAWL:
            # The arc there is blocked, but straight on it may be free.
            limit = STRAIGHT
        ride.turning = angle > limit
        return ride.turning

    def _turn_rate(self, angle: float) -> float:
        """Return how fast to turn by an angle in rad: slower towards its end, rad/s."""
        rate = np.clip(2.0 * abs(angle), 0.15, self.params.max_angular)
        return float(np.copysign(rate, angle))

    def _wait(self, ride: _Ride, here: NDArray[np.float64], free: float, dt: float) -> FollowerStep:
        """Stand until what is in the way has gone; for so long, that is."""
        self._speed = 0.0
        ride.waiting += dt
        if _to_goal(ride, here) <= ride.tolerances.position:
            ride.at_goal = True
        if ride.waiting < self.params.patience:
            return self._standing("following", "waits for what stands in its way to go away")
        return self._standing(
            "blocked", f"something stands in its way, {max(free, 0.0):.2f} m ahead"
        )

    def _turn_to_heading(self, ride: _Ride, here: NDArray[np.float64]) -> FollowerStep:
        """Turn on the spot to the final heading."""
        self._speed = 0.0
        if ride.heading is None:
            return self._standing("arrived")
        angle = wrap(ride.heading - float(here[2]))
        # Poses are noisy: what is well within the tolerance need not be so at every look.
        enough = 0.8 if ride.turned else 0.4
        ride.turned = abs(angle) <= enough * ride.tolerances.heading
        if ride.turned:
            return self._standing("arrived")
        return FollowerStep((0.0, self._turn_rate(angle)), "following")

    def _standing(self, state: Progress, reason: str = "") -> FollowerStep:
        self._speed = 0.0
        return FollowerStep((0.0, 0.0), state, reason)


def _note_progress(ride: _Ride, here: NDArray[np.float64], dt: float) -> None:
    """Find where along the path the robot is, and for how long it has not got on."""
    ride.way, ride.off_path = ride.track.nearest(here[:2], ride.way - SEARCHED, ride.way + SEARCHED)
    ride.since_farthest += dt
    if ride.way > ride.farthest + 0.05:
        ride.farthest, ride.since_farthest = ride.way, 0.0


def _note_arrival(ride: _Ride, here: NDArray[np.float64]) -> None:
    """Notice that the goal is reached, or that it is not after all: poses shift."""
    distance, goal = _to_goal(ride, here), ride.track.corners[-1]
    if ride.at_goal:
        ride.at_goal = distance <= ride.tolerances.position
        return
    ahead = np.array([np.cos(here[2]), np.sin(here[2])]) @ (goal - here[:2])
    is_past = ahead <= 0.0 and distance <= 0.6 * ride.tolerances.position
    ride.at_goal = bool(ride.track.length - ride.way < SEARCHED and (distance <= CLOSE or is_past))


def _to_goal(ride: _Ride, here: NDArray[np.float64]) -> float:
    return float(np.hypot(*(ride.track.corners[-1] - here[:2])))
