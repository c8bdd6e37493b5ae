"""Machine code for what the mapper calculates, made or loaded before a robot waits for it."""

import math
from collections.abc import Iterator
from functools import cache

import numpy as np

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.logs import OdometryRecord, Record, ScanRecord
from pilotage.core.raycast import cast_scan
from pilotage.mapper import (
    arc_median,
    laser_grid_kernels,
    sonar_arcs,
    sonar_kernels,
    temporal_filter,
)
from pilotage.mapper.laser_slam import LaserSlam

SIDE, CELL = 80, 0.1
"""Cells along a side of the room that is mapped, and m of each."""

BEAMS, REACH = 90, 12.0
STEPS, ROUNDS, RADIUS = 44, 1.3, 2.8
"""Scans a round, and the way: more than once round, so that a loop is closed; m."""


@cache
def warm_up() -> None:
    """Compile all kernels, or load them: half a minute after a change, else a second; once."""
    for module in (arc_median, laser_grid_kernels, sonar_arcs, sonar_kernels, temporal_filter):
        module.warm_up()
    slam = LaserSlam()
    for record in _ride(_room()):
        slam.process(record)
    slam.settle()
    slam.map()


def _room() -> OccupancyMap:
    """A room with a block in its middle and two things by which to tell its corners apart."""
    cells = np.zeros((SIDE, SIDE), np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = 100
    cells[30:50, 30:50] = cells[5:9, 40:43] = cells[60:70, 8:12] = 100
    return OccupancyMap(GridGeometry(SIDE, SIDE, CELL), cells)


def _ride(room: OccupancyMap) -> Iterator[Record]:
    """What odometry and a laser say on the way round the block."""
    bearings = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
    middle = SIDE * CELL / 2.0
    for step in range(int(ROUNDS * STEPS)):
        angle = math.tau * (step / STEPS % 1.0)
        x, y = middle + RADIUS * math.cos(angle), middle + RADIUS * math.sin(angle)
        pose = (x, y, math.remainder(angle + math.pi / 2.0, math.tau))
        ranges = cast_scan(room, pose, bearings, REACH).astype(np.float32)
        yield OdometryRecord(float(step), pose)
        first, increment = float(bearings[0]), math.tau / BEAMS
        yield ScanRecord(float(step), ranges, first, increment, REACH, pose, (0.0, 0.0, 0.0))
