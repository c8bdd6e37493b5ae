"""Where the robot shall go and how it gets there."""

from typing import Annotated

from pydantic import Field

from pilotage_schemas.arrays import Float32Array, Nd
from pilotage_schemas.geometry import Heading, Pose2, Twist2
from pilotage_schemas.mapping import Resolution
from pilotage_schemas.message import Finite, Message, Part, Positive, Text


class VelocityCommand(Message):
    """The wanted twist; the robot stops by itself when none has come for 0.5 s."""

    twist: Twist2


class GazeCommand(Message):
    """The wanted pan of the camera, relative to the robot's x axis."""

    pan: Heading


class Goal(Message):
    """The pose to reach, and how exactly."""

    pose: Pose2
    position_tolerance: Positive = 0.10
    heading_tolerance: Positive = 0.0873


class Path(Message):
    """The way to the goal: poses (n, 3) in order."""

    poses: Annotated[Float32Array, Nd("float32", "n,3")]


class PotentialField(Message):
    """The environment potential per cell; `origin` as in OccupancyGrid."""

    resolution: Resolution
    origin: Pose2
    potential: Annotated[Float32Array, Nd("float32", "rows,cols")]


class Candidate(Part):
    """A place from which the robot might look: expected gain in bits, cost in metres."""

    pose: Pose2
    expected_gain: Finite
    travel: Finite


class ActivePlan(Message):
    """The next look: candidates by falling value; the first is chosen, for this reason."""

    candidates: Annotated[tuple[Candidate, ...], Field(max_length=200, strict=False)]
    reason: Text
