"""Where the robot shall go and how it gets there."""

from typing import Annotated, Literal

from pydantic import Field

from pilotage_schemas.arrays import Float32Array, Nd
from pilotage_schemas.geometry import Heading, Pose2, Twist2
from pilotage_schemas.mapping import Count, Resolution
from pilotage_schemas.message import Finite, Message, NonNegative, Part, Positive, Text


class VelocityCommand(Message):
    """The wanted twist; the robot stops by itself when none has come for 0.5 s.

    `orders`: how many orders of people (RobotStatus) the sender knows of. A robot that has had
    others since does not obey: nobody's Stop is undone by what was on its way. None: not said.
    `then`: more such commands follow, or this was the last one, and the robot stands, or goes on
    with what it did before the first.
    """

    twist: Twist2
    orders: Count | None = None
    then: Literal["more", "stand", "resume"] = "more"


class GazeCommand(Message):
    """The wanted pan of the camera, relative to the robot's x axis."""

    pan: Heading


class Goal(Message):
    """The pose to reach, and how exactly."""

    pose: Pose2
    position_tolerance: Positive = 0.10
    heading_tolerance: Positive = 0.0873


class Path(Message):
    """The way to the goal or to the next look: poses (n, 3) in order; none: there is no way now.

    While the pose is in doubt it is drawn as if the robot were at the belief's best place.
    """

    poses: Annotated[Float32Array, Nd("float32", "n,3")]


class PotentialField(Message):
    """The environment potential per cell; `origin` as in OccupancyGrid."""

    resolution: Resolution
    origin: Pose2
    potential: Annotated[Float32Array, Nd("float32", "rows,cols")]


class Candidate(Part):
    """A place from which the robot might look: expected gain in bits, cost in metres.

    `kind`: what speaks for it: the map around it, the potential of landmarks, nothing (drawn by
    chance), or that the robot is there already.
    """

    pose: Pose2
    expected_gain: Finite
    travel: Finite
    kind: Literal["map", "potential", "random", "here"] = "map"


class ActivePlan(Message):
    """The next look: candidates by falling value; the first is chosen, for this reason.

    Poses are drawn as if the robot were at the belief's best place; `look` is where the camera
    shall look from the first one, relative to the robot's x axis. No candidates: no plan now.
    """

    candidates: Annotated[tuple[Candidate, ...], Field(max_length=200, strict=False)]
    reason: Text
    look: Heading | None = None


class PlanningStatus(Message):
    """What the planner does and why, in words.

    `localizing` with a goal: it finds out where it is and then goes on to the goal. `waiting`: it
    has something to do and cannot at present. While idle, `outcome` says how the last task ended.
    `always_localizes`: it resolves every doubt of the pose by itself. `distance_left` [m] along
    the path; `decision_ms`: time that the last decision where to look took.
    """

    mode: Literal["idle", "going", "localizing", "waiting"]
    always_localizes: bool
    reason: Text
    outcome: Literal["none", "done", "cancelled", "interrupted", "failed"] = "none"
    goal: Pose2 | None = None
    distance_left: NonNegative | None = None
    decision_ms: NonNegative | None = None
