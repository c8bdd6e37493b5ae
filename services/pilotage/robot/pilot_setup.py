"""The pilot that fits a robot: from settings and description, and its view from a scan."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.laser_view import View
from pilotage.robot.config import RobotSettings
from pilotage.robot.pilot import Pilot
from pilotage.robot.wander import Wanderer, WanderParams
from pilotage.robot.watchdog import CommandWatch, Limits, SensorWatch
from pilotage_schemas.sensors import LaserScan, RobotDescription
from pilotage_schemas.topics import TOPICS


def make_pilot(settings: RobotSettings, description: RobotDescription) -> Pilot:
    """Return the pilot of a robot, within the limits of the settings and of the robot."""
    has_laser = laser_mount(description) is not None
    relied_on = ("odometry", "scan") if has_laser else ("odometry",)
    radius = float(np.hypot(*description.footprint.T).max(initial=0.0))
    params = WanderParams(radius=radius)
    rng = np.random.default_rng(settings.seed)
    return Pilot(
        limits=Limits(
            linear=min(settings.max_linear, description.max_linear),
            angular=min(settings.max_angular, description.max_angular),
            acceleration=settings.acceleration,
        ),
        sensors=SensorWatch({name: TOPICS[name].stale_after or 1.0 for name in relied_on}),
        relied_on=relied_on,
        wanderer=Wanderer(params, rng) if has_laser else None,
        commands=CommandWatch(settings.command_timeout),
    )


def laser_mount(description: RobotDescription) -> NDArray[np.float64] | None:
    """Return the pose (3,) of the laser in base_link, None without one."""
    for mount in description.mounts:
        if mount.kind == "laser":
            return np.array([mount.pose.x, mount.pose.y, mount.pose.theta])
    return None


def view_of(scan: LaserScan, mount: NDArray[np.float64]) -> View:
    """Return a scan as the wanderer sees it, from a laser at `mount` (3,)."""
    bearings = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    return View.of(scan.ranges, bearings, mount)
