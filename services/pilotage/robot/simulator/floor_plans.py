"""The floors that come with Pilotage, drawn in code; pure.

`square_hall` is the hall of Wu & Bell 2003, figure 4: featureless, so that only a compass tells
its four sides apart. `office_floor` is an invented office of 60 m x 40 m: many rooms are exact
twins, so one look is ambiguous; corridors, furniture and the halls make the whole unique.
"""

import itertools

from pilotage.core.grid import OccupancyMap
from pilotage.robot.simulator import furniture
from pilotage.robot.simulator.floor_canvas import Box, FloorCanvas, Room
from pilotage.robot.simulator.furniture import Furnish

Line = tuple[tuple[float, float], tuple[float, float]]
HALL_SIZE, HALL_CELL = 15.0, 0.10
OFFICE_WIDTH, OFFICE_HEIGHT, OFFICE_CELL = 60.0, 40.0, 0.05
OUTER_WALL, INNER_WALL = 0.30, 0.10
DOOR_WIDTH, DOOR_ASIDE = 1.0, 0.45
"""Of the rooms' doors, and how far they are from the right end of their wall, m."""
WIDE_DOORS: tuple[Line, ...] = (
    *(((35.4, 15.2), (35.4, 17.2)), ((35.4, 23.6), (35.4, 25.6))),
    *(((42.0, 31.8), (44.0, 31.8)), ((40.6, 27.0), (41.8, 27.0))),
)
"""Of the open-plan office and the foyer."""

SOUTH_CORRIDOR: Box = (0.0, 6.0, 60.0, 8.2)
NORTH_CORRIDOR: Box = (0.0, 31.8, 46.0, 34.0)
WEST_CORRIDOR: Box = (8.0, 8.2, 10.0, 31.8)
MIDDLE_CORRIDOR: Box = (33.0, 8.2, 35.4, 31.8)
COURTYARD: Box = (16.0, 15.0, 27.0, 25.0)
OPEN_PLAN: Box = (35.4, 14.0, 60.0, 27.0)
LOBBY: Box = (26.0, 0.0, 36.0, 6.0)


def square_hall() -> OccupancyMap:
    """Return the 15 m x 15 m hall: 150 x 150 free cells of 0.10 m inside a wall one cell thick."""
    canvas = FloorCanvas(HALL_SIZE, HALL_SIZE, HALL_CELL, margin=HALL_CELL)
    canvas.solid((-HALL_CELL, -HALL_CELL, HALL_SIZE + HALL_CELL, HALL_SIZE + HALL_CELL))
    canvas.floor((0.0, 0.0, HALL_SIZE, HALL_SIZE))
    return canvas.to_map()


def office_floor() -> OccupancyMap:
    """Return the office: 60 m x 40 m inside, 0.05 m cells, unknown outside and in the courtyard."""
    canvas = FloorCanvas(OFFICE_WIDTH, OFFICE_HEIGHT, OFFICE_CELL, margin=0.5)
    edge = OUTER_WALL
    canvas.solid((-edge, -edge, OFFICE_WIDTH + edge, OFFICE_HEIGHT + edge))
    canvas.floor((0.0, 0.0, OFFICE_WIDTH, OFFICE_HEIGHT))
    _draw_rooms(canvas)
    _draw_lobby(canvas)
    _draw_open_plan(canvas)
    _draw_courtyard(canvas)
    _draw_corridors(canvas)
    return canvas.to_map()


def office_rooms() -> list[Room]:
    """Return the rooms of the office that have one door, in the order they are drawn."""
    return [room for room, _ in _rooms()]


