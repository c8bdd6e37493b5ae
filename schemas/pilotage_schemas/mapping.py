"""Maps and their changes."""

from typing import Annotated

from pydantic import Field

from pilotage_schemas.arrays import Int8Array, Nd
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.message import Message, Name

Cells = Annotated[Int8Array, Nd("int8", "rows,cols")]
Resolution = Annotated[float, Field(ge=0.001, le=10.0, description="m per cell")]
Index = Annotated[int, Field(ge=0, lt=2**31)]


class OccupancyGrid(Message):
    """A whole map: cells -1 unknown, 0 free to 100 occupied; row 0 at the bottom.

    `origin` is the pose of the outer corner of cell (0, 0); `map_id` names the content.
    """

    map_id: Name
    name: Name
    resolution: Resolution
    origin: Pose2
    cells: Cells


class GridPatch(Message):
    """Cells of map `map_id` that changed, to be laid at (`row`, `col`)."""

    map_id: Name
    row: Index
    col: Index
    cells: Cells
