"""A robot that goes up and down a corridor, and what its laser tells on the way; pure."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.localizer.measurement import Measurement, scan_measurement

STEP, SWAY = 0.30, 0.15
"""Way between two scans [m], and how far [rad] the robot looks to either side in turns."""

LASER_BEAMS, LASER_VIEW, LASER_REACH, LASER_SIGMA = 271, 1.5 * np.pi, 12.0, 0.01
BEAMS = 60
"""Beams of a scan that weigh the belief."""


@dataclass(frozen=True)
class Sight:
    """A true pose (3,), map frame, and the scan taken there."""

    pose: NDArray[np.float64]
    scan: Measurement


def corridor_walk(
    world: OccupancyMap, along: tuple[float, float, float], count: int, seed: int = 0
) -> list[Sight]:
    """Return scans from a walk to and fro along a corridor.

    Args:
        world: the map, which is true to the world.
        along: x from, x to, and y of the walk [m].
        count: of scans.
        seed: of the laser's noise.
    """
    rng = np.random.default_rng(seed)
    return [Sight(pose, _scan(world, pose, rng)) for pose in _poses(along, count)]


def _poses(along: tuple[float, float, float], count: int) -> Iterator[NDArray[np.float64]]:
    """Yield poses that go forward and, at the end of the corridor, backward again."""
    low, high, y = along
    for index in range(count):
        way = (index * STEP) % (2.0 * (high - low))
        x = low + min(way, 2.0 * (high - low) - way)
        yield np.array([x, y, SWAY * np.sin(index / 2.0)])


def _scan(world: OccupancyMap, pose: NDArray[np.float64], rng: np.random.Generator) -> Measurement:
    bearings = np.linspace(-LASER_VIEW / 2.0, LASER_VIEW / 2.0, LASER_BEAMS)
    ranges = cast_scan(world, pose, bearings, LASER_REACH)
    noisy = (ranges + LASER_SIGMA * rng.standard_normal(LASER_BEAMS)).astype(np.float32)
    angles = float(bearings[0]), float(bearings[1] - bearings[0])
    return scan_measurement(noisy, angles, np.zeros(3), BEAMS, LASER_REACH)


def increments(walk: list[Sight]) -> list[NDArray[np.float64]]:
    """Return the motions (3,) from each scan to the next, as exact odometry measures them."""
    return [se2.between(before.pose, after.pose) for before, after in itertools.pairwise(walk)]
