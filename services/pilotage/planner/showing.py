"""What the planner says: velocities, and what it plans for whoever watches."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.bus.node import Node
from pilotage.core import se2
from pilotage.planner import messages
from pilotage.planner.active_localization import Decision
from pilotage.planner.mission import Ending, Mission, Target
from pilotage.planner.sight import Potential
from pilotage.planner.situation import Speeds
from pilotage_schemas.planning import PlanningStatus
from pilotage_schemas.topics import TOPICS

FAREWELLS = 3
"""How often the last velocity is sent: it travels by a topic that may drop."""


@dataclass
class _Shown:
    """What those who watch have seen last."""

    status: tuple[object, ...] = ()
    decision: Decision | None = None
    path: NDArray[np.float64] | None = None


class Showing:
    """Publishes each thing when it is new."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._out = {
            t.name: node.publisher(t.name) for t in TOPICS.values() if t.owner == "planner"
        }
        self._shown = _Shown()
        self._farewell: tuple[Ending, int] = ("stand", 0)
        self.decision_ms: float | None = None

    def drive(self, speeds: Speeds, orders: int) -> None:
        """Let the robot drive, by the orders of people known so far."""
        self._farewell = ("stand", 0)
        self._send(speeds, orders, "more")

    def let_go(self, ending: Ending) -> None:
        """Let the robot stand, or go on with what it did before, from the next step on."""
        self._farewell = (ending, FAREWELLS)

    def say_farewell(self, orders: int) -> None:
        """Say that nothing more will come, if that has not been said often enough."""
        ending, left = self._farewell
        if left > 0:
            self._farewell = (ending, left - 1)
            self._send((0.0, 0.0), orders, ending)

    def status(self, mission: Mission) -> PlanningStatus:
        """Return what the mission is about."""
        goal = mission.target
        return PlanningStatus(
            stamp_ns=self._node.clock.now_ns(),
            frame_id="map",
            mode=mission.mode,
            always_localizes=mission.always,
            reason=mission.reason[:2000],
            outcome=mission.outcome,
            goal=None if goal is None else messages.pose_of(goal.pose),
            distance_left=None if mission.way is None else max(0.0, mission.way.distance_left),
            decision_ms=self.decision_ms,
        )

    def say(self, mission: Mission) -> None:
        """Say what the mission is about."""
        self._shown.status = _account(mission)
        self._out["planning_status"].publish(self.status(mission))

    def is_news(self, mission: Mission) -> bool:
        """Say whether the mission has changed since it was last told."""
        return self._shown.status != _account(mission)

    def look(self, pan: float) -> None:
        """Point the camera [rad]."""
        self._out["gaze_command"].publish(messages.gaze_message(pan, self._node.clock.now_ns()))

    def show_goal(self, target: Target) -> None:
        """Show where the robot goes."""
        self._out["goal"].publish(messages.goal_message(target, self._node.clock.now_ns()))

    def show_potential(self, potential: Potential) -> None:
        """Show how much each place of the map tells."""
        stamp_ns = self._node.clock.now_ns()
        self._out["potential"].publish(messages.potential_message(potential, stamp_ns))

    def show_decision(self, decision: Decision, places: NDArray[np.float64]) -> bool:
        """Show where to look from next, if that is new; `places` (n, 2): the belief's."""
        if decision is self._shown.decision:
            return False
        self._shown.decision = decision
        stamp_ns = self._node.clock.now_ns()
        self._out["plan"].publish(messages.plan_message(decision, places, stamp_ns))
        self._publish_path(se2.transform_points(decision.places.best, decision.path))
        return True

    def show_path(self, points_map: NDArray[np.float64]) -> None:
        """Show what is left of a way (n, 2) to the goal, whenever a corner of it is passed."""
        shown = self._shown.path
        if shown is None or not np.array_equal(points_map[1:], shown[1:]):
            self._publish_path(points_map)

    def show_no_search(self) -> None:
        """Show that nothing is looked for."""
        if self._shown.decision is not None:
            self._shown.decision = None
            self._out["plan"].publish(messages.no_plan(self._node.clock.now_ns()))

    def show_no_path(self) -> None:
        """Show that there is no way."""
        if self._shown.path is not None:
            self._publish_path(np.zeros((0, 2)))
            self._shown.path = None

    def _publish_path(self, points_map: NDArray[np.float64]) -> None:
        self._shown.path = np.array(points_map)
        self._out["path"].publish(messages.path_message(points_map, self._node.clock.now_ns()))

    def _send(self, speeds: Speeds, orders: int, then: str) -> None:
        stamp_ns = self._node.clock.now_ns()
        command = messages.velocity_message(speeds, stamp_ns, orders, then)
        self._out["velocity_command"].publish(command)


def _account(mission: Mission) -> tuple[object, ...]:
    target = "" if mission.target is None else str(mission.target)
    return mission.mode, mission.reason, mission.outcome, mission.always, target
