"""What is known now, from beliefs that are older."""

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.laser_view import View
from pilotage.core.odometry_watch import OdometrySample
from pilotage.planner.knowledge import Estimate, Knowledge, PastBelief
from pilotage.planner.situation import Hypotheses, State

SEEN = View(np.array([[1.0, 0.0]]), np.linspace(-2.0, 2.0, 61))
TWO = Hypotheses(np.array([[1.0, 1.0, 0.0], [5.0, 5.0, np.pi / 2.0]]), np.array([0.6, 0.4]))
MAP = "0123"
SECOND = 1_000_000_000


class Robot:
    """A robot that drives straight on at 0.5 m/s, and is heard of ten times a second."""

    def __init__(self, state: State = "ambiguous") -> None:
        self.knowledge = Knowledge()
        self.state, self.seq, self.now = state, 0, 100.0
        self.odom = np.array([3.0, -1.0, 0.5])
        self.deaf_to: set[str] = set()

    @property
    def stamp_ns(self) -> int:
        return round(self.now * SECOND)

    def go(self, seconds: float) -> None:
        for _ in range(round(10.0 * seconds)):
            self.now, self.seq = self.now + 0.1, self.seq + 1
            self.odom = se2.compose(self.odom, [0.05, 0.0, 0.0])
            self.hear("odometry")
            self.hear("view")
            self.hear("pose")

    def hear(self, what: str) -> None:
        if what in self.deaf_to:
            return
        if what == "odometry":
            sample = OdometrySample(self.seq, self.stamp_ns, self.odom)
            self.knowledge.hear_odometry(sample, self.now)
        elif what == "view":
            self.knowledge.hear_view(SEEN, self.now)
        else:
            pose = np.array([1.0, 1.0, 0.0])
            self.knowledge.hear_estimate(Estimate(self.stamp_ns, pose, self.state), self.now)

    def believe(self, hypotheses: Hypotheses = TWO, map_id: str = MAP) -> None:
        self.knowledge.hear_belief(PastBelief(self.stamp_ns, map_id, hypotheses))


def test_every_place_of_a_belief_is_moved_on_as_the_odometry_says() -> None:
    robot = Robot()
    robot.go(1.0)
    robot.believe()
    robot.go(2.0)
    situation = robot.knowledge.situation(robot.now, MAP)
    assert situation is not None
    assert situation.belief.poses[0] == pytest.approx([2.0, 1.0, 0.0])
    assert situation.belief.poses[1] == pytest.approx([5.0, 6.0, np.pi / 2.0])
    assert situation.belief.weights.tolist() == [0.6, 0.4]
    assert situation.odom_from_base == pytest.approx(robot.odom)
    assert situation.state == "ambiguous"


def test_a_localized_robot_is_where_the_localizers_refined_pose_is() -> None:
    robot = Robot("localized")
    robot.go(1.0)
    robot.believe()
    robot.deaf_to = {"pose"}
    robot.go(1.0)
    situation = robot.knowledge.situation(robot.now, MAP)
    assert situation is not None
    assert situation.belief.poses == pytest.approx(np.array([[1.5, 1.0, 0.0]]))
    assert situation.belief.weights.tolist() == [1.0]


@pytest.mark.parametrize(
    ("deaf_to", "words"), [("odometry", "odometry"), ("view", "scan"), ("pose", "pose")]
)
def test_silence_is_noticed_and_named(deaf_to: str, words: str) -> None:
    robot = Robot()
    robot.deaf_to = {deaf_to}
    robot.go(1.0)
    robot.believe()
    assert robot.knowledge.missing(robot.now, MAP) == f"no {words} has come yet"
    robot.deaf_to = set()
    robot.go(1.0)
    robot.believe()
    assert robot.knowledge.missing(robot.now, MAP) is None
    robot.deaf_to = {deaf_to}
    robot.go(2.0)
    assert robot.knowledge.missing(robot.now, MAP) == f"no {words} for 2 s"
    assert robot.knowledge.situation(robot.now, MAP) is None


def test_a_belief_about_another_map_is_of_no_use() -> None:
    robot = Robot()
    robot.go(1.0)
    robot.believe(map_id="another")
    assert robot.knowledge.missing(robot.now, MAP) == "the localizer is not on this map"
    robot.believe()
    assert robot.knowledge.missing(robot.now, MAP) is None


def test_the_place_is_forgotten_with_the_map() -> None:
    robot = Robot()
    robot.go(1.0)
    robot.believe()
    robot.knowledge.forget_place()
    assert robot.knowledge.situation(robot.now, MAP) is None
    assert robot.knowledge.state == "unknown"


def test_odometry_that_is_counted_anew_tells_nothing_of_an_older_belief() -> None:
    robot = Robot()
    robot.go(1.0)
    robot.believe()
    robot.odom, robot.seq = np.zeros(3), 0
    robot.deaf_to = {"pose"}
    robot.go(0.2)
    assert robot.knowledge.situation(robot.now, MAP) is None
    robot.deaf_to = set()
    robot.believe()
    robot.go(0.2)
    assert robot.knowledge.situation(robot.now, MAP) is not None
