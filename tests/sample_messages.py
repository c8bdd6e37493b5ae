"""Small valid messages for tests of what carries them."""

import numpy as np

from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.mapping import OccupancyGrid
from pilotage_schemas.sensors import Bumper, LaserScan, Odometry

HERE = Pose2(x=0.0, y=0.0, theta=0.0)
STILL = Twist2(vx=0.0, vy=0.0, omega=0.0)


def odometry(stamp_ns: int, x: float = 0.0) -> Odometry:
    """Odometry at `x` on the x axis."""
    return Odometry(
        stamp_ns=stamp_ns,
        frame_id="odom",
        pose=Pose2(x=x, y=0.0, theta=0.0),
        twist=STILL,
        covariance=np.eye(3),
    )


def bumper(stamp_ns: int, *, pressed: bool = True) -> Bumper:
    """A bumper event, which travels by never_drop."""
    return Bumper(stamp_ns=stamp_ns, frame_id="base_link", pressed=pressed)


def scan(stamp_ns: int, beams: int = 4) -> LaserScan:
    """A scan whose beams all measure one metre but for the first, which returns nothing."""
    ranges = np.ones(beams, np.float32)
    ranges[:1] = np.inf
    return LaserScan(
        stamp_ns=stamp_ns,
        frame_id="laser",
        angle_min=-1.0,
        angle_increment=0.1,
        range_min=0.1,
        range_max=8.0,
        ranges=ranges,
    )


def grid(stamp_ns: int, rows: int = 3, cols: int = 2) -> OccupancyGrid:
    """A free map of `rows` x `cols` cells whose first cell is occupied."""
    cells = np.zeros((rows, cols), np.int8)
    cells[0, 0] = 100
    return OccupancyGrid(
        stamp_ns=stamp_ns,
        frame_id="map",
        map_id="0123",
        name="hall",
        resolution=0.05,
        origin=HERE,
        cells=cells,
    )
