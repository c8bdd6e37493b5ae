"""One drive through a hall, reckoned with and without correction, and mapped by every model."""

from dataclasses import dataclass

import numpy as np

from pilotage.core.grid import OccupancyMap
from pilotage.experiments.sonar_drive import Morcs2, SonarDrive, drive
from pilotage.experiments.sonar_halls import Hall
from pilotage.experiments.sonar_maps import (
    NEAR_READINGS,
    Reckoned,
    drawn,
    drawn_plainly,
    grid_params,
    noise_of,
    reckon,
)
from pilotage.experiments.wall_segments import Floats
from pilotage.mapper.sonar_models import SonarModel

MODELS: tuple[SonarModel, ...] = ("centre_line", "bayes", "atm", "improved_atm")
"""Drawn at corrected poses; `plain` is the centre line at those of odometry."""


@dataclass(frozen=True, eq=False)
class SonarTrial:
    """What a drive was, where the robot was thought to be, and the maps by model."""

    drive: SonarDrive
    ways: Reckoned
    maps: dict[str, OccupancyMap]

    def noise(self, walls: Floats) -> dict[str, tuple[int, int]]:
        """Return noise cells and obstacle cells of each map."""
        return {name: noise_of(world, walls) for name, world in self.maps.items()}


def try_out(hall: Hall, robot: Morcs2, rng: np.random.Generator) -> SonarTrial:
    """Drive through a hall and map it."""
    run = drive(hall.walls, hall.start, hall.orders, robot, rng)
    ways = reckon(run, robot)
    maps = {"plain": drawn_plainly(run, ways.plain, robot).map()}
    for model in MODELS:
        params = grid_params(NEAR_READINGS)
        maps[model] = drawn(run, ways.corrected, robot, model, params).map()
    return SonarTrial(run, ways, maps)
