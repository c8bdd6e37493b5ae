"""Buildings drawn from key scans about 1 m apart, at the poses that another program found."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import read_log
from pilotage.mapper.laser_grid_scans import DrawnScan, drawn_scan, redraw

pytestmark = pytest.mark.data


@dataclass(frozen=True)
class Building:
    """A log, and what its map has at least: walls [m of cells] and free floor [m2]."""

    name: str
    scans: int
    walls: float
    floor: float
    ends_on_walls: float


BUILDINGS = [
    Building("aces", 440, 600.0, 780.0, 0.9),
    Building("seattle", 241, 300.0, 210.0, 0.9),
    Building("acapulco", 853, 1000.0, 4300.0, 0.75),
]


@cache
def scans_of(folder: Path, name: str) -> tuple[np.ndarray, list[DrawnScan]]:
    """Poses (n, 3) and scans of those stamps that the reference has."""
    by_stamp = {
        round(scan.stamp, 2): scan
        for scan in read_log(folder / "slam" / f"{name}.clf.gz").scans
        if np.isfinite(scan.ranges).any()
    }
    rows = np.loadtxt(folder / "slam" / f"{name}.reference.txt")
    known = [row for row in rows if round(row[0], 2) in by_stamp]
    return np.array(known)[:, 1:], [drawn_scan(by_stamp[round(row[0], 2)]) for row in known]


@pytest.mark.parametrize("building", BUILDINGS, ids=lambda building: building.name)
def test_a_building_is_drawn_whole_and_sharp(data_dir: Path, building: Building) -> None:
    poses, scans = scans_of(data_dir, building.name)
    assert len(scans) >= building.scans
    world = redraw(poses, scans).map()
    size = world.geometry.resolution
    assert world.is_wall.sum() * size > building.walls
    assert world.is_free.sum() * size**2 > building.floor
    assert on_walls(world, poses, scans) > building.ends_on_walls


def on_walls(world: OccupancyMap, poses: np.ndarray, scans: list[DrawnScan]) -> float:
    """Share of all beams that end on a wall of the map, or in a cell beside one."""
    away = distance_to_walls(world.is_wall, world.geometry.resolution)
    ends = np.vstack(
        [se2.transform_points(pose, scan.ends) for pose, scan in zip(poses, scans, strict=True)]
    )
    cells = world.geometry.cells_of(ends)
    return float((away[tuple(cells.T)] < 1.5 * world.geometry.resolution).mean())


def test_a_mirrored_building_has_the_mirrored_map(data_dir: Path) -> None:
    """All walls and floors, but for ends that lie on a border between cells."""
    poses, scans = scans_of(data_dir, "seattle")
    mirror = np.array([1.0, -1.0])
    mirrored = [
        DrawnScan(scan.stamp, scan.laser * mirror, scan.ends * mirror, scan.is_hit)
        for scan in scans
    ]
    here = redraw(poses, scans).map()
    there = redraw(poses * [1.0, -1.0, -1.0], mirrored).map()
    assert (there.is_wall.sum(), there.is_free.sum()) == pytest.approx(
        (here.is_wall.sum(), here.is_free.sum()), rel=1e-3
    )
