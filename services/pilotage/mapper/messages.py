"""Maps, poses and measurements as messages, and messages as what the mathematics takes."""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import CommandRecord, HeadingRecord, ScanRecord, SonarRecord
from pilotage.core.map_files import map_digest
from pilotage.core.odometry_watch import OdometrySample
from pilotage_schemas.arrays import LARGEST
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.localization import PoseEstimate
from pilotage_schemas.mapping import MappedPath, OccupancyGrid
from pilotage_schemas.planning import VelocityCommand
from pilotage_schemas.sensors import Heading, LaserScan, Odometry, SonarScan

PATH_STEP = 0.1
PATH_MOST = 5000
"""A path is shown at every 0.1 m; beyond so many poses, at fewer."""

SURE = 0.8
"""Confidence from which the robot counts as localized on the map that it makes."""


def pose_of(pose: NDArray[np.float64]) -> Pose2:
    """Return a pose (3,) as a message part."""
    x, y, theta = (float(value) for value in pose)
    return Pose2(x=x, y=y, theta=wrap(theta))


def pose_array(pose: Pose2) -> NDArray[np.float64]:
    """Return a message part as a pose (3,)."""
    return np.array([pose.x, pose.y, pose.theta])


def grid_message(
    world: OccupancyMap, name: str, stamp_ns: int, growing_id: str | None = None
) -> OccupancyGrid:
    """Return a map as a message; `name` is what people call it.

    A map in the making has no id of its content: it is given one, `growing_id`.
    """
    return OccupancyGrid(
        stamp_ns=stamp_ns,
        frame_id="map",
        map_id=growing_id or map_digest(world),
        name=name[:64],
        resolution=world.geometry.resolution,
        origin=pose_of(np.asarray(world.geometry.origin)),
        cells=world.cells,
        in_progress=growing_id is not None,
    )


def path_message(
    map_id: str, way: tuple[NDArray[np.float64], NDArray[np.float64]], stamp_ns: int
) -> MappedPath:
    """Return the way, stamps (n,) in s and poses (n, 3), that a map was made from, thinned."""
    stamps, poses = way
    kept = _thinned(poses)
    # A map may be gone on with whose stamps are of another clock than Unix time.
    ages = np.clip(stamp_ns / 1e9 - stamps[kept], -LARGEST, LARGEST)
    return MappedPath(
        stamp_ns=stamp_ns,
        frame_id="map",
        map_id=map_id,
        poses=poses[kept].astype(np.float32),
        ages=ages.astype(np.float32),
    )


def pose_message(
    pose: NDArray[np.float64], covariance: NDArray[np.float64] | None, stamp_ns: int
) -> PoseEstimate:
    """Return the pose (3,) on the map in the making; without a covariance nobody knows it yet."""
    spread = np.diag([1e3, 1e3, math.pi**2]) if covariance is None else covariance
    confidence = 0.0 if covariance is None else nearness(spread)
    return PoseEstimate(
        stamp_ns=stamp_ns,
        frame_id="map",
        pose=pose_of(pose),
        covariance=spread,
        state="localized" if confidence >= SURE else "unknown",
        confidence=confidence,
    )


def nearness(covariance: NDArray[np.float64]) -> float:
    """Return the probability of lying within 0.5 m and 15 degrees of the mean.

    Of a Gaussian (3, 3) over x, y, theta whose position is taken to be round, as wide as its
    widest direction: no more than the true probability. Position and heading count as
    independent.
    """
    widest = max(float(np.linalg.eigvalsh(covariance[:2, :2])[-1]), 1e-12)
    turn = math.sqrt(max(float(covariance[2, 2]), 1e-12))
    near = 1.0 - math.exp(-(0.5**2) / (2.0 * widest))
    return near * math.erf(math.radians(15.0) / (turn * math.sqrt(2.0)))


def odometry_sample(odometry: Odometry) -> OdometrySample:
    """Return an odometry message as the mathematics takes it."""
    return OdometrySample(odometry.seq, odometry.stamp_ns, pose_array(odometry.pose))


def scan_record(scan: LaserScan, base_from_laser: NDArray[np.float64]) -> ScanRecord:
    """Return a laser scan with the mount (3,) of its laser; odometry is added when it is due."""
    x, y, theta = base_from_laser.tolist()
    return ScanRecord(
        stamp=scan.stamp_ns / 1e9,
        ranges=scan.ranges,
        angle_min=scan.angle_min,
        angle_increment=scan.angle_increment,
        range_max=scan.range_max,
        odom_pose=None,
        laser_mount=(x, y, theta),
    )


def sonar_record(sonar: SonarScan) -> SonarRecord:
    """Return one round of a sonar ring."""
    return SonarRecord(
        stamp=sonar.stamp_ns / 1e9,
        ranges=sonar.ranges,
        mounts=sonar.mounts.astype(np.float64),
        cone=sonar.cone,
        range_max=sonar.range_max,
    )


def heading_record(heading: Heading) -> HeadingRecord:
    """Return what the compass says."""
    return HeadingRecord(heading.stamp_ns / 1e9, heading.yaw, heading.sigma)


def command_record(command: VelocityCommand) -> CommandRecord:
    """Return what the robot is told to do."""
    return CommandRecord(command.stamp_ns / 1e9, command.twist.vx, command.twist.omega)


def _thinned(poses: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return which of the poses lie at every 0.1 m of the way, and the last one."""
    if len(poses) == 0:
        return np.empty(0, np.int64)
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    spacing = max(PATH_STEP, float(way[-1]) / PATH_MOST)
    _, first = np.unique(np.floor(way / spacing), return_index=True)
    return np.union1d(first, [len(poses) - 1])
