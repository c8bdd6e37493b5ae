"""Floors on which trials are tried, and localizers on them."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drawing import draw
from localizer_world import COARSE
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.experiments.trial_world import Ride, TrialWorld
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.measurement import Measurement
from pilotage.planner.situation import Policy

CELL, MARK = 0.1, 4


def floor_of(picture: str) -> OccupancyMap:
    """The map drawn with marks of 0.4 m x 0.4 m, in cells of 0.1 m."""
    plan = draw(picture)
    cells = np.kron(plan.cells, np.ones((MARK, MARK), np.int8))
    rows, cols = cells.shape
    return OccupancyMap(GridGeometry(rows, cols, CELL), cells)


TWINS = floor_of(
    """
    ##########################
    #.......##########.......#
    #.......##########.......#
    #.......##########.......#
    #.......##########.......#
    #.......##########.......#
    ####..###########.###..###
    ####..###########.###..###
    #........................#
    #........................#
    #........................#
    #......##................#
    ##########################
    """
)
"""Two rooms alike, and a corridor that tells them apart."""

ROOM_WITH_PILLAR = floor_of(
    """
    ################
    #..............#
    #..............#
    #..............#
    #......#.......#
    #..............#
    #..............#
    #..............#
    ################
    """
)

DOORS = floor_of(
    """
    ####################
    #.......##.........#
    #.......##.........#
    #.......##.........#
    #..................#
    #..................#
    #.......##.........#
    #.......##.........#
    #####..#######..####
    #..................#
    #..................#
    #..................#
    #..........##......#
    ####################
    """
)
"""Three rooms with doors of 0.8 m."""

NOOK = floor_of(
    """
    ##########
    #........#
    #........#
    #####..###
    ####...###
    ####..####
    ##########
    """
)
"""A nook to get out of."""


class Deaf(MarkovLocalizer):
    """A localizer that takes no time, for it weighs nothing."""

    def wants(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], measurement: Measurement
    ) -> bool:
        del stamp_ns, odom_from_base, measurement
        return False


def trial_world(
    floor: OccupancyMap, sight: float = 12.0, method: type[MarkovLocalizer] = MarkovLocalizer
) -> TrialWorld:
    """A floor with a coarse localizer on it, and a laser that sees so far."""
    world = TrialWorld.of(floor, method(floor, COARSE))
    return world.seen_by(replace(world.robot.laser, range_max=sight))


def driven(
    world: TrialWorld, policy: Policy, start: tuple[float, float, float], seconds: float
) -> tuple[Ride, NDArray[np.float64]]:
    """What a policy does from a start: the ride, and the true poses (n, 3) at the scans."""
    ride = Ride(world, np.array(start), np.random.default_rng(1))
    poses = []
    for _ in range(round(seconds * 10)):
        ride.drive(policy.step(ride.look()))
        poses.append(ride.truth)
    return ride, np.array(poses)
