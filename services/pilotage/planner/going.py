"""Going to a place of the map: find a path, follow it, find another when that one is blocked; pure.

Whoever sends the robot asks `step` ten times a second. What it sees and the map lacks is
remembered for a while and gone round; if there is no other way, it waits for the way to be free
again, and after honest tries gives up and says why.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.laser_view import View
from pilotage.planner.ground import Ground
from pilotage.planner.mission import Target
from pilotage.planner.obstacles import Obstacles
from pilotage.planner.path_finding import NoPathError, find_path
from pilotage.planner.path_follower import PathFollower
from pilotage.planner.path_params import FollowerParams, Tolerances
from pilotage.planner.path_track import distances_to_line
from pilotage.planner.situation import Situation, Speeds

GoingState = Literal["going", "waiting", "arrived", "failed"]
AT_REST: Speeds = (0.0, 0.0)

UNSEEN_REACH = 1.5
"""m round the robot in which it minds unknown ground, which no laser shows."""


@dataclass(frozen=True)
class GoingParams:
    """When another path is looked for, and when it is given up."""

    memory: float = 30.0
    """Time for which something unseen is remembered, s."""
    new_from: float = 0.10
    """Distance from what the map has at which something counts as new, m."""
    blocking_from: float = 0.05
    """The same for what blocks the way, which is there for certain, m."""
    looked_ahead: float = 4.0
    """Length of the path ahead that is looked over for obstacles, m."""
    look_period: float = 1.0
    """Time between two such looks, s."""
    beside: float = 0.10
    """Gap below which something stands beside the robot and not in its path, m."""
    strayed: float = 0.5
    """Distance from the path at which another is looked for, m."""
    jump: float = 0.3
    """Distance by which the pose must shift against odometry to have jumped, m."""
    turn: float = float(np.deg2rad(20.0))
    """The same for its heading, rad."""
    tries: int = 12
    """How often it may look for another path without having got nearer in between."""
    nearer: float = 2.0
    """By how much shorter what is left of the path must be to have got nearer, m."""
    retry: float = 2.0
    """Time between two looks for a way while there is none, s."""
    patience: float = 15.0
    """Time that it waits for a way to become free, s."""
    settled: float = 0.5
    """Time that it stands at the goal until it has arrived, s."""


class Going:
    """On the way to a target; ends arrived or failed."""

    def __init__(
        self,
        ground: Ground,
        target: Target,
        situation: Situation,
        follower: FollowerParams | None = None,
        params: GoingParams | None = None,
    ) -> None:
        """Find the first path; NoPathError says why there is none."""
        self.params = params or GoingParams()
        self.state: GoingState = "going"
        self.reason = ""
        self.obstacles = Obstacles(ground, self.params.memory)
        self._ground, self._target = ground, target
        self._follower = PathFollower(follower)
        self._last = situation
        self._tries, self._nearest = 0, np.inf
        self._waited, self._stood = 0.0, 0.0
        self._next_look = situation.now + self.params.look_period
        self._take_path(situation.belief.best)

    @property
    def path(self) -> NDArray[np.float64]:
        """The corners (n, 2) of what is left of the path, map frame."""
        return self._follower.left

    @property
    def distance_left(self) -> float:
        """How long that is, m."""
        return float(np.hypot(*np.diff(self.path, axis=0).T).sum())

    @property
    def has_arrived(self) -> bool:
        """Whether the target is reached."""
        return self.state == "arrived"

    @property
    def failure(self) -> str | None:
        """Why it has been given up, in words; None as long as it has not."""
        return self.reason if self.state == "failed" else None

    def step(self, situation: Situation) -> Speeds:
        """Return the speeds until the next step."""
        if self.state in ("arrived", "failed"):
            return AT_REST
        here, before = situation.belief.best, self._last
        dt = float(np.clip(situation.now - before.now, 0.0, 0.5))
        self._last = situation
        try:
            if self._has_jumped(before, situation):
                self.obstacles.forget()
                self._take_path(here)
            self.obstacles.look(here, situation.view, situation.now, self.params.new_from)
            if self.state == "waiting":
                return self._wait(situation, dt)
            self._mind_what_lies_ahead(situation)
            return self._follow(situation, dt)
        except NoPathError as error:
            return self._give_up(str(error))

    def _follow(self, situation: Situation, dt: float) -> Speeds:
        """Follow the path; if that does not work, find another or wait."""
        here = situation.belief.best
        done = self._follower.step(here, self._with_unseen(situation.view, here), dt)
        self._stood = self._stood + dt if done.state == "arrived" else 0.0
        if self._stood >= self.params.settled:
            self.state, self.reason = "arrived", ""
        elif done.state == "blocked":
            self._get_round(situation, done.reason)
        elif self._follower.off_path > self.params.strayed:
            self._take_path(here)
        else:
            self.reason = done.reason
        return done.speeds

    def _get_round(self, situation: Situation, reason: str) -> None:
        """Find another path when this one is blocked, or begin to wait."""
        self._count_try(reason)
        here = situation.belief.best
        near = situation.view.points[np.hypot(*situation.view.points.T) < 1.0]
        blocking = View(near, situation.view.bearings)
        self.obstacles.look(here, blocking, situation.now, self.params.blocking_from)
        try:
            self._take_path(here)
        except NoPathError:
            self.state, self._waited = "waiting", 0.0
            self.reason = f"{reason}, which the map lacks, and there is no other way"
            self._next_look = situation.now + self.params.retry

    def _count_try(self, reason: str) -> None:
        """Count how often another path was needed without having got nearer since."""
        if self.distance_left < self._nearest - self.params.nearer:
            self._nearest, self._tries = self.distance_left, 0
        self._tries += 1
        if self._tries > self.params.tries:
            raise NoPathError(f"given up after {self.params.tries} tries: {reason}")

    def _wait(self, situation: Situation, dt: float) -> Speeds:
        """Stand until there is a way again; not for ever."""
        self._waited += dt
        if self._waited > self.params.patience:
            return self._give_up(f"blocked: {self.reason}")
        if situation.now >= self._next_look:
            self._next_look = situation.now + self.params.retry
            try:
                self._take_path(situation.belief.best)
                self.state = "going"
            except NoPathError:
                pass
        return AT_REST

    def _mind_what_lies_ahead(self, situation: Situation) -> None:
        """Take another path if something new stands on this one and there is one."""
        if situation.now < self._next_look:
            return
        self._next_look = situation.now + self.params.look_period
        if self._is_obstructed(situation.belief.best):
            try:
                self._take_path(situation.belief.best)
            except NoPathError:
                # It may have gone by the time the robot is there.
                return
            self._count_try("something stands in its way again and again")

    def _is_obstructed(self, here: NDArray[np.float64]) -> bool:
        """Say whether a remembered obstacle stands in the piece of the path ahead."""
        points, left = self.obstacles.points, self.params.looked_ahead
        reach = self._follower.params.radius + self._follower.params.least_gap
        # What the robot stands beside does not move away by another path.
        points = points[np.hypot(*(points - here[:2]).T) > reach + self.params.beside]
        for start, end in zip(self.path[:-1], self.path[1:], strict=True):
            length = float(np.hypot(*(end - start)))
            reached = start + (end - start) * min(1.0, left / max(length, 1e-6))
            if (distances_to_line(points, start, reached) < reach).any():
                return True
            left -= length
            if left <= 0.0:
                break
        return False

    def _take_path(self, here: NDArray[np.float64]) -> None:
        """Find a path round the obstacles and begin to follow it."""
        target, ground = self._target, self._ground.with_obstacles(self.obstacles.points)
        path = find_path(ground, here[:2], target.pose[:2], self._follower.params.radius)
        tolerances = Tolerances(target.position_tolerance, target.heading_tolerance)
        self._follower.begin(path, float(target.pose[2]), tolerances)

    def _give_up(self, reason: str) -> Speeds:
        self.state, self.reason = "failed", reason
        return AT_REST

    def _has_jumped(self, before: Situation, situation: Situation) -> bool:
        """Say whether the pose moved otherwise than odometry says."""
        moved = se2.between(before.odom_from_base, situation.odom_from_base)
        expected = se2.compose(before.belief.best, moved)
        off = situation.belief.best - expected
        shift, turn = float(np.hypot(off[0], off[1])), abs(wrap(float(off[2])))
        return shift > self.params.jump or turn > self.params.turn

    def _with_unseen(self, view: View, here: NDArray[np.float64]) -> View:
        """Return the view with the edge of unknown ground, which stops the robot as walls do."""
        edge = self._ground.unseen_near(here[:2], UNSEEN_REACH)
        if len(edge) == 0:
            return view
        points = se2.transform_points(se2.inverse(here), edge)
        return View(np.vstack([view.points, points]), view.bearings)
