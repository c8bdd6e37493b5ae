"""Where the filter's walls come from: a laser scan, or the map."""

import numpy as np

from pilotage.core.grid import OccupancyMap
from pilotage.core.line_extraction import extract_lines
from pilotage.core.lines import Lines
from pilotage.core.map_lines import map_lines
from pilotage.localizer.ekf_walls import Walls
from pilotage.localizer.measurement import Beams

WRONG_CELLS, WRONG_TURN = 1.0, 0.2
"""Standard deviations of a wall of the map, beside what its cells say: so many cells off its place,
and turned by so many rad for each m of a cell. Who drew the map was wrong by that, and is again
with every scan: with less, Wean Hall's jambs pull the pose along the corridor by a metre."""


def walls_of_map(world: OccupancyMap) -> Walls:
    """Return the walls of a map, in map, with the errors of whoever drew it."""
    lines = map_lines(world)
    alpha, middle = lines.polar[:, 0], lines.ends.mean(axis=1)
    jacobian = np.zeros((len(lines), 2, 2))
    jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
    jacobian[:, 1, 0] = middle[:, 1] * np.cos(alpha) - middle[:, 0] * np.sin(alpha)
    error = np.diag([WRONG_TURN, WRONG_CELLS]) * world.geometry.resolution
    wrong = jacobian @ error**2 @ jacobian.transpose(0, 2, 1)
    return Walls.of(Lines(lines.ends, lines.polar, lines.covariances + wrong))


def seen_walls(beams: Beams) -> Walls:
    """Return the walls in a laser scan, in base_link."""
    count = len(beams.bearings)
    if count < 2:
        return Walls.of(Lines.none())
    step = float(beams.bearings[-1] - beams.bearings[0]) / (count - 1)
    lines = extract_lines(beams.ranges, (float(beams.bearings[0]), step))
    return Walls.of(lines.moved(beams.base_from_laser))
