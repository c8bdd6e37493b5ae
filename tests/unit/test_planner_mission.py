"""What comes first: finding out where the robot is, or going where it is told."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from pilotage.core.laser_view import View
from pilotage.planner.mission import Mission, MissionParams, NoWayError, Target
from pilotage.planner.situation import Hypotheses, Situation, Speeds, State

NOWHERE = View(np.zeros((0, 2)), np.linspace(-2.0, 2.0, 61))
KITCHEN = Target(np.array([3.0, 2.0, 0.0]))
SEARCHING: Speeds = (0.1, 0.5)
GOING: Speeds = (0.4, 0.0)


class Searching:
    """A search that turns about."""

    failure: str | None = None

    def step(self, _situation: Situation) -> Speeds:
        return SEARCHING


@dataclass
class Straight:
    """A way that is gone in so many steps, or fails."""

    steps: int = 10
    fails: str | None = None
    has_arrived: bool = False
    failure: str | None = None
    reason: str = ""
    path: NDArray[np.float64] = field(default_factory=lambda: np.zeros((2, 2)))
    distance_left: float = 1.0

    def step(self, _situation: Situation) -> Speeds:
        self.steps -= 1
        self.has_arrived = self.steps <= 0 and self.fails is None
        self.failure = self.fails if self.steps <= 0 else None
        return GOING


class Story:
    """A mission, stepped ten times a second."""

    def __init__(self, *, always: bool = False, way: Straight | str | None = None) -> None:
        self.now = 100.0
        self.state: State = "localized"
        self.missing: str | None = None
        self.planned = 0
        self._way = way
        self.mission = Mission(Searching, self._plan, MissionParams(), always=always)

    def _plan(self, _target: Target, _situation: Situation) -> Straight:
        self.planned += 1
        if isinstance(self._way, str):
            raise NoWayError(self._way)
        return self._way or Straight()

    @property
    def mode(self) -> str:
        """What the mission is about."""
        return self.mission.mode

    def situation(self) -> Situation | None:
        if self.missing:
            return None
        belief = Hypotheses(np.zeros((1, 3)), np.ones(1))
        return Situation(self.now, np.zeros(3), NOWHERE, belief, self.state)

    def run(self, seconds: float) -> list[Speeds | None]:
        """Let so much time pass, as the service does."""
        speeds = []
        for _ in range(round(10.0 * seconds)):
            self.now += 0.1
            if self.situation() is not None and self.mission.must_search(self.now):
                self.mission.localize()
            speeds.append(self.mission.step(self.now, self.situation(), self.missing))
        return speeds


def test_a_robot_that_is_told_nothing_is_left_alone() -> None:
    story = Story()
    assert story.run(2.0) == [None] * 20
    story.state = "ambiguous"
    assert story.run(5.0) == [None] * 50
    assert (story.mission.mode, story.mission.outcome) == ("idle", "none")


def test_a_robot_that_knows_where_it_is_goes_and_arrives_and_stands() -> None:
    story = Story()
    story.mission.go_to(KITCHEN, Straight(steps=10))
    assert story.run(0.9) == [GOING] * 9
    assert (story.mission.mode, story.mission.reason) == ("going", "going to (3.00, 2.00)")
    assert story.run(0.2) == [None, None]
    assert (story.mission.mode, story.mission.outcome) == ("idle", "done")
    assert story.mission.reason == "at (3.00, 2.00)"
    assert story.mission.ending == "stand"
    assert story.mission.target is None


def test_a_robot_that_does_not_know_where_it_is_finds_out_before_it_goes() -> None:
    story = Story()
    story.state = "ambiguous"
    story.mission.go_to(KITCHEN, None)
    story.run(1.5)
    assert story.run(1.0) == [SEARCHING] * 10
    assert story.mode == "localizing"
    assert story.mission.reason == "finding out where it is, then on to (3.00, 2.00)"
    story.state = "localized"
    assert (0.0, 0.0) in story.run(0.9), "it stands until it is sure"
    assert GOING in story.run(1.0)
    assert story.mode == "going"


@pytest.mark.parametrize("state", ["ambiguous", "lost", "unknown"])
def test_doubt_on_the_way_is_resolved_and_the_way_planned_anew(state: State) -> None:
    story = Story(way=Straight(steps=1000))
    story.mission.go_to(KITCHEN, Straight(steps=1000))
    story.run(1.0)
    story.state = state
    assert story.run(0.9) == [(0.0, 0.0)] * 9, "it stands, for it may pass"
    assert SEARCHING in story.run(1.0)
    story.state = "localized"
    story.run(2.0)
    assert story.planned == 1
    assert story.run(1.0) == [GOING] * 10


def test_doubt_that_passes_is_waited_for() -> None:
    story = Story()
    way = Straight(steps=1000)
    story.mission.go_to(KITCHEN, way)
    story.run(1.0)
    story.state = "lost"
    story.run(0.5)
    story.state = "localized"
    assert story.run(1.0) == [GOING] * 10
    assert story.mission.way is way


def test_a_goal_that_turns_out_to_be_out_of_reach_is_given_up_with_the_reason() -> None:
    story = Story(way="a wall all round it")
    story.state = "ambiguous"
    story.mission.go_to(KITCHEN, None)
    story.run(2.0)
    story.state = "localized"
    story.run(2.0)
    assert (story.mission.mode, story.mission.outcome) == ("idle", "failed")
    assert story.mission.reason == "a wall all round it"


def test_a_way_that_is_blocked_is_given_up_with_the_reason() -> None:
    story = Story()
    story.mission.go_to(KITCHEN, Straight(steps=3, fails="a box stands in the door"))
    story.run(1.0)
    assert (story.mission.outcome, story.mission.reason) == ("failed", "a box stands in the door")
    assert story.mission.ending == "stand"


def test_why_it_stands_on_the_way_is_said() -> None:
    story = Story()
    story.mission.go_to(KITCHEN, Straight(steps=100, reason="waits for a person"))
    story.run(1.0)
    assert story.mission.reason == "going to (3.00, 2.00): waits for a person"


def test_a_search_ends_when_the_pose_is_known_and_what_was_before_goes_on() -> None:
    story = Story()
    story.state = "ambiguous"
    story.run(1.0)
    story.mission.localize()
    assert story.run(1.0) == [SEARCHING] * 10
    story.state = "localized"
    story.run(1.5)
    assert (story.mission.mode, story.mission.outcome) == ("idle", "done")
    assert story.mission.ending == "resume"


def test_a_search_that_finds_nothing_ends_and_is_not_begun_again_at_once() -> None:
    story = Story(always=True)
    story.mission.params = MissionParams(longest_search=5.0, pause=20.0)
    story.state = "ambiguous"
    story.run(7.0)
    assert (story.mission.mode, story.mission.outcome) == ("idle", "failed")
    assert "after 5 s" in story.mission.reason
    assert story.run(10.0) == [None] * 100
    story.run(12.0)
    assert story.mode == "localizing"


def test_every_doubt_is_resolved_unasked_if_that_is_wished() -> None:
    story = Story(always=True)
    story.run(1.0)
    story.state = "lost"
    assert story.run(0.9) == [None] * 9
    assert SEARCHING in story.run(0.5)
    story.state = "localized"
    story.run(2.0)
    assert story.mode == "idle"
    story.state = "ambiguous"
    story.run(2.0)
    assert story.mode == "localizing"


def test_what_is_missing_is_waited_for_and_said() -> None:
    story = Story()
    story.mission.go_to(KITCHEN, Straight(steps=1000))
    story.run(1.0)
    story.missing = "no scan for 1.1 s"
    assert story.run(1.0) == [None] * 10
    assert (story.mission.mode, story.mission.reason) == ("waiting", "no scan for 1.1 s")
    story.missing = None
    assert story.run(1.0) == [GOING] * 10
    assert story.mode == "going"


def test_what_is_missing_for_too_long_ends_the_task() -> None:
    story = Story()
    story.mission.go_to(KITCHEN, Straight(steps=1000))
    story.missing = "no pose for 3.0 s"
    story.run(31.0)
    assert (story.mission.mode, story.mission.outcome) == ("idle", "failed")
    assert story.mission.reason == "given up after 30 s: no pose for 3.0 s"


def test_a_new_goal_takes_the_place_of_the_old_one() -> None:
    story = Story()
    story.mission.go_to(KITCHEN, Straight(steps=1000))
    story.run(1.0)
    story.mission.go_to(Target(np.array([5.0, 5.0, 0.0])), Straight(steps=1000))
    story.run(1.0)
    assert story.mission.reason == "going to (5.00, 5.00)"
    assert story.mission.ending is None


def test_what_is_cancelled_is_over() -> None:
    story = Story()
    story.mission.go_to(KITCHEN, Straight(steps=1000))
    story.run(1.0)
    story.mission.end("cancelled", "cancelled: going to (3.00, 2.00)")
    assert story.mission.ending == "stand"
    assert story.run(1.0) == [None] * 10
    assert (story.mission.outcome, story.mission.task) == ("cancelled", "")


def test_a_search_that_gives_up_is_told_and_not_begun_again_at_once() -> None:
    story = Story(always=True)
    story.state = "ambiguous"
    story.run(3.0)
    assert story.mode == "localizing"
    assert isinstance(story.mission.search, Searching)
    story.mission.search.failure = "nothing tells the 4 places apart"
    assert story.run(0.1) == [None]
    assert (story.mode, story.mission.outcome) == ("idle", "failed")
    assert story.mission.reason == "nothing tells the 4 places apart"
    assert story.mission.ending == "resume"
    story.run(30.0)
    assert story.mode == "idle"
    story.run(40.0)
    assert story.mode == "localizing", "people may have changed the room meanwhile"
