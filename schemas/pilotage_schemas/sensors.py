"""What a robot measures, and how it is built."""

from typing import Annotated, Literal

from pydantic import Field

from pilotage_schemas.arrays import Float32Array, Float64Array, Nd
from pilotage_schemas.geometry import Heading as Direction
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.mapping import Count
from pilotage_schemas.message import (
    Finite,
    Fraction,
    Message,
    Name,
    NonNegative,
    Part,
    Positive,
    Text,
)


class Odometry(Message):
    """Dead reckoning: `pose` of base_link in `odom`, drifting but never jumping."""

    pose: Pose2
    twist: Twist2
    covariance: Annotated[Float64Array, Nd("float64", "3,3")]


class LaserScan(Message):
    """Ranges at equal steps of angle, counter-clockwise, in the sensor's frame.

    Infinite means that nothing was met within `range_max`. The sensor's place on the robot is
    the mount of its `frame_id` in RobotDescription.
    """

    angle_min: Finite
    angle_increment: Finite
    range_min: NonNegative
    range_max: Positive
    ranges: Annotated[Float32Array, Nd("float32", "n", finite=False)]


class SonarScan(Message):
    """One round of single-cone rangers (sonar, time of flight), each at its own mount.

    `mounts` holds x, y and direction of each in base_link; infinite means no echo.
    """

    mounts: Annotated[Float32Array, Nd("float32", "n,3")]
    ranges: Annotated[Float32Array, Nd("float32", "n", finite=False)]
    cone: Annotated[float, Field(gt=0.0, le=3.2, description="full opening angle, rad")]
    range_min: NonNegative
    range_max: Positive


class Heading(Message):
    """A compass: direction of the robot's x axis in `map`, with its standard deviation."""

    yaw: Direction
    sigma: Positive


class Landmark(Part):
    """One recognised landmark; `identity` only where the camera can tell it from its likes."""

    kind: Name
    range: NonNegative
    bearing: Direction
    range_sigma: Positive
    bearing_sigma: Positive
    identity: Name | None = None


class LandmarkSightings(Message):
    """The landmarks recognised in one picture; empty when it shows none."""

    sightings: Annotated[tuple[Landmark, ...], Field(max_length=1000, strict=False)]


class VerticalEdges(Message):
    """Bearings of the vertical edges in a camera's picture, in the camera's frame."""

    bearings: Annotated[Float32Array, Nd("float32", "n")]
    sigma: Positive


class Bumper(Message):
    """The bumper's state; `bearing` of the contact in base_link where the robot knows it."""

    pressed: bool
    bearing: Direction | None = None


class SensorMount(Part):
    """Where a sensor sits: `pose` of frame `frame_id` in base_link."""

    frame_id: Name
    kind: Literal["laser", "sonar", "compass", "camera", "bumper"]
    pose: Pose2


class RobotDescription(Message):
    """How the robot is built and what it may do."""

    name: Name
    driver: Name
    footprint: Annotated[Float32Array, Nd("float32", "n,2")]
    mounts: Annotated[tuple[SensorMount, ...], Field(max_length=64, strict=False)]
    max_linear: Annotated[NonNegative, Field(description="m/s")]
    max_angular: Annotated[NonNegative, Field(description="rad/s")]
    commands: Annotated[tuple[Name, ...], Field(max_length=64, strict=False)]
    """Names of the commands this robot can carry out; a replayed log can carry out none."""


class RobotStatus(Message):
    """What the robot does and why; `progress` of a replayed log.

    `orders` counts what people told the robot to do since it started: to stop, to move, to wander.
    `is_held`: the last such order was to stop or to move, and no program that was started since
    drives: one that drives of its own accord waits for a person's word.
    """

    source: Literal["live", "simulation", "replay"]
    mode: Literal["wandering", "commanded", "stopped", "replaying", "finished"]
    reason: Text
    speed_factor: Positive = 1.0
    progress: Fraction | None = None
    orders: Count = 0
    is_held: bool = False


class GroundTruth(Message):
    """Where the simulated robot really is, in `map`; no service that estimates may listen."""

    pose: Pose2
    twist: Twist2
