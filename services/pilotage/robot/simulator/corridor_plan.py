"""A corridor of 36 m with alike doors on both sides, a corner, and a hall at its end; pure.

After the corridor of Zhuang et al. 2005, figures 1 and 4: doors that cannot be told apart, a few
passages, one corner. x runs along the corridor, (0, 0) is the lower left inner corner of the
south rooms. The map shows the floor with all doors open; which are closed is said by
`corridor_doors`.
"""

import itertools
from dataclasses import dataclass

from pilotage.core.grid import OccupancyMap
from pilotage.robot.simulator import furniture
from pilotage.robot.simulator.floor_canvas import Box, FloorCanvas, Room

WIDTH, HEIGHT, CELL = 42.0, 23.0, 0.05
WALL = 0.20
CORRIDOR: Box = (0.0, 4.7, 36.0, 7.1)
SIDE_CORRIDOR: Box = (33.6, 7.1, 36.0, 14.0)
HALL: Box = (28.0, 14.2, 42.0, 23.0)
SOUTH_EDGES = (0.0, 4.0, 8.0, 12.0, 16.0, 20.0, 24.0, 28.0, 32.0, 36.0)
NORTH_EDGES = (0.0, 4.0, 8.0, 12.0, 16.0, 20.0, 24.0, 28.0, 33.4)
STAIRS = 3
"""Which of the north rooms is the stairwell, open to the corridor."""
DOOR_WIDTH, DOUBLE_WIDTH, STAIRS_WIDTH = 0.9, 1.8, 2.4
DOOR_AT = 1.2
"""From the left wall of a room to its door, m."""
RECESS, FLUSH = 0.10, 0.0
"""From the corridor's face of a wall to that of a closed leaf, m."""

Entry = dict[str, object]
"""A door as it stands in a world file."""

STATES = {
    "south": ("closed", "open", "closed", "closed", "ajar", "closed", "closed", "open", "closed"),
    "north": ("open", "closed", "closed", "none", "closed", "closed", "ajar", "closed"),
}
FLUSH_DOORS = {("south", 3), ("north", 5)}


@dataclass(frozen=True)
class Doorway:
    """An opening along x between `x0` and `x1` m in the wall from `y0` to `y1` m."""

    x0: float
    x1: float
    y0: float
    y1: float

    @property
    def box(self) -> Box:
        """What is cut out of the wall."""
        return self.x0, self.y0, self.x1, self.y1


def corridor_floor() -> OccupancyMap:
    """Return the floor: 0.05 m cells, unknown outside."""
    canvas = FloorCanvas(WIDTH, HEIGHT, CELL, margin=0.5)
    rooms = [*_rooms("south"), *_rooms("north")]
    for box in (CORRIDOR, SIDE_CORRIDOR, HALL, *(room.box for room in rooms)):
        x0, y0, x1, y1 = box
        canvas.solid((x0 - WALL, y0 - WALL, x1 + WALL, y1 + WALL))
    for box in (CORRIDOR, SIDE_CORRIDOR, HALL, *(room.box for room in rooms)):
        canvas.floor(box)
    canvas.floor((33.6, 14.0, 36.0, 14.2))
    for side in ("south", "north"):
        for doorway in _doorways(side):
            canvas.floor(doorway.box)
    _furnish(canvas, rooms)
    return canvas.to_map()


def corridor_doors() -> list[Entry]:
    """Return the doors between corridor and rooms, as they stand in a file."""
    return [
        _entry(doorway, side, (STATES[side][number], (side, number) in FLUSH_DOORS))
        for side in ("south", "north")
        for number, doorway in enumerate(_doorways(side))
        if STATES[side][number] != "none"
    ]


def _rooms(side: str) -> list[Room]:
    edges = SOUTH_EDGES if side == "south" else NORTH_EDGES
    y0, y1 = (0.0, CORRIDOR[1] - WALL) if side == "south" else (CORRIDOR[3] + WALL, 11.8)
    half = WALL / 2.0
    return [
        Room((x0 + half, y0, x1 - half, y1), "N" if side == "south" else "S")
        for x0, x1 in itertools.pairwise(edges)
    ]


def _doorways(side: str) -> list[Doorway]:
    face = CORRIDOR[1] - WALL if side == "south" else CORRIDOR[3]
    ways = []
    for number, room in enumerate(_rooms(side)):
        x0 = room.box[0] + DOOR_AT
        is_stairs = side == "north" and number == STAIRS
        is_double = side == "north" and number == len(NORTH_EDGES) - 2
        width = STAIRS_WIDTH if is_stairs else DOUBLE_WIDTH if is_double else DOOR_WIDTH
        ways.append(Doorway(round(x0, 3), round(x0 + width, 3), face, face + WALL))
    return ways


def _entry(doorway: Doorway, side: str, state_flush: tuple[str, bool]) -> Entry:
    """Return a door whose leaf stands behind the corridor's face of the wall and opens inwards."""
    state, is_flush = state_flush
    behind = (FLUSH if is_flush else RECESS) + CELL / 2.0
    y = doorway.y0 + behind if side == "north" else doorway.y1 - behind
    left, right = [doorway.x0, round(y, 3)], [doorway.x1, round(y, 3)]
    return {"ends": [left, right] if side == "north" else [right, left], "state": state}


def _furnish(canvas: FloorCanvas, rooms: list[Room]) -> None:
    """Alike offices; columns and benches in the hall, a plant in the corner."""
    stairs = len(SOUTH_EDGES) - 1 + STAIRS
    for number, room in enumerate(rooms):
        if number != stairs:
            furniture.single_office(canvas, room)
    for x in (31.0, 38.5):
        for y in (17.0, 20.5):
            canvas.round(x, y, 0.3)
    canvas.solid((29.0, 22.3, 34.0, 22.8))
    canvas.solid((41.2, 15.0, 41.8, 18.0))
    canvas.round(35.6, 5.1, 0.25)
