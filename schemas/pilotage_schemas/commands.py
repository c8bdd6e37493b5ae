"""Requests and replies: whatever must answer "did it work?"."""

from typing import Annotated, Literal

from pydantic import Field

from pilotage_schemas.arrays import Float64Array, Int8Array, Nd
from pilotage_schemas.geometry import Heading, Pose2, Twist2
from pilotage_schemas.mapping import Count, MappingSensor, Resolution, Stamp
from pilotage_schemas.message import Name, NonNegative, Part, Positive, Text

FileContent = Annotated[Int8Array, Nd("int8", "n")]
"""The bytes of a file."""


class NamedFile(Part):
    """A file by its name within a map."""

    name: Name
    content: FileContent


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


class MapStart(Part):
    """Make a map: a new one, or go on with the present one, if it was made here."""

    sensor: MappingSensor = "laser"
    go_on: bool = False


class MapSave(Part):
    """Keep the present map, made or in the making, under this name in the mapper's library."""

    name: Name


class MapSaved(Part):
    """The map as it was kept, and where."""

    name: Name
    map_id: Name
    path: Text


class MapLoad(Part):
    """Use another map: one of the library by its name, or a file of the mapper's machine."""

    map: Annotated[str, Field(max_length=4096)]


class MapDelete(Part):
    """Delete a map of the library."""

    name: Name


class MapFetch(Part):
    """Ask for one file of a map of the library."""

    name: Name
    file: Name


class MapFile(Part):
    """A file of a map, byte for byte."""

    content: FileContent


class MapStore(Part):
    """Take a map into the library: map.yaml and its image, and whatever else belongs to it."""

    name: Name
    files: Annotated[tuple[NamedFile, ...], Field(max_length=16, strict=False)]


class StoredMap(Part):
    """One map of the library; `can_go_on`: mapping can go on from where it ended."""

    name: Name
    map_id: Name
    rows: Count
    cols: Count
    resolution: Resolution
    saved_ns: Stamp
    files: Annotated[tuple[Name, ...], Field(max_length=64, strict=False)]
    can_go_on: bool


class MapList(Part):
    """The maps of the library by name."""

    maps: Annotated[tuple[StoredMap, ...], Field(max_length=10_000, strict=False)]


class GoTo(Part):
    """Drive to `pose` in the map, within these tolerances [m, rad]; refused if no way leads there.

    Where the pose is in doubt, or becomes so on the way, the robot finds out first where it is.
    """

    pose: Pose2
    position_tolerance: Annotated[Positive, Field(ge=0.02, le=10.0)] = 0.10
    heading_tolerance: Annotated[Positive, Field(ge=0.01, le=3.1416)] = 0.0873


class LocalizeActively(Part):
    """Drive so as to find out where the robot is: now, or (`always`) whenever that is in doubt."""

    always: bool = False


class Look(Part):
    """Point the camera: `pan` [rad] relative to the robot's x axis."""

    pan: Heading


class Restart(Part):
    """Restart one process of the deployment."""

    service: Name
