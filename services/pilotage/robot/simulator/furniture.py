"""What stands in the rooms of an office, drawn in each room's own coordinates; pure."""

from collections.abc import Callable

import numpy as np

from pilotage.robot.simulator.floor_canvas import FloorCanvas, Room

Furnish = Callable[[FloorCanvas, Room], None]

CHAIR_RADIUS = 0.22


def chair(canvas: FloorCanvas, room: Room, along: float, deep: float) -> None:
    """Put down one chair."""
    canvas.round(*room.point(along, deep), CHAIR_RADIUS)


def single_office(canvas: FloorCanvas, room: Room) -> None:
    """A desk at the window, a shelf on the wall, a visitor's chair."""
    w, d = room.along, room.deep
    canvas.solid(room.place(0.05, d - 1.9, 1.75, d - 1.1))
    canvas.solid(room.place(0.05, d - 1.1, 0.65, d - 0.05))
    chair(canvas, room, 1.1, d - 0.65)
    chair(canvas, room, 0.95, d - 2.35)
    canvas.solid(room.place(w - 0.45, d - 3.0, w - 0.05, d - 0.6))


def double_office(canvas: FloorCanvas, room: Room) -> None:
    """Two desks face to face in the middle, shelves along one wall."""
    w, d = room.along, room.deep
    canvas.solid(room.place(w / 2 - 0.8, d - 2.6, w / 2 + 0.8, d - 1.0))
    chair(canvas, room, w / 2 - 0.2, d - 3.0)
    chair(canvas, room, w / 2 + 0.25, d - 0.6)
    canvas.solid(room.place(0.05, 1.9, 0.45, d - 1.4))


def meeting_room(canvas: FloorCanvas, room: Room) -> None:
    """A long table with chairs on both sides, a sideboard at the far wall."""
    w, d = room.along, room.deep
    canvas.solid(room.place(w / 2 - 0.6, 1.9, w / 2 + 0.6, d - 1.5))
    for deep in np.arange(2.3, d - 1.6, 0.8):
        chair(canvas, room, w / 2 - 0.9, float(deep))
        chair(canvas, room, w / 2 + 0.9, float(deep))
    canvas.solid(room.place(w / 2 - 1.0, d - 0.5, w / 2 + 1.0, d - 0.05))


def conference_room(canvas: FloorCanvas, room: Room) -> None:
    """Tables in the shape of a U, a lectern and a stack of chairs."""
    w, d = room.along, room.deep
    canvas.solid(room.place(2.2, 3.0, 2.9, d - 2.6))
    canvas.solid(room.place(w - 2.9, 3.0, w - 2.2, d - 2.6))
    canvas.solid(room.place(2.2, d - 3.3, w - 2.2, d - 2.6))
    for deep in np.arange(3.4, d - 3.0, 0.9):
        chair(canvas, room, 1.85, float(deep))
        chair(canvas, room, w - 1.85, float(deep))
    for along in np.arange(3.4, w - 2.9, 0.9):
        chair(canvas, room, float(along), d - 2.25)
    canvas.solid(room.place(w / 2 - 0.3, 1.3, w / 2 + 0.3, 1.7))
    canvas.solid(room.place(w - 0.75, d - 1.3, w - 0.1, d - 0.1))


def store_room(canvas: FloorCanvas, room: Room) -> None:
    """Rows of shelves with aisles between them."""
    w, d = room.along, room.deep
    canvas.solid(room.place(0.05, 1.8, 0.5, d - 0.05))
    canvas.solid(room.place(w - 0.5, 1.8, w - 0.05, d - 0.05))
    if w > 3.5:
        canvas.solid(room.place(w / 2 - 0.25, 2.0, w / 2 + 0.25, d - 1.2))


def kitchen(canvas: FloorCanvas, room: Room) -> None:
    """A counter round the corner, a fridge, two round tables."""
    w, d = room.along, room.deep
    canvas.solid(room.place(0.05, d - 0.65, w - 1.5, d - 0.05))
    canvas.solid(room.place(0.05, 2.0, 0.65, d - 0.05))
    canvas.solid(room.place(w - 0.8, d - 0.75, w - 0.05, d - 0.05))
    for along, deep in ((w * 0.62, d * 0.55),):
        canvas.round(*room.point(along, deep), 0.5)
        for angle in (0.5, 2.4, 4.4):
            chair(canvas, room, along + 0.85 * np.cos(angle), deep + 0.85 * np.sin(angle))


def toilets(canvas: FloorCanvas, room: Room) -> None:
    """A row of open stalls at the far wall, wash-basins at the side."""
    w, d = room.along, room.deep
    for along in np.arange(1.0, w - 0.3, 1.0):
        canvas.solid(room.place(float(along) - 0.025, d - 1.5, float(along) + 0.025, d - 0.05))
    for along in np.arange(0.5, w - 0.2, 1.0):
        canvas.solid(room.place(float(along) - 0.2, d - 0.65, float(along) + 0.2, d - 0.05))
    canvas.solid(room.place(0.05, 1.6, 0.5, 3.2))


def laboratory(canvas: FloorCanvas, room: Room) -> None:
    """Two long benches with stools, cabinets at the far wall."""
    w, d = room.along, room.deep
    for along in (w * 0.3, w * 0.68):
        canvas.solid(room.place(along - 0.4, 1.8, along + 0.4, d - 2.0))
        for deep in np.arange(2.3, d - 2.2, 1.1):
            canvas.round(*room.point(along + 0.65, float(deep)), 0.18)
    canvas.solid(room.place(0.6, d - 0.55, w - 0.6, d - 0.05))


def print_room(canvas: FloorCanvas, room: Room) -> None:
    """Two printers, a sorting table, a paper shelf."""
    w, d = room.along, room.deep
    canvas.solid(room.place(0.05, 1.9, 0.8, 3.1))
    canvas.solid(room.place(0.05, 3.5, 0.8, 4.5))
    canvas.solid(room.place(w - 1.6, d - 0.8, w - 0.05, d - 0.05))


def lounge(canvas: FloorCanvas, room: Room) -> None:
    """A corner sofa, an armchair, a low table, two plants."""
    w, d = room.along, room.deep
    canvas.solid(room.place(0.1, d - 0.9, 2.8, d - 0.1))
    canvas.solid(room.place(0.1, d - 2.9, 0.9, d - 0.1))
    canvas.solid(room.place(1.7, d - 2.2, 2.5, d - 1.6))
    canvas.solid(room.place(w - 1.2, d - 2.0, w - 0.4, d - 1.2))
    canvas.round(*room.point(w - 0.5, d - 0.5), 0.3)
    canvas.round(*room.point(0.5, 0.5), 0.25)


def empty_room(canvas: FloorCanvas, room: Room) -> None:
    """A room that waits for its next tenant: a rolled carpet and a few boxes."""
    w, d = room.along, room.deep
    canvas.solid(room.place(w - 0.9, d - 0.8, w - 0.1, d - 0.1))
    canvas.solid(room.place(0.1, d - 0.4, 2.2, d - 0.1))


def desk_island(canvas: FloorCanvas, x: float, y: float, pairs: int) -> None:
    """Put `pairs` of desks face to face in a row, screen panel between, chairs outside.

    `x`, `y` is the world's lower left corner of the desks, m.
    """
    canvas.solid((x, y, x + 1.6 * pairs, y + 1.6))
    for i in range(pairs):
        canvas.round(x + 1.6 * i + 0.7, y - 0.4, CHAIR_RADIUS)
        canvas.round(x + 1.6 * i + 0.95, y + 2.0, CHAIR_RADIUS)
