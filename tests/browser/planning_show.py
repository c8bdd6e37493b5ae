"""A scripted planner beside the scripted robot: it looks, goes, waits and refuses as it is told."""

from dataclasses import dataclass, replace

import numpy as np

from browser.live_gateway import LiveGateway
from browser.show import HEIGHT, WIDTH, Script, Show, heartbeat
from pilotage.bus.fabric import RefusedError
from pilotage_schemas.commands import Done, GoTo, LocalizeActively, Nothing
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Part
from pilotage_schemas.planning import (
    ActivePlan,
    Candidate,
    Goal,
    Path,
    PlanningStatus,
    PotentialField,
)

ROBOT = (15.5, 6.5, 0.0)
FIRST = Script(pose=ROBOT, planner="ready")
LOOKS = (
    (1.3, 4.2, 19.5, 6.4),
    (0.9, 2.9, 12.5, 6.4),
    (0.4, 6.0, 21.5, 2.5),
    (0.2, 7.5, 9.0, 10.5),
)
"""Expected gain, travel, x and y of each candidate, the best first."""

WAY = ((15.5, 6.5), (17.0, 7.0), (19.0, 6.6), (21.0, 6.5), (21.5, 4.5), (22.0, 2.5))
LANDMARKS = ((2.0, 2.0), (24.0, 2.0), (24.0, 11.0), (13.0, 6.5))
GOAL = Pose2(x=22.0, y=2.5, theta=-1.57)


@dataclass(frozen=True)
class Task:
    """What the planner tells of itself; replaced by the test as it goes."""

    mode: str = "idle"
    outcome: str = "none"
    reason: str = "nothing to do"
    why: str = "would tell place 1 from place 2"
    always: bool = False
    goal: Pose2 | None = None
    heading_tolerance: float = 0.0873
    looks: tuple[tuple[float, float, float, float], ...] = ()
    kind: str = "map"
    way: tuple[tuple[float, float], ...] = ()
    distance_left: float | None = None
    is_silent: bool = False


LOOKING = Task(mode="localizing", reason="finding out where it is", looks=LOOKS)
GOING = Task(mode="going", reason="going to (22.00, 2.50)", goal=GOAL, way=WAY, distance_left=9.26)


class PlanningShow(Show):
    """Publishes what its `task` says, and does what it is asked."""

    def __init__(self, gateway: LiveGateway, cell: float = 0.1) -> None:
        super().__init__(gateway, FIRST)
        self.task = Task()
        self.cell = cell
        self._was: Task | None = None
        for name in ("go_to", "localize_actively", "cancel"):
            gateway.answer("planner", name, getattr(self, name))

    def plan(self, **changes: object) -> None:
        """Let the planner go on differently."""
        self.task = replace(self.task, **changes)  # type: ignore[arg-type]  # names are the fields

    def begin_anew(self) -> None:
        """Be as at first, nothing asked yet."""
        self.asked.clear()
        self.refusal = ""
        self.script, self.task = FIRST, Task()

    def go_to(self, request: GoTo) -> Done:
        self._note("go_to", request)
        self.task = replace(GOING, goal=request.pose, heading_tolerance=request.heading_tolerance)
        return Done()

    def localize_actively(self, request: LocalizeActively) -> Done:
        self._note("localize_actively", request)
        self.task = replace(LOOKING, always=request.always)
        return Done()

    def cancel(self, request: Nothing) -> Done:
        self._note("cancel", request)
        self.task = Task(outcome="cancelled", reason="cancelled by a person")
        return Done()

    def tick(self) -> None:
        """Publish one round; the planner's status twice a second and whenever it changes."""
        task, now = self.task, self.gateway.clock.now_ns()
        is_round = self._ticks % 5 == 0
        if self._was is None:
            self._tell("planner", "potential", landmark_field(now, self.cell))
        super().tick()
        if task.is_silent:
            return
        if is_round:
            self._tell("planner", "heartbeat", heartbeat(now, "planner"))
        if task != self._was:
            self._tell("planner", "plan", plan(now, task))
            self._tell("planner", "path", path(now, task))
            if task.goal is not None:
                self._tell("planner", "goal", goal(now, task, task.goal))
        if is_round or task != self._was:
            self._tell("planner", "planning_status", planning_status(now, task))
        self._was = task

    def _note(self, name: str, request: Part) -> None:
        self.asked.append((name, request))
        if self.refusal:
            raise RefusedError(self.refusal)


def landmark_field(now: int, cell: float) -> PotentialField:
    """Return the potential of a few landmarks all over the building."""
    rows, cols = round(HEIGHT / cell), round(WIDTH / cell)
    y, x = (np.indices((rows, cols)) + 0.5) * cell
    total = sum(1.0 / (1.0 + np.exp((np.hypot(x - u, y - v) - 3.0) / 1.2)) for u, v in LANDMARKS)
    return PotentialField(
        stamp_ns=now,
        frame_id="map",
        resolution=cell,
        origin=Pose2(x=0.0, y=0.0, theta=0.0),
        potential=np.asarray(total, np.float32),
    )


def plan(now: int, task: Task) -> ActivePlan:
    """Return the candidates of a task."""
    candidates = tuple(
        Candidate.model_validate(
            {
                "pose": Pose2(x=x, y=y, theta=0.0),
                "expected_gain": gain,
                "travel": travel,
                "kind": task.kind,
            }
        )
        for gain, travel, x, y in task.looks
    )
    return ActivePlan(stamp_ns=now, frame_id="map", candidates=candidates, reason=task.why)


def path(now: int, task: Task) -> Path:
    """Return the way of a task."""
    poses = np.array([[x, y, 0.0] for x, y in task.way], np.float32).reshape(-1, 3)
    return Path(stamp_ns=now, frame_id="map", poses=poses)


def goal(now: int, task: Task, pose: Pose2) -> Goal:
    """Return the goal of a task."""
    tolerance = task.heading_tolerance
    return Goal(stamp_ns=now, frame_id="map", pose=pose, heading_tolerance=tolerance)


def planning_status(now: int, task: Task) -> PlanningStatus:
    """Return what the planner says of itself."""
    return PlanningStatus.model_validate(
        {
            "stamp_ns": now,
            "frame_id": "map",
            "mode": task.mode,
            "always_localizes": task.always,
            "reason": task.reason,
            "outcome": task.outcome,
            "goal": task.goal,
            "distance_left": task.distance_left,
        }
    )
