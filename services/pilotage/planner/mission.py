"""What the planner is about: going somewhere, finding out where it is, and what comes first; pure.

A robot that is sent somewhere and does not know where it is finds that out before it goes, and
whenever it becomes unsure on the way. Times are seconds of a clock that never goes backwards.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from pilotage.planner.situation import Policy, Situation, Speeds

Mode = Literal["idle", "going", "localizing", "waiting"]
Outcome = Literal["none", "done", "cancelled", "interrupted", "failed"]
Ending = Literal["stand", "resume"]
AT_REST: Speeds = (0.0, 0.0)


class NoWayError(ValueError):
    """There is no way to a goal; the text says why, in one line."""


@dataclass(frozen=True)
class Target:
    """A pose (3,) in map to reach, within so many m and rad."""

    pose: NDArray[np.float64]
    position_tolerance: float = 0.10
    heading_tolerance: float = 0.0873

    def __str__(self) -> str:
        return f"({self.pose[0]:.2f}, {self.pose[1]:.2f})"


class Search(Policy, Protocol):
    """A search for where the robot is."""

    @property
    def failure(self) -> str | None:
        """Why it cannot be found out, in words; None as long as it may."""
        ...


class Way(Policy, Protocol):
    """A way to a target, being gone."""

    @property
    def reason(self) -> str:
        """Why the robot stands, in words; empty while it gets on."""
        ...

    @property
    def path(self) -> NDArray[np.float64]:
        """The corners (n, 2) of what is left of it, map frame."""
        ...

    @property
    def distance_left(self) -> float:
        """How long that is, m."""
        ...

    @property
    def has_arrived(self) -> bool:
        """Whether the target is reached."""
        ...

    @property
    def failure(self) -> str | None:
        """Why the target cannot be reached any more, in words; None as long as it can."""
        ...


@dataclass(frozen=True)
class MissionParams:
    """When to begin and when to end what.

    `doubt`: s for which the pose is not `localized` before one looks for it; `settled`: s for
    which it is before one relies on it again. `patience`: s to wait for what is missing.
    `longest_search`: s after which finding out where one is has failed; `pause`: s until it is
    tried again without being asked.
    """

    doubt: float = 1.0
    settled: float = 1.0
    patience: float = 30.0
    longest_search: float = 600.0
    pause: float = 60.0


@dataclass
class Mission:
    """Decides who drives: a way, a search, or nobody.

    `begin_search` returns a policy that finds out where the robot is; `plan_way(target,
    situation)` one that goes there, or raises NoWayError. `ending` is set when a task has just
    ended, and says whether the robot shall stand or may go on with what it did before.
    """

    begin_search: Callable[[], Search]
    plan_way: Callable[[Target, Situation], Way]
    params: MissionParams = field(default_factory=MissionParams)
    always: bool = False
    mode: Mode = "idle"
    reason: str = "nothing to do"
    outcome: Outcome = "none"
    ending: Ending | None = None
    target: Target | None = None
    way: Way | None = None
    search: Search | None = None
    _is_asked_to_search: bool = False
    _searching_since: float = 0.0
    _waiting_since: float | None = None
    _sure_since: float | None = None
    _unsure_since: float | None = None
    _paused_until: float = -np.inf

    @property
    def is_busy(self) -> bool:
        """Whether there is something to do."""
        return self.target is not None or self._is_asked_to_search

    @property
    def task(self) -> str:
        """What is being done, in words; empty if nothing is."""
        if self.target is not None:
            return f"going to {self.target}"
        return "finding out where it is" if self._is_asked_to_search else ""

    def go_to(self, target: Target, way: Way | None) -> None:
        """Go to a target, in place of what was done before; `way` if it is planned already."""
        self._drop()
        self.target, self.way = target, way
        self._begin("going", f"going to {target}")

    def localize(self) -> None:
        """Find out where the robot is, in place of what was done before."""
        self._drop()
        self._is_asked_to_search = True
        self._begin("localizing", "finding out where it is")

    def end(self, outcome: Outcome, reason: str, ending: Ending | None = "stand") -> None:
        """End what is being done; None as ending: somebody else drives already."""
        self._drop()
        self.mode, self.outcome, self.reason, self.ending = "idle", outcome, reason, ending

    def step(self, now: float, situation: Situation | None, missing: str | None) -> Speeds | None:
        """Return how fast to drive now; None: not by this mission.

        `situation` is None while something is `missing`, which says in words what.
        """
        self._follow(situation)
        if not self.is_busy:
            return None
        if situation is None:
            self._wait(now, missing or "not all is known")
            return None
        self._waiting_since = None
        return self._searched(situation) if self._is_searching(situation) else self._gone(situation)

    def must_search(self, now: float) -> bool:
        """Say whether it is time to find out where the robot is without being asked."""
        is_free = self.always and not self.is_busy and now >= self._paused_until
        return is_free and self._is_in_doubt(now)

    def _begin(self, mode: Mode, reason: str) -> None:
        self.mode, self.reason, self.outcome, self.ending = mode, reason, "none", None

    def _drop(self) -> None:
        self.target = self.way = self.search = self._waiting_since = None
        self._is_asked_to_search = False

    def _follow(self, situation: Situation | None) -> None:
        """Note since when the pose has been sure, or not."""
        if situation is None:
            return
        if situation.state == "localized":
            self._unsure_since = None
            self._sure_since = situation.now if self._sure_since is None else self._sure_since
        else:
            self._sure_since = None
            self._unsure_since = situation.now if self._unsure_since is None else self._unsure_since

    def _is_in_doubt(self, now: float) -> bool:
        return self._unsure_since is not None and now - self._unsure_since >= self.params.doubt

    def _is_settled(self, now: float) -> bool:
        return self._sure_since is not None and now - self._sure_since >= self.params.settled

    def _wait(self, now: float, missing: str) -> None:
        """Wait for what is missing, but not for ever."""
        self.mode, self.reason = "waiting", missing
        self._waiting_since = now if self._waiting_since is None else self._waiting_since
        if now - self._waiting_since > self.params.patience:
            self.end("failed", f"given up after {self.params.patience:g} s: {missing}")

    def _is_searching(self, situation: Situation) -> bool:
        if self.search is None and (self._is_asked_to_search or self._is_in_doubt(situation.now)):
            self.search = self.begin_search()
            self._searching_since = situation.now
        return self.search is not None

    def _searched(self, situation: Situation) -> Speeds | None:
        """Find out where the robot is; that done, go on to the target if there is one."""
        assert self.search is not None  # noqa: S101 - the caller has looked
        if self._is_settled(situation.now):
            return self._found(situation)
        if self.search.failure is not None:
            self._paused_until = situation.now + self.params.pause
            self.end("failed", self.search.failure, "resume")
            return None
        if situation.now - self._searching_since > self.params.longest_search:
            self._paused_until = situation.now + self.params.pause
            spent = f"{self.params.longest_search:g} s"
            self.end("failed", f"it does not know where it is after {spent}", "resume")
            return None
        onward = "" if self.target is None else f", then on to {self.target}"
        self.mode, self.reason = "localizing", f"finding out where it is{onward}"
        return AT_REST if situation.state == "localized" else self.search.step(situation)

    def _found(self, situation: Situation) -> Speeds | None:
        if self.target is None:
            self.end("done", "it knows where it is", "resume")
            return None
        self.search = self.way = None
        self._is_asked_to_search = False
        return self._gone(situation)

    def _gone(self, situation: Situation) -> Speeds | None:
        assert self.target is not None  # noqa: S101 - the caller has looked
        self.mode, self.reason = "going", f"going to {self.target}"
        if situation.state != "localized":
            return AT_REST
        try:
            self.way = self.way or self.plan_way(self.target, situation)
        except NoWayError as error:
            self.end("failed", str(error))
            return None
        speeds = self.way.step(situation)
        self.reason += f": {self.way.reason}" if self.way.reason else ""
        if self.way.has_arrived:
            self.end("done", f"at {self.target}")
            return None
        if self.way.failure is not None:
            self.end("failed", self.way.failure)
            return None
        return speeds