def _rooms() -> list[tuple[Room, Furnish]]:
    f = furniture
    south_west = _row((0, 4, 8, 12, 16, 21, 26), 0.0, 6.0, "N")
    south_east = _row((36, 40, 44, 48, 52, 56, 60), 0.0, 6.0, "N")
    north = _row((0, 4, 8, 12, 16, 22, 26, 30, 34, 38, 46), 34.0, 40.0, "S")
    inner_south = _row((10, 15, 19, 24, 29, 33), 8.2, 14.0, "S")
    inner_south_east = _row((35.4, 39.5, 43.6, 47.7, 51.8, 60), 8.2, 14.0, "S")
    inner_north = _row((10, 14, 18, 22, 27, 33), 26.0, 31.8, "N")
    west = _column((8.2, 13, 17, 21, 25, 31.8), 0.0, 8.0, "E")
    inner_west = _column((14, 18, 22, 26), 10.0, 16.0, "W")
    inner_east = _column((14, 20, 26), 27.0, 33.0, "E")
    single, double = f.single_office, f.double_office
    return [
        *_furnished(south_west, (single, single, single, single, double, f.meeting_room)),
        *_furnished(south_east, (single, single, single, double, single, single)),
        *_furnished(
            north,
            (
                *(single, single, single, single, f.laboratory),
                *(double, double, double, single, f.lounge),
            ),
        ),
        *_furnished(inner_south, (f.kitchen, f.print_room, f.toilets, f.toilets, f.store_room)),
        *_furnished(inner_south_east, (single, single, single, single, f.laboratory)),
        *_furnished(inner_north, (double, double, f.empty_room, f.store_room, f.kitchen)),
        *_furnished(west, (f.meeting_room, double, double, double, f.laboratory)),
        *_furnished(inner_west, (single, single, single)),
        *_furnished(inner_east, (f.meeting_room, f.store_room)),
        (Room((47.0, 28.0, 60.0, 40.0), "W"), f.conference_room),
    ]


def _row(edges: tuple[float, ...], y0: float, y1: float, door_side: str) -> list[Room]:
    """Return rooms side by side along x."""
    return [Room((x0, y0, x1, y1), door_side) for x0, x1 in itertools.pairwise(edges)]


def _column(edges: tuple[float, ...], x0: float, x1: float, door_side: str) -> list[Room]:
    """Return rooms side by side along y."""
    return [Room((x0, y0, x1, y1), door_side) for y0, y1 in itertools.pairwise(edges)]


def _furnished(rooms: list[Room], pieces: tuple[Furnish, ...]) -> list[tuple[Room, Furnish]]:
    return list(zip(rooms, pieces, strict=True))


def _draw_rooms(canvas: FloorCanvas) -> None:
    rooms = _rooms()
    for room, _ in rooms:
        _enclose(canvas, room.box)
    for room, furnish in rooms:
        _open_door(canvas, room)
        furnish(canvas, room)


def _enclose(canvas: FloorCanvas, box: Box) -> None:
    x0, y0, x1, y1 = box
    for start, end in (
        ((x0, y0), (x1, y0)),
        ((x0, y1), (x1, y1)),
        ((x0, y0), (x0, y1)),
        ((x1, y0), (x1, y1)),
    ):
        canvas.wall(start, end, INNER_WALL)


def _open_door(canvas: FloorCanvas, room: Room) -> None:
    """Cut the doorway near the right end of its wall; the leaf stands open against the side."""
    right = room.along - DOOR_ASIDE
    half = INNER_WALL / 2.0
    canvas.floor(room.place(right - DOOR_WIDTH, -half, right, half))
    canvas.solid(room.place(right, half, right + 0.05, half + DOOR_WIDTH - 0.05))


def _draw_lobby(canvas: FloorCanvas) -> None:
    """Open to the corridor between two stubs of wall: reception desk, sofas, columns, plants."""
    x0, _, x1, y1 = LOBBY
    canvas.floor((x0 + 1.2, y1 - 0.1, x1 - 1.8, y1 + 0.1))
    canvas.solid((x0 + 1.2, y1 - 0.05, x0 + 1.25, y1 + 0.05))
    canvas.solid((28.0, 3.6, 31.0, 4.2))
    canvas.solid((28.0, 2.4, 28.6, 4.2))
    canvas.solid((33.2, 0.1, 35.9, 0.9))
    canvas.solid((35.1, 0.1, 35.9, 2.6))
    canvas.solid((33.6, 1.5, 34.4, 2.1))
    canvas.round(29.0, 6.0, 0.25)
    canvas.round(32.6, 6.0, 0.25)
    canvas.round(26.5, 0.5, 0.3)


