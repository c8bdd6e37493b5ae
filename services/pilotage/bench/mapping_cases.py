"""The mapper: a scan drawn into the laser's grid, and a map drawn again after a loop was closed."""

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pilotage.bench.building_cases import OFFICE_CORRIDOR
from pilotage.bench.entry import Entry, Size, Stopwatch
from pilotage.bench.reference_laser_grid import PlainLaserGrid
from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_scans import DrawnScan, redraw
from pilotage.robot.simulator.floor_plans import office_floor

BEAMS, VIEW, REACH, SIGMA = 361, np.pi, 30.0, 0.01
"""A laser as on the robots of the recorded logs: beams, rad, m, m."""

SCANS, PLAIN_SCANS, REDRAWN = 200, 3, 1000
PERIOD = 0.1
"""s between two scans."""

SWAY = 0.8
"""How far [rad] the robot looks to either side on its way along the corridor."""


def mapping_cases(watch: Stopwatch) -> Iterator[Entry]:
    """Yield drawing one scan, and a thousand at once, in the office of 60 m x 40 m."""
    world = office_floor()
    poses, scans = _scans(world)
    plain = _plain_ms(watch, world, poses[:PLAIN_SCANS], scans[:PLAIN_SCANS])
    grid = redraw(poses, scans)
    spent = [_insert_ms(watch, grid, pose, scan) for pose, scan in zip(poses, scans, strict=True)]
    size = Size(int(np.prod(grid.map().geometry.shape)), BEAMS, "cells")
    yield Entry(
        "office: a scan drawn into the laser grid",
        size,
        float(np.median(spent)),
        plain,
        1.0,
        {"p95_ms": float(np.percentile(spent, 95))},
    )
    more = list(itertools.islice(itertools.cycle(scans), REDRAWN))
    again = np.resize(poses, (REDRAWN, 3))
    yield Entry(
        f"office: map drawn again from {REDRAWN:,} scans",
        size,
        watch.median_ms(lambda: redraw(again, more), 3),
        plain * REDRAWN,
        PLAIN_SCANS / REDRAWN,
    )


def _scans(world: OccupancyMap) -> tuple[NDArray[np.float64], list[DrawnScan]]:
    """Return poses (n, 3) along the corridor, and what the laser sees there."""
    rng = np.random.default_rng(0)
    x_from, x_to, y = OFFICE_CORRIDOR
    x = np.linspace(x_from, x_to, SCANS)
    poses = np.column_stack([x, np.full(SCANS, y), SWAY * np.sin(x)])
    bearings = np.linspace(-VIEW / 2.0, VIEW / 2.0, BEAMS)
    scans = []
    for k, pose in enumerate(poses):
        ranges = cast_scan(world, pose, bearings, REACH) + SIGMA * rng.standard_normal(BEAMS)
        is_hit = np.isfinite(ranges)
        lengths = np.where(is_hit, ranges, REACH)[:, None]
        ends = lengths * np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
        scans.append(DrawnScan(PERIOD * k, np.zeros(2), ends, is_hit))
    return poses, scans


def _insert_ms(
    watch: Stopwatch, grid: LaserGrid, pose: NDArray[np.float64], scan: DrawnScan
) -> float:
    """Return what drawing takes [ms] once the ends are known in the map."""
    ends = se2.transform_points(pose, scan.ends)
    return watch.ms(lambda: grid.insert(pose[:2], ends, scan.is_hit, scan.stamp))


def _plain_ms(
    watch: Stopwatch, world: OccupancyMap, poses: NDArray[np.float64], scans: list[DrawnScan]
) -> float:
    """Return what a scan takes the twin [ms], on a grid that is large enough from the start."""
    resolution = LaserGrid().params.resolution
    wide, tall = world.geometry.size_m
    shape = round((tall + 2 * REACH) / resolution), round((wide + 2 * REACH) / resolution)
    grid = PlainLaserGrid(shape, resolution, np.array(world.geometry.origin[:2]) - REACH)
    spent = []
    for pose, scan in zip(poses, scans, strict=True):
        ends = se2.transform_points(pose, scan.ends)
        spent.append(watch.ms(lambda: grid.insert(pose[:2], ends, scan.is_hit)))  # noqa: B023 - called at once
    return float(np.median(spent))
