"""The doors of the office floor, as its drawing cuts them; pure."""

from pilotage.robot.simulator.floor_canvas import Room
from pilotage.robot.simulator.floor_plans import (
    DOOR_ASIDE,
    DOOR_WIDTH,
    WIDE_DOORS,
    Line,
    office_rooms,
)


def office_doors() -> list[dict[str, object]]:
    """Return the doors of the office as they stand in a file; all are open, as the map has it."""
    lines = [*(_doorway(room) for room in office_rooms()), *WIDE_DOORS]
    return [{"ends": [_rounded(first), _rounded(second)]} for first, second in lines]


def _doorway(room: Room) -> Line:
    """Return the jambs of a room's door, that with the hinges first."""
    right = room.along - DOOR_ASIDE
    return room.point(right, 0.0), room.point(right - DOOR_WIDTH, 0.0)


def _rounded(point: tuple[float, float]) -> list[float]:
    return [round(point[0], 3), round(point[1], 3)]
