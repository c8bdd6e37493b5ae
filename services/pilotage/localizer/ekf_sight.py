"""Where the filter's walls come from: a laser scan, or the map."""

from pilotage.core.grid import OccupancyMap
from pilotage.core.line_extraction import extract_lines
from pilotage.core.lines import Lines
from pilotage.core.map_lines import map_lines
from pilotage.localizer.ekf_walls import Walls
from pilotage.localizer.measurement import Beams


def walls_of_map(world: OccupancyMap) -> Walls:
    """Return the walls of a map, in map."""
    return Walls.of(map_lines(world))


def seen_walls(beams: Beams) -> Walls:
    """Return the walls in a laser scan, in base_link."""
    count = len(beams.bearings)
    if count < 2:
        return Walls.of(Lines.none())
    step = float(beams.bearings[-1] - beams.bearings[0]) / (count - 1)
    lines = extract_lines(beams.ranges, (float(beams.bearings[0]), step))
    return Walls.of(lines.moved(beams.base_from_laser))
