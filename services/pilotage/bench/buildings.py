"""Made-up buildings of any size, for measuring how work grows; pure."""

import numpy as np

from pilotage.core.grid import OccupancyMap
from pilotage.robot.simulator.floor_canvas import FloorCanvas

CELL = 0.10
OUTER, INNER = 0.2, 0.1
BAND = 10.0
"""Two rows of rooms and the corridor between them [m]."""

CORRIDOR_FROM, CORRIDOR_TO = 4.0, 6.0
CORRIDOR_MIDDLE = 5.0
ROOM, DOOR = 5.0, 1.0
"""Width of rooms and of their doors [m]."""


def office_block(side: float) -> OccupancyMap:
    """Return a square building, `side` m inside: bands of furnished rooms along corridors."""
    rng = np.random.default_rng(0)
    canvas = FloorCanvas(side, side, CELL, margin=OUTER)
    canvas.solid((-OUTER, -OUTER, side + OUTER, side + OUTER))
    canvas.floor((0.0, 0.0, side, side))
    for low in np.arange(0.0, side - CORRIDOR_TO, BAND):
        for wall in (low + CORRIDOR_FROM, low + CORRIDOR_TO):
            canvas.wall((0.0, wall), (side, wall), INNER)
        if low > 0.0:
            canvas.wall((0.0, low), (side, low), INNER)
        for left in np.arange(0.0, side - DOOR, ROOM):
            _draw_rooms(canvas, (float(left), float(low)), side, rng)
    return canvas.to_map()


def _draw_rooms(
    canvas: FloorCanvas, corner: tuple[float, float], side: float, rng: np.random.Generator
) -> None:
    """Draw the room on either side of a corridor: a wall to the left, a door, a cupboard."""
    left, low = corner
    top = min(low + BAND, side)
    for bottom, high, wall in (
        (low, low + CORRIDOR_FROM, low + CORRIDOR_FROM),
        (low + CORRIDOR_TO, top, low + CORRIDOR_TO),
    ):
        if left > 0.0:
            canvas.wall((left, bottom), (left, high), INNER)
        door = left + rng.uniform(0.3, ROOM - DOOR - 0.3)
        if door + DOOR < side:
            canvas.floor((door, wall - INNER / 2.0, door + DOOR, wall + INNER / 2.0))
        x, y = rng.uniform((left + 0.5, bottom + 0.3), (left + 3.0, max(high - 2.0, bottom + 0.4)))
        width, depth = rng.uniform(0.4, 1.2, 2)
        if x + width < side and y + depth < high:
            canvas.solid((x, y, x + width, y + depth))
