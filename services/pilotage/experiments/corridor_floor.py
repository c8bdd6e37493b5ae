"""The corridor of a building's floor that looks the same after half a turn; drawn in code, pure.

30 m x 12 m: a corridor of 2 m along the middle, five rooms on either side, open doors, cupboards
and columns. The upper half is the lower one turned about the middle.
"""

import itertools

import numpy as np

from pilotage.core.grid import OccupancyMap
from pilotage.robot.simulator.floor_canvas import FloorCanvas

WIDTH, HEIGHT, CELL = 30.0, 12.0, 0.10
MIDDLE = (WIDTH / 2.0, HEIGHT / 2.0)
WALL = 0.2
CORRIDOR_FROM, CORRIDOR_TO = 5.0, 7.0
"""Lower and upper side [m] of the corridor."""

ROOM_EDGES = (0.0, 5.0, 9.0, 15.0, 21.0, 30.0)
DOORS = (3.4, 5.6, 12.2, 16.0, 27.5)
"""Where each room's doorway begins [m]."""

DOOR_WIDTH = 1.0


def corridor_floor() -> OccupancyMap:
    """Return the floor, its lower left inner corner at the origin of the map frame."""
    canvas = FloorCanvas(WIDTH, HEIGHT, CELL, margin=WALL)
    canvas.solid((-WALL, -WALL, WIDTH + WALL, HEIGHT + WALL))
    canvas.floor((0.0, 0.0, WIDTH, HEIGHT))
    _draw_rooms(canvas)
    _furnish(canvas)
    half = canvas.to_map()
    cells = half.cells.copy()
    rows = len(cells) // 2
    cells[-rows:] = np.flip(cells[:rows])
    return OccupancyMap(half.geometry, cells)


def _draw_rooms(canvas: FloorCanvas) -> None:
    """Build the lower rooms' walls with their doorways."""
    line = CORRIDOR_FROM - WALL / 2.0
    canvas.wall((0.0, line), (WIDTH, line), WALL)
    for door in DOORS:
        canvas.floor((door, CORRIDOR_FROM - WALL, door + DOOR_WIDTH, CORRIDOR_FROM))
    for _, edge in itertools.pairwise(ROOM_EDGES[:-1]):
        canvas.wall((edge, 0.0), (edge, line), WALL)


def _furnish(canvas: FloorCanvas) -> None:
    """Put cupboards into the corridor and the rooms."""
    for box in (
        *((7.2, 5.0, 8.6, 5.4), (19.0, 5.0, 19.8, 5.3), (24.5, 5.0, 25.3, 5.5)),
        *((0.0, 0.0, 2.0, 0.6), (8.4, 1.0, 8.9, 3.0), (10.0, 0.0, 12.0, 0.8)),
        *((17.5, 1.5, 19.5, 2.5), (22.0, 0.0, 24.0, 0.5), (29.3, 1.0, 30.0, 3.0)),
    ):
        canvas.solid(box)
    canvas.round(13.5, 2.0, 0.4)
    canvas.round(26.0, 2.2, 0.5)
