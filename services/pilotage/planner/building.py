"""Everything that is made once for a map and a robot, so that planning on it is quick; pure."""

import numpy as np

from pilotage.core.grid import OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.planner import (
    common_ground,
    expected_scans,
    hypotheses,
    information,
    landmark_sight,
    map_potential,
    path_kernels,
)
from pilotage.planner.active_drive import ActiveDrive
from pilotage.planner.active_localization import ActiveLocalization, ActiveParams
from pilotage.planner.going import Going
from pilotage.planner.ground import Ground
from pilotage.planner.landmark_sight import CameraParams, LandmarkSight
from pilotage.planner.mission import NoWayError, Target
from pilotage.planner.path_finding import NoPathError, find_path
from pilotage.planner.path_params import FollowerParams
from pilotage.planner.situation import Situation

COARSEST = 0.5
"""m per cell: a robot does not see where it fits through on coarser maps."""
LARGEST = 100_000.0
"""m^2 of map, free or not: what is expected to be seen on larger ones does not fit into memory."""


def unusable(world: OccupancyMap) -> str | None:
    """Say in words why nobody can plan on a map; None if one can."""
    geometry = world.geometry
    if not world.is_free.any():
        return "the map has no free ground"
    if geometry.resolution > COARSEST:
        return f"the map's cells of {geometry.resolution:g} m are too coarse to plan on"
    area = geometry.rows * geometry.cols * geometry.resolution**2
    if area > LARGEST:
        return f"the map of {area:.0f} m^2 is too large to plan on"
    return None


class Building:
    """Begins searches and ways on one map for one robot.

    `tuned`: how it decides and how it drives; `camera`: what landmarks it is localized by, if by
    any, and what sees them.
    """

    def __init__(
        self,
        world: OccupancyMap,
        tuned: tuple[ActiveParams, FollowerParams],
        camera: tuple[LandmarkMap, CameraParams] | None = None,
    ) -> None:
        active, follower = tuned
        sight = None if camera is None else LandmarkSight(camera[0], world, camera[1])
        self.active = ActiveLocalization(world, active, sight)
        self._ground = Ground.of(world)
        self._follower = follower

    def search(self, rng: np.random.Generator) -> ActiveDrive:
        """Begin to find out where the robot is."""
        return ActiveDrive(self.active, rng, self._follower)

    def check(self, target: Target) -> None:
        """Raise NoWayError if the robot cannot stand at a target."""
        try:
            find_path(self._ground, target.pose[:2], target.pose[:2], self._follower.radius)
        except NoPathError as error:
            raise NoWayError(str(error)) from error

    def way(self, target: Target, situation: Situation) -> Going:
        """Begin to go to a target; NoWayError if no way leads there."""
        try:
            return Going(self._ground, target, situation, self._follower)
        except NoPathError as error:
            raise NoWayError(str(error)) from error


def warm_up() -> None:
    """Compile all kernels, or load them."""
    for module in (
        information,
        hypotheses,
        common_ground,
        expected_scans,
        map_potential,
        path_kernels,
        landmark_sight,
    ):
        module.warm_up()
