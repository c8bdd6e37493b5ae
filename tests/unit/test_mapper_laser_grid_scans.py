import math

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.logs import ScanRecord
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_params import LaserGridParams
from pilotage.mapper.laser_grid_scans import DrawnScan, draw, drawn_scan, redraw


def record(*ranges: float, stamp: float = 1.0) -> ScanRecord:
    """Beams to the right, ahead and to the left; the laser is 0.5 m ahead, turned to the left."""
    return ScanRecord(
        stamp=stamp,
        ranges=np.array(ranges, np.float32),
        angle_min=-math.pi / 2,
        angle_increment=math.pi / 2,
        range_max=8.0,
        odom_pose=None,
        laser_mount=(0.5, 0.0, math.pi / 2),
    )


def test_ends_are_those_of_the_beams_seen_from_the_robot() -> None:
    scan = drawn_scan(record(1.0, 2.0, 3.0))
    assert scan.laser == pytest.approx([0.5, 0.0])
    assert scan.ends == pytest.approx(np.array([[1.5, 0.0], [0.5, 2.0], [-2.5, 0.0]]), abs=1e-6)
    assert scan.is_hit.all()
    assert scan.stamp == 1.0


def test_what_did_not_come_back_is_left_out() -> None:
    scan = drawn_scan(record(math.inf, math.nan, 0.0))
    assert len(scan.ends) == 0


def test_beams_without_a_return_clear_as_far_as_is_asked() -> None:
    scan = drawn_scan(record(math.inf, 2.0, -math.inf), clearing_range=4.0)
    assert scan.ends == pytest.approx(np.array([[4.5, 0.0], [0.5, 2.0]]), abs=1e-6)
    assert scan.is_hit.tolist() == [False, True]


def test_a_scan_is_drawn_where_the_robot_was() -> None:
    pose = np.array([3.0, -2.0, 0.7])
    grid, same = LaserGrid(), LaserGrid()
    scan = drawn_scan(record(1.0, 2.0, 3.0))
    draw(grid, pose, scan)
    laser = se2.transform_points(pose, scan.laser[None])[0]
    same.insert(laser, se2.transform_points(pose, scan.ends), scan.is_hit, scan.stamp)
    assert np.array_equal(grid.log_odds(), same.log_odds(), equal_nan=True)


def test_a_map_drawn_again_is_the_map_drawn_at_first() -> None:
    rng = np.random.default_rng(4)
    scans = [drawn_scan(record(*rng.uniform(1.0, 6.0, 3), stamp=0.3 * k)) for k in range(40)]
    poses = np.cumsum(rng.normal(0.0, 0.1, (40, 3)), axis=0)
    params = LaserGridParams(resolution=0.1)
    grid = LaserGrid(params)
    for pose, scan in zip(poses, scans, strict=True):
        draw(grid, pose, scan)
    again = redraw(poses, scans, params)
    assert again.map().geometry == grid.map().geometry
    assert (again.map().cells == grid.map().cells).all()
    assert again.map().is_wall.any()


def test_every_scan_needs_a_pose() -> None:
    nothing = DrawnScan(None, np.zeros(2), np.empty((0, 2)), np.empty(0, bool))
    with pytest.raises(ValueError, match="zip"):
        redraw(np.zeros((2, 3)), [nothing])
