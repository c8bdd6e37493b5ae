"""The mapper: a scan matched and drawn into the laser's grid, and a map drawn again."""

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pilotage.bench.building_cases import OFFICE_CORRIDOR
from pilotage.bench.entry import Entry, Size, Stopwatch
from pilotage.bench.reference_laser_grid import PlainLaserGrid
from pilotage.bench.reference_scan_match import plain_match
from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.mapper.front_end import FrontEndParams
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_scans import DrawnScan, redraw
from pilotage.mapper.odometry_drift import drift_covariance
from pilotage.mapper.scan_tracker import (
    HERE,
    LocalMap,
    TrackerParams,
    corrected,
    local_map,
    predicted,
)
from pilotage.mapper.surfel_kernels import thin_points
from pilotage.robot.simulator.floor_plans import office_floor

BEAMS, VIEW, REACH, SIGMA = 361, np.pi, 30.0, 0.01
"""A laser as on the robots of the recorded logs: beams, rad, m, m."""

SCANS, PLAIN_SCANS, REDRAWN = 200, 3, 1000
LOCAL = 20
"""So many scans make the map that one is matched on."""

MATCHED = 40
"""So many are matched."""

PERIOD = 0.1
"""s between two scans."""

SWAY = 0.8
"""How far [rad] the robot looks to either side on its way along the corridor."""


def mapping_cases(watch: Stopwatch) -> Iterator[Entry]:
    """Yield drawing one scan, a thousand, and matching one, in the office of 60 m x 40 m."""
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
    yield _match_case(watch, poses, scans)


def _match_case(watch: Stopwatch, poses: NDArray[np.float64], scans: list[DrawnScan]) -> Entry:
    """Match scans on the map of those before, where odometry puts them."""
    params, rng = TrackerParams(), np.random.default_rng(1)
    spent, plain, cells = list[float](), list[float](), 0
    for at in range(1, len(poses), max(1, len(poses) // MATCHED)):
        here = _map_before(poses, scans, at, params)
        increment = se2.between(poses[at - 1], poses[at])
        error = rng.multivariate_normal(np.zeros(3), drift_covariance(increment, params.drift))
        guess = predicted(HERE, se2.compose(increment, error), params.drift)
        points = thin_points(_hits(scans[at]), FrontEndParams().thin)
        spent.append(watch.ms(lambda: corrected(guess, points, here, params)))  # noqa: B023 - called at once
        if len(plain) < PLAIN_SCANS:
            plain.append(watch.ms(lambda: plain_match(guess, points, here, params)))  # noqa: B023 - same
        cells = here.surfels.nearest.size
    return Entry(
        "office: a scan matched on the map around",
        Size(cells, BEAMS, "cells"),
        float(np.median(spent)),
        float(np.median(plain)),
        1.0,
        {"p95_ms": float(np.percentile(spent, 95))},
    )


def _map_before(
    poses: NDArray[np.float64], scans: list[DrawnScan], at: int, params: TrackerParams
) -> LocalMap:
    """Return the map of the scans before one, in the frame of the last of them."""
    known = [
        se2.transform_points(se2.between(poses[at - 1], poses[k]), _hits(scans[k]))
        for k in range(max(0, at - LOCAL), at)
    ]
    return local_map(np.vstack(known), params)


def _hits(scan: DrawnScan) -> NDArray[np.float64]:
    """Return the points (n, 2) of a scan."""
    return np.ascontiguousarray(scan.ends[scan.is_hit])


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
