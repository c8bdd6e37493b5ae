"""People who walk about while a robot draws a map of a furnished office."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import OccupancyMap
from pilotage.experiments.clutter import Condition, altered
from pilotage.experiments.tracks import PERIOD, drive_through
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_params import LaserGridParams
from pilotage.robot.simulator.floor_plans import office_floor
from pilotage.robot.simulator.people import People
from pilotage.robot.simulator.range_sensors import LaserParams, Surroundings, scan
from pilotage.robot.simulator.walls import Walls

LASER = LaserParams(beams=361, field_of_view=np.pi, range_max=20.0)
STRIDES, PEOPLE, PER_STRIDE = 120, 12, 5
"""0.3 m and 0.5 s each; 5 scans a stride are 10 Hz."""

POSE_ERROR = 0.01, 0.01, np.deg2rad(0.2)
NEAR = 0.15
"""What is drawn farther from any wall is a ghost [m]."""

PLAIN = LaserGridParams(graze_max=0.0, person_width=1e-6)
"""With scans that have no stamp: the usual grid, in which nothing waits and grazing beams count."""


Seen = tuple[Any, ...]
"""Arguments of `LaserGrid.insert`."""


@dataclass(frozen=True, eq=False)
class Drive:
    """Scans (origin, ends, is_hit, stamp) by believed poses, and what really stands there.

    `sightings` (rows, cols): how many scans had a clear view of a cell of the walls, had there been
    no people.
    """

    walls: Walls
    scans: list[Seen]
    sightings: np.ndarray


@cache
def drive(every: int, seed: int) -> Drive:
    """A drive of which every so many scans are kept."""
    rng = np.random.default_rng(seed)
    walls = altered(office_floor(), Condition(piece_area=40.0), rng)
    blind = Condition(laser=LaserParams(beams=2))
    strides = drive_through(walls, blind, (STRIDES,), rng).truth
    people, scans = People(walls, PEOPLE, rng), []
    sightings = np.zeros(walls.geometry.shape, int)
    for k in range(PER_STRIDE * (STRIDES - 1)):
        stride, part = divmod(k, PER_STRIDE)
        pose = se2.interpolate(strides[stride], strides[stride + 1], part / PER_STRIDE)
        if k % every == 0:
            scans.append(seen(Surroundings(walls, people.discs), pose, k, rng))
            count_sightings(walls, pose, sightings)
        people.walk(pose, PERIOD / PER_STRIDE, rng)
    return Drive(walls, scans, sightings)


def seen(around: Surroundings, pose: np.ndarray, k: int, rng: np.random.Generator) -> Seen:
    ranges = scan(around, pose, LASER, rng).astype(float)
    laser = se2.compose(se2.compose(pose, rng.normal(0.0, POSE_ERROR)), (LASER.mount_x, 0.0, 0.0))
    is_hit = np.isfinite(ranges)
    angles = laser[2] + LASER.bearings[is_hit]
    ends = laser[:2] + ranges[is_hit, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return laser[:2], ends, np.ones(len(ends), bool), k * PERIOD / PER_STRIDE


def count_sightings(walls: Walls, pose: np.ndarray, sightings: np.ndarray) -> None:
    laser = se2.compose(pose, (LASER.mount_x, 0.0, 0.0))
    ranges = walls.ranges(laser, LASER.bearings, LASER.range_max) + 0.01
    angles = laser[2] + LASER.bearings[np.isfinite(ranges)]
    ranges = ranges[np.isfinite(ranges), None]
    cells = walls.geometry.cells_of(
        laser[:2] + ranges * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    )
    sightings[tuple(np.unique(cells[walls.geometry.contains(cells)], axis=0).T)] += 1


def drawn(run: Drive) -> OccupancyMap:
    grid = LaserGrid()
    for scan_of_drive in run.scans:
        grid.insert(*scan_of_drive)
    return grid.map()


def plainly_drawn(run: Drive) -> OccupancyMap:
    grid = LaserGrid(PLAIN)
    for origin, ends, is_hit, _ in run.scans:
        grid.insert(origin, ends, is_hit)
    return grid.map()


def ghosts(run: Drive, world: OccupancyMap) -> int:
    """Cells of the map that show walls where nothing stands."""
    away = distance_to_walls(run.walls.stops_beams, run.walls.geometry.resolution)
    drawn_cells = world.geometry.centres_of(np.argwhere(world.is_wall))
    cells = run.walls.geometry.cells_of(drawn_cells)
    inside = run.walls.geometry.contains(cells)
    return int((~inside).sum() + (away[tuple(cells[inside].T)] > NEAR).sum())


def recall(run: Drive, world: OccupancyMap, sightings: int) -> float:
    """Share of the cells of walls seen so often that the map shows, to a cell."""
    reach = 1.5 * world.geometry.resolution
    away = distance_to_walls(world.is_wall, world.geometry.resolution)
    there = run.walls.geometry.centres_of(np.argwhere(run.sightings >= sightings))
    cells = world.geometry.cells_of(there)
    inside = world.geometry.contains(cells)
    return float((away[tuple(cells[inside].T)] <= reach).sum() / len(cells))


def test_people_who_walk_about_leave_hardly_a_cell() -> None:
    """A stream of scans, 10 Hz."""
    run = drive(every=1, seed=1)
    assert ghosts(run, plainly_drawn(run)) >= 30
    assert ghosts(run, drawn(run)) <= 8


@pytest.mark.parametrize("every", [1, 10], ids=["stream", "key scans"])
def test_walls_are_drawn_no_worse_for_that(every: int) -> None:
    run = drive(every, seed=1)
    once, often = (recall(run, drawn(run), sightings) for sightings in (1, 3))
    assert once > 0.9
    assert often > 0.96
    plain = plainly_drawn(run)
    assert once > recall(run, plain, 1) - 0.01
    assert often > recall(run, plain, 3)


def test_key_scans_leave_no_more_of_people_than_a_plain_grid() -> None:
    run = drive(every=10, seed=3)
    assert ghosts(run, drawn(run)) <= ghosts(run, plainly_drawn(run))
