"""A robot with a sonar ring in a world drawn as text."""

import numpy as np

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_rays
from pilotage.mapper.sonar_ring import SonarRing

RAYS = 41
"""Rays across a cone: the nearest thing answers."""


def ring_of(*directions: float, cone: float = 0.44, range_max: float = 4.0) -> SonarRing:
    """Return sonars at the robot's centre that look in these directions, rad."""
    mounts = np.zeros((len(directions), 3))
    mounts[:, 2] = directions
    return SonarRing(mounts, cone, range_max)


def hear(world: OccupancyMap, pose: np.ndarray, ring: SonarRing) -> np.ndarray:
    """Return the range (n,) of the nearest wall in each cone."""
    sonars = se2.compose(pose, ring.mounts)
    fan = np.zeros((RAYS, 3))
    fan[:, 2] = np.linspace(-ring.half_cone, ring.half_cone, RAYS)
    return np.array(
        [cast_rays(world, se2.compose(sonar, fan), ring.range_max).min() for sonar in sonars]
    )


def along(first: tuple[float, float], last: tuple[float, float], count: int) -> np.ndarray:
    """Return poses (n, 3) on a straight way, looking ahead."""
    start, end = np.array(first), np.array(last)
    way = start + np.linspace(0.0, 1.0, count)[:, None] * (end - start)
    heading = np.full((count, 1), np.arctan2(*(end - start)[::-1]))
    return np.hstack([way, heading])
