"""The field of RoboCup's four-legged league of 2006, on which Liu et al. 2008 tried their method.

A playing area of 5.4 m x 3.6 m on a carpet of 6 m x 4 m, x along the field, (0, 0) the centre.
Positions are those of the rules of 2005, as far as they are known today. What the rules leave
open is invented: which beacon has which colours, and a board round the carpet, since a simulated
robot must not fall off it.
"""

from dataclasses import replace

from pilotage.core.grid import OccupancyMap
from pilotage.robot.simulator.floor_canvas import FloorCanvas

CARPET_LENGTH, CARPET_WIDTH = 6.0, 4.0
HALF_LENGTH, HALF_WIDTH = 2.7, 1.8
"""Of the playing area."""
BEACON_X, BEACON_Y, BEACON_RADIUS = 1.35, 1.95, 0.05
PENALTY_X, PENALTY_Y = 2.05, 0.65
"""Corner of the penalty boxes, which are 0.65 m deep and 1.30 m wide."""
GOAL_HALF_WIDTH, GOAL_WALL = 0.4, 0.05
CELL, BOARD = 0.05, 0.10

COLOURS = (
    *(("pink_over_yellow", 1, 1), ("yellow_over_pink", 1, -1)),
    *(("pink_over_blue", -1, 1), ("blue_over_pink", -1, -1)),
)
"""Of the beacons: name and signs of x and y."""

Entry = dict[str, str | float]
"""A landmark as it stands in a file (core/landmark_map.py)."""


def football_field() -> OccupancyMap:
    """Return carpet, board, the side walls of the goals and the beacons; lines are no obstacles."""
    canvas = FloorCanvas(CARPET_LENGTH, CARPET_WIDTH, CELL, margin=BOARD)
    centre_x, centre_y = CARPET_LENGTH / 2.0, CARPET_WIDTH / 2.0
    canvas.solid((-BOARD, -BOARD, CARPET_LENGTH + BOARD, CARPET_WIDTH + BOARD))
    canvas.floor((0.0, 0.0, CARPET_LENGTH, CARPET_WIDTH))
    goal_depth = centre_x - HALF_LENGTH
    for x in (0.0, CARPET_LENGTH - goal_depth):
        for y in (centre_y - GOAL_HALF_WIDTH - GOAL_WALL, centre_y + GOAL_HALF_WIDTH):
            canvas.solid((x, y, x + goal_depth, y + GOAL_WALL))
    for _, side_x, side_y in COLOURS:
        canvas.round(centre_x + side_x * BEACON_X, centre_y + side_y * BEACON_Y, BEACON_RADIUS)
    drawn = canvas.to_map()
    corner = (-centre_x - BOARD, -centre_y - BOARD, 0.0)
    return OccupancyMap(replace(drawn.geometry, origin=corner), drawn.cells)


def football_landmarks() -> list[Entry]:
    """Return goals and beacons, which have colours, and the crossings of the lines."""
    goals: list[Entry] = [
        _entry("goal", HALF_LENGTH, 0.0, "yellow"),
        _entry("goal", -HALF_LENGTH, 0.0, "blue"),
    ]
    beacons = [_entry("beacon", sx * BEACON_X, sy * BEACON_Y, name) for name, sx, sy in COLOURS]
    corners = [(HALF_LENGTH, HALF_WIDTH), (PENALTY_X, PENALTY_Y)]
    crossings = [
        *(_entry("l_crossing", sx * x, sy * y) for x, y in corners for _, sx, sy in COLOURS),
        *(_entry("t_crossing", 0.0, side * HALF_WIDTH) for side in (1, -1)),
        *(_entry("t_crossing", sx * HALF_LENGTH, sy * PENALTY_Y) for _, sx, sy in COLOURS),
    ]
    return [*goals, *beacons, _entry("centre_circle", 0.0, 0.0), *crossings]


def _entry(kind: str, x: float, y: float, identity: str | None = None) -> Entry:
    entry: Entry = {"class": kind, "x": x, "y": y}
    return entry if identity is None else {**entry, "id": identity}
