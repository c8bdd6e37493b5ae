"""The paper's algorithm to the letter (Wu & Bell 2003, M1 and M2), on the Markov grid; pure.

Every action is a prediction (eq. 4), every reading a correction by all rangers (eq. 14) and the
compass (eq. 12), begun with the floor P0 (eq. 8) under M2.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.experiments.ranger_robot import BEARINGS, Pose, Reading, RobotParams
from pilotage.localizer.markov_grid import MarkovGrid, MotionSpread
from pilotage.localizer.modes import Mode, find_modes, is_within
from pilotage.localizer.pose_grid import PoseGrid, PoseGridParams, pose_grid
from pilotage.localizer.range_model import (
    RangeModelParams,
    RangeTable,
    range_likelihoods,
    range_table,
)

CELL, HEADINGS = 0.10, 72
"""The paper's cells [m], and bins of 5 degrees."""

SAMPLES = 20_000
"""States that the modes are looked for in."""

FAINT = 0.01
"""Share of the belief below which a place is no mode here.

With the paper's floor every reading speaks to all states anew, and a place that one reading fits by
chance gets some thousandths until the next.
"""


@dataclass(frozen=True)
class RangerModel:
    """What the localizer takes the robot to be.

    `ranges`: eq. 5; its delta covers the width of a cell and of a heading bin beside the ranger's
    own error. `spread`: as small as the robot's errors. `floor`: weight of M2's P0.
    """

    grid: PoseGridParams = field(default_factory=lambda: PoseGridParams(CELL, HEADINGS))
    ranges: RangeModelParams = field(default_factory=lambda: RangeModelParams(delta=0.15))
    spread: MotionSpread = field(default_factory=lambda: MotionSpread(0.012, 0.0, 0.005, 0.002))
    robot: RobotParams = field(default_factory=RobotParams)
    floor: float = 1.0


@dataclass(frozen=True)
class Place:
    """The states of a map and the ranges expected in them: made once, used by many localizers."""

    world: OccupancyMap
    states: PoseGrid
    table: RangeTable


def survey(world: OccupancyMap, model: RangerModel) -> Place:
    """Return what localizers on a map share."""
    states = pose_grid(world, model.grid)
    table = range_table(world, states.geometry, states.headings, model.robot.range_max)
    return Place(world, states, table)


class RangerLocalizer:
    """The belief of a robot with four rangers; the compass only if `has_compass`."""

    def __init__(
        self,
        place: Place,
        model: RangerModel,
        algorithm: Literal["m1", "m2"],
        *,
        has_compass: bool,
    ) -> None:
        self.grid = MarkovGrid(place.states, model.spread)
        self._place = place
        self._model = model
        self._floor = model.floor if algorithm == "m2" else 0.0
        self._has_compass = has_compass

    def update(self, action: Pose, reading: Reading) -> None:
        """Predict by an action (3,), correct by a reading."""
        sigma = self._model.robot.compass
        self.grid.predict(action)
        self.grid.add_floor(self._floor, (reading.yaw, sigma) if self._has_compass else None)
        table = self._place.table
        likelihoods = range_likelihoods(reading.ranges, table.range_max, self._model.ranges)
        self.grid.weigh_ranges(BEARINGS, likelihoods, table)
        self.grid.settle()

    def modes(self) -> list[Mode]:
        """Return the most probable places, by falling mass; none if the belief has died out."""
        found = find_modes(*self.grid.heaviest(SAMPLES))
        return [mode for mode in found if mode.mass >= FAINT] or found[:1]

    def share_near(self, pose: NDArray[np.float64]) -> float:
        """Return the share of the belief within 0.5 m and 15 degrees of a pose (3,)."""
        poses, weights = self.grid.heaviest(SAMPLES)
        return float(weights[is_within(poses, pose)].sum())