def _draw_open_plan(canvas: FloorCanvas) -> None:
    """Islands of desks between columns, two telephone boxes, shelves; two wide openings."""
    x0, y0, _, y1 = OPEN_PLAN
    canvas.wall((x0, y0), (x0, y1), INNER_WALL)
    canvas.wall((x0, y1), (47.0, y1), INNER_WALL)
    for (x, start), (_, end) in WIDE_DOORS[:2]:
        canvas.floor((x - 0.1, start, x + 0.1, end))
    for x, y, pairs in (
        *((39.0, 16.6, 3), (45.8, 16.6, 3), (53.2, 16.6, 2)),
        *((39.0, 22.2, 2), (44.6, 22.2, 3), (51.6, 22.2, 3)),
    ):
        furniture.desk_island(canvas, x, y, pairs)
    for x in (38.0, 44.4, 50.8, 57.2):
        canvas.solid((x - 0.25, 20.0, x + 0.25, 20.5))
    canvas.solid((57.6, 14.2, 59.9, 14.6))
    canvas.solid((59.4, 15.2, 59.9, 18.0))
    for y in (24.6, 25.8):
        canvas.solid((58.4, y, 59.95, y + 1.1))
    canvas.solid((47.4, 14.1, 50.6, 14.5))
    canvas.solid((36.4, 26.4, 39.2, 26.9))
    canvas.round(36.0, 18.2, 0.3)
    canvas.round(56.6, 26.3, 0.3)


def _draw_courtyard(canvas: FloorCanvas) -> None:
    """The glass front of a courtyard that nobody of this floor enters, with its gallery."""
    _enclose(canvas, COURTYARD)
    x0, y0, x1, y1 = COURTYARD
    half = INNER_WALL / 2.0
    canvas.hidden((x0 + half, y0 + half, x1 - half, y1 - half))
    for box in ((16.0, 14.0, 27.0, 15.0), (16.0, 25.0, 27.0, 26.0)):
        canvas.hidden((box[0] + half, box[1] + half, box[2] - half, box[3] - half))


def _draw_corridors(canvas: FloorCanvas) -> None:
    """The foyer of the conference room, and what stands about in corridors."""
    canvas.wall((35.4, 31.8), (47.0, 31.8), INNER_WALL)
    canvas.wall((35.4, 27.0), (35.4, 31.8), INNER_WALL)
    for (start, y), (end, _) in WIDE_DOORS[2:]:
        canvas.floor((start, y - 0.1, end, y + 0.1))
    canvas.solid((36.0, 27.2, 39.0, 27.7))
    canvas.round(38.5, 30.0, 0.45)
    canvas.round(44.8, 29.2, 0.45)
    canvas.wall((46.0, 34.0), (47.0, 34.0), INNER_WALL)
    canvas.hidden((46.05, 34.05, 46.95, 40.0))
    for x0, y0, x1, y1 in (
        *((11.9, 31.85, 13.5, 32.25), (24.0, 31.85, 25.2, 32.35), (29.6, 33.55, 31.2, 33.95)),
        *((2.0, 7.75, 3.4, 8.15), (43.0, 6.05, 44.6, 6.5), (52.6, 7.7, 54.6, 8.15)),
        *((8.05, 17.5, 8.45, 18.9), (33.05, 21.4, 33.5, 23.0), (34.8, 12.0, 35.35, 13.2)),
        *((59.3, 6.1, 59.9, 7.0), (0.1, 33.2, 0.8, 33.9), (18.6, 6.05, 19.2, 6.5)),
    ):
        canvas.solid((x0, y0, x1, y1))
