"""Maps and their changes."""

from typing import Annotated

from pydantic import AfterValidator, Field

from pilotage_schemas.arrays import Int8Array, Nd
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Message, Name

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

    `origin` is the pose of the outer corner of cell (0, 0); `map_id` names the content.
    """

    map_id: Name
    name: Name
    resolution: Resolution
    origin: Origin
    cells: Cells


class GridPatch(Message):
    """Cells of map `map_id` that changed, to be laid at (`row`, `col`)."""

    map_id: Name
    row: Index
    col: Index
    cells: Cells
