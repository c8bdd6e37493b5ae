"""A floor drawn as text, and drives through it with a laser."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drawing import draw
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.topology.features import Features
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.seeing.seen_features import seen_features

FLOOR = """
    ########################################################
    #.............#............#...........................#
    #.............#............#...........................#
    #.............#............#...........................#
    #.............#............#...........................#
    #.............#............#...........................#
    #.............#............#...........................#
    #.............#............#...........................#
    #.............#............#...........................#
    #.............#............#...........................#
    #.............#............#...........................#
    ######....###########....##########....#################
    #......................................................#
    #......................................................#
    #......................................................#
    #......................................................#
    #......................................................#
    #......................................................#
    #......................................................#
    #......................................................#
    ###############....#################....################
    #........................#.............................#
    #........................#.............................#
    #........................#.............................#
    #........................#.............................#
    #........................#.............................#
    #........................#.............................#
    #........................#.............................#
    ########################################################
    """
"""A corridor of 13.5 m x 2 m with five doors of 1 m; a mark is 0.25 m."""

MARK, FINER = 0.25, 5
DOORS = np.array([(2.0, 4.375), (5.75, 4.375), (9.25, 4.375), (4.25, 2.125), (9.5, 2.125)])
"""Middles of the doors of FLOOR, m."""

BEARINGS = np.linspace(-np.pi / 2.0, np.pi / 2.0, 361)
REACH = 20.0
STEP, TURN = 0.1, 0.15
"""m and rad from one scan to the next."""
PERIOD = 0.2
"""s from one scan to the next."""

ROUND = [(0.8, 3.3), (5.75, 3.3), (5.75, 5.6), (5.75, 3.3), (12.8, 3.3), (0.8, 3.3)]
"""Along the corridor, into a room and out again, to the end and back, m."""


def floor(picture: str = FLOOR) -> OccupancyMap:
    """Return the floor with cells of 5 cm."""
    coarse = draw(picture, MARK)
    cells = np.kron(coarse.cells, np.ones((FINER, FINER), np.int8)).astype(np.int8)
    rows, cols = cells.shape
    return OccupancyMap(GridGeometry(rows, cols, MARK / FINER, (0.0, 0.0, 0.0)), cells)


@dataclass(frozen=True)
class Glimpse:
    """A moment of a drive: `stamp` [s], where the robot is (3,) and what it sees in base_link."""

    stamp: float
    pose: NDArray[np.float64]
    seen: Features


def way_along(corners: list[tuple[float, float]]) -> Iterator[NDArray[np.float64]]:
    """Yield poses (3,) from corner to corner, turning on the spot."""
    heading = None
    for begin, end in pairwise(corners):
        run = np.subtract(end, begin)
        towards = float(np.arctan2(run[1], run[0]))
        turn = 0.0 if heading is None else (towards - heading + np.pi) % (2.0 * np.pi) - np.pi
        for share in np.linspace(0.0, 1.0, round(abs(turn) / TURN) + 1)[:-1]:
            yield np.array([*begin, towards - turn * (1.0 - share)])
        for share in np.linspace(0.0, 1.0, round(float(np.hypot(*run)) / STEP) + 1)[:-1]:
            yield np.array([*(np.array(begin) + share * run), towards])
        heading = towards


def look(world: OccupancyMap, pose: NDArray[np.float64], rng: np.random.Generator) -> ScanView:
    """Return a scan of a laser in base_link, sigma 1 cm."""
    ranges = cast_scan(world, pose, BEARINGS, REACH)
    ranges = ranges + rng.normal(0.0, 0.01, len(ranges))
    return ScanView.of(ranges, (float(BEARINGS[0]), float(BEARINGS[1] - BEARINGS[0])))


def drive(
    world: OccupancyMap, corners: list[tuple[float, float]], seed: int = 0
) -> Iterator[Glimpse]:
    """Yield what a robot sees on its way from corner to corner."""
    rng = np.random.default_rng(seed)
    for k, pose in enumerate(way_along(corners)):
        yield Glimpse(k * PERIOD, pose, seen_features(look(world, pose, rng)))
