"""Requests and replies: whatever must answer "did it work?"."""

from typing import Annotated, Literal

from pydantic import Field

from pilotage_schemas.arrays import Float64Array, Nd
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.message import Name, NonNegative, Part, Positive, Text


class Done(Part):
    """The command was carried out (or accepted, for motions that take time)."""

    detail: Text = ""


class Refused(Part):
    """The command was not carried out, and why."""

    reason: Text


class Nothing(Part):
    """A request without arguments."""


class Drive(Part):
    """Go `distance` metres (forward or backward by the command's name) at `speed` m/s."""

    distance: Annotated[Positive, Field(le=100.0)]
    speed: Annotated[Positive, Field(le=10.0)] = 0.3


class Turn(Part):
    """Turn on the spot by `angle` rad (counter-clockwise positive) at `rate` rad/s."""

    angle: Annotated[float, Field(ge=-100.0, le=100.0, allow_inf_nan=False)]
    rate: Annotated[Positive, Field(le=20.0)] = 0.6


class Velocity(Part):
    """Drive with this twist until 0.5 s after the last such command."""

    twist: Twist2


class Stopped(Part):
    """The robot stands; `after` seconds from the request's arrival at the robot."""

    after: NonNegative


class Wander(Part):
    """Let the robot wander by itself, or stop doing so."""

    enabled: bool


class Kidnap(Part):
    """Carry the simulated robot to `pose`, or to a random free place."""

    pose: Pose2 | None = None


class Kidnapped(Part):
    """Where the simulated robot was put."""

    pose: Pose2


class SetPose(Part):
    """Begin anew from this pose; without a covariance 0.5 m and 15 degrees are assumed."""

    pose: Pose2
    covariance: Annotated[Float64Array, Nd("float64", "3,3")] | None = None


class SetAlgorithm(Part):
    """Choose the paper's update: M1 (classic) or M2 (with the prior floor)."""

    algorithm: Literal["m1", "m2"]
    recovery_weight: NonNegative = 1.0


class SetMethod(Part):
    """Choose how to localize; what is known of the pose is carried over."""

    method: Literal["markov", "mcl", "ekf"]


class SetMap(Part):
    """Localize on another map than the mapper's, or on the mapper's again.

    `map` is the path of a file on the localizer's machine, or the id of the mapper's map.
    """

    map: Annotated[str, Field(max_length=4096)]


class LoadMap(Part):
    """Load the map file of this path on the mapper's machine and publish it."""

    path: Annotated[str, Field(max_length=4096)]


class MapLoaded(Part):
    """The map that is now in use."""

    map_id: Name
    rows: Annotated[int, Field(gt=0, lt=2**31)]
    cols: Annotated[int, Field(gt=0, lt=2**31)]


class Restart(Part):
    """Restart one process of the deployment."""

    service: Name
