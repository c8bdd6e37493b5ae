"""Maps and their changes."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from pilotage_schemas.arrays import Float32Array, Float64Array, Int8Array, Nd
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Message, Name, Part

Cells = Annotated[Int8Array, Nd("int8", "rows,cols")]
Resolution = Annotated[float, Field(ge=0.001, le=10.0, description="m per cell")]
FARTHEST = 1e8
"""No map lies farther from its frame's origin [m]: twice around the earth."""


def _on_earth(origin: Pose2) -> Pose2:
    if max(abs(origin.x), abs(origin.y)) > FARTHEST:
        raise ValueError(f"a map cannot lie {FARTHEST:g} m away")
    return origin


Origin = Annotated[Pose2, AfterValidator(_on_earth)]
Index = Annotated[int, Field(ge=0, lt=2**31)]


class OccupancyGrid(Message):
    """A whole map: cells -1 unknown, 0 free to 100 occupied; row 0 at the bottom.

    `origin` is the pose of the outer corner of cell (0, 0); `map_id` names the content. A map
    `in_progress` is being made: its id holds until it is sent whole again, and until then it
    changes by the patches of that id. Nobody localizes on it.
    """

    map_id: Name
    name: Name
    resolution: Resolution
    origin: Origin
    cells: Cells
    in_progress: bool = False


class GridPatch(Message):
    """Cells of map `map_id` that changed, to be laid at (`row`, `col`)."""

    map_id: Name
    row: Index
    col: Index
    cells: Cells


Count = Annotated[int, Field(ge=0, lt=2**63)]
Stamp = Annotated[int, Field(ge=0, lt=2**63, description="Unix time, ns")]
MappingSensor = Literal["laser", "sonar"]


class Handover(Part):
    """What the localizer begins with when a map is finished: the mapper's last word.

    `pose` of base_link in the finished map `map_id` at the moment when odometry said
    `odom_from_base`; the covariance is over x, y, theta of the map frame.
    """

    map_id: Name
    pose: Pose2
    covariance: Annotated[Float64Array, Nd("float64", "3,3")]
    odom_from_base: Pose2
    stamp_ns: Stamp


class MappingStatus(Message):
    """Who publishes `pose`: the mapper while `mapping` or `handing_over`, else the localizer.

    While `handing_over` the localizer makes itself ready on the finished map, beginning with
    `handover`; its first `belief` on that map ends it. `steps` counts the measurements that
    went into the map since `since_ns`, `redraws` how often it was drawn anew after a loop.
    """

    mode: Literal["idle", "mapping", "handing_over"]
    sensor: MappingSensor | None = None
    map_id: Name = ""
    since_ns: Stamp = 0
    steps: Count = 0
    redraws: Count = 0
    handover: Handover | None = None


class MappedPath(Message):
    """The way that the map was made from: poses (n, 3) in order, thinned, all of them corrected.

    `ages` (n,) s: how long before `stamp_ns` the robot was there.
    """

    map_id: Name
    poses: Annotated[Float32Array, Nd("float32", "n,3")]
    ages: Annotated[Float32Array, Nd("float32", "n")]
