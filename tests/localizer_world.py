"""A small flat that looks like nothing else, and a robot that is driven through it."""

import math
from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drawing import draw
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.localizer.markov_localizer import MarkovParams
from pilotage.localizer.measurement import Measurement, scan_measurement
from pilotage.localizer.particle_evidence import EvidenceParams
from pilotage.localizer.particle_localizer import ParticleParams
from pilotage.localizer.particle_resampling import KldParams
from pilotage.localizer.particle_search import SearchParams
from pilotage.localizer.pose_grid import PoseGridParams

PLAN = """
    ##############################
    #........#...................#
    #........#...................#
    #........#.........##........#
    #..................##........#
    #............................#
    #........#...................#
    #........#......##############
    ####..####...................#
    #............................#
    #............................#
    #....##......................#
    #....##.................#....#
    #.......................#....#
    #.......................#....#
    ##############################
    """
MARK, CELL = 4, 0.1
"""Each mark of the plan is MARK x MARK cells of CELL metres."""

START = (2.0, 4.9, 0.2)
"""In the room on the upper left."""

ELSEWHERE = (8.6, 1.0, 2.6)
"""At the wall below, far from where ROUND leads."""

ROUND = [(0.15, 0.0, -0.1)] * 6 + [(0.25, 0.0, 0.0)] * 6 + [(0.2, 0.0, 0.07)] * 6
"""Steps (forward, left, turn) that lead from START through the door without touching a wall."""

ANGLE_MIN, ANGLE_STEP, BEAMS, RANGE_MAX = -math.pi, math.tau / 90, 90, 12.0
BEARINGS: NDArray[np.float64] = ANGLE_MIN + ANGLE_STEP * np.arange(BEAMS, dtype=np.float64)

COARSE = MarkovParams(grid=PoseGridParams(CELL, 36))
"""Few states, so that a test is quick; everything else as in service."""

FEW_PARTICLES = ParticleParams(
    kld=KldParams(least=1000, most=10_000),
    search=SearchParams(candidates=60_000, kept=20_000),
    evidence=EvidenceParams(tables=COARSE.grid),
)
"""The same for particles."""


def flat(origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> OccupancyMap:
    """The flat, 12 m x 6.4 m, wherever its map says that it lies."""
    plan = draw(PLAN)
    cells = np.kron(plan.cells, np.ones((MARK, MARK), np.int8))
    rows, cols = cells.shape
    return OccupancyMap(GridGeometry(rows, cols, CELL, origin), cells)


def scan_at(world: OccupancyMap, pose: ArrayLike) -> NDArray[np.float32]:
    """The ranges (BEAMS,) of an exact laser at a pose."""
    return cast_scan(world, pose, BEARINGS, RANGE_MAX).astype(np.float32)


def look(world: OccupancyMap, pose: ArrayLike, params: MarkovParams = COARSE) -> Measurement:
    """What a laser at the robot's centre tells the localizer."""
    ranges = scan_at(world, pose)
    return scan_measurement(ranges, (ANGLE_MIN, ANGLE_STEP), np.zeros(3), params.beams, RANGE_MAX)


def poses_along(
    start: ArrayLike, steps: Iterable[tuple[float, float, float]]
) -> Iterator[NDArray[np.float64]]:
    """The poses (3,) from `start` on, one more than there are steps."""
    pose = np.array(start, float)
    yield pose
    for step in steps:
        pose = se2.compose(pose, step)
        yield pose


def error(pose: ArrayLike, truth: ArrayLike) -> tuple[float, float]:
    """How far [m] and how much turned [rad] a pose is from the truth."""
    off = se2.between(truth, pose)
    return float(np.hypot(off[0], off[1])), abs(float(off[2]))
