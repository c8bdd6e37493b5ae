"""Rooms to map: what a laser sees in them, and ways through them with odometry that errs."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from drawing import draw
from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.logs import OdometryRecord, Pose, Record, ScanRecord, TruthRecord
from pilotage.core.motion import OdometryNoise, sample_odometry
from pilotage.core.raycast import cast_scan
from pilotage.mapper.laser_grid_scans import DrawnScan
from pilotage.mapper.laser_slam import LaserSlam

LOOP = """
    ########################
    #......#.......#.......#
    #......#.......#.......#
    #......#.......#.......#
    ###..#####..#####..###.#
    #......................#
    #......................#
    #...##########.....##..#
    #...#........#.....##..#
    #...#........#.........#
    #...#........###..###..#
    #...#........#......#..#
    #...#........#......#..#
    #...##########......#..#
    #...........########...#
    #......................#
    #.....##...............#
    ########################
    """
"""A corridor round a block, with rooms; a mark is 0.6 m."""

ROUND = [(1.5, 7.2), (1.5, 1.7), (6.2, 1.8), (7.0, 1.2), (13.2, 1.2), (13.2, 7.2)]
"""Corners of the way round LOOP, m."""

MARK, CELL = 6, 0.1
BEAMS, REACH = 180, 12.0
BEARINGS = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
PERIOD, STEP, TURN = 0.2, 0.15, 0.3
"""s between scans; m and rad that the robot moves meanwhile at most."""


def building(picture: str = LOOP, mark: int = MARK) -> OccupancyMap:
    """The drawn place, each mark `mark` cells of CELL."""
    plan = draw(picture)
    cells = np.kron(plan.cells, np.ones((mark, mark), np.int8))
    rows, cols = cells.shape
    return OccupancyMap(GridGeometry(rows, cols, CELL), cells)


def points_at(
    world: OccupancyMap,
    pose: ArrayLike,
    rng: np.random.Generator | None = None,
    bearings: np.ndarray = BEARINGS,
) -> np.ndarray:
    """The points (n, 2) that a laser at a pose sees, in its frame; with noise of 1 cm if random."""
    ranges = cast_scan(world, pose, bearings, REACH)
    if rng is not None:
        ranges = ranges + 0.01 * rng.standard_normal(len(ranges))
    seen = np.isfinite(ranges)
    return np.stack([np.cos(bearings), np.sin(bearings)], axis=1)[seen] * ranges[seen, None]


def drawn_at(
    world: OccupancyMap, pose: ArrayLike, stamp: float = 0.0, bearings: np.ndarray = BEARINGS
) -> DrawnScan:
    """The same as a scan to keep."""
    points = points_at(world, pose, None, bearings)
    return DrawnScan(stamp, np.zeros(2), points, np.ones(len(points), bool))


def way_along(corners: Sequence[tuple[float, float]]) -> np.ndarray:
    """Poses (n, 3) of a robot that drives from corner to corner and turns on the spot there."""
    first, second = corners[0], corners[1]
    heading = math.atan2(second[1] - first[1], second[0] - first[0])
    poses = [np.array([*first, heading])]
    for corner in corners[1:]:
        gap = np.array(corner) - poses[-1][:2]
        turn = wrap(math.atan2(gap[1], gap[0]) - poses[-1][2])
        turns = math.ceil(abs(turn) / TURN)
        poses += [se2.compose(poses[-1], (0.0, 0.0, turn * k / turns)) for k in range(1, turns + 1)]
        steps = math.ceil(math.hypot(*gap) / STEP)
        length = math.hypot(*gap) / steps
        begin = poses[-1]
        poses += [se2.compose(begin, (k * length, 0.0, 0.0)) for k in range(1, steps + 1)]
    return np.array(poses)


def times(count: int, corners: Sequence[tuple[float, float]] = ROUND) -> list[tuple[float, float]]:
    """The corners of a round driven so many times, and back where it began."""
    return [*list(corners) * count, corners[0]]


@dataclass(frozen=True)
class Drive:
    """`truth` (n, 3) at the scans, and all `records` of it, odometry twice as often as scans."""

    truth: np.ndarray
    records: list[Record]

    @property
    def scans(self) -> list[ScanRecord]:
        """Its scans."""
        return [record for record in self.records if isinstance(record, ScanRecord)]


def drive(
    world: OccupancyMap,
    truth: np.ndarray,
    seed: int = 0,
    *,
    noise: float = 1.0,
    carried: dict[int, Pose] | None = None,
    beams: int = BEAMS,
) -> Drive:
    """Drive along poses; before scan k somebody moves the robot by `carried[k]`, which
    odometry does not notice."""
    rng = np.random.default_rng(seed)
    alphas = OdometryNoise(**{name: noise**2 * v for name, v in vars(OdometryNoise()).items()})
    bearings = np.linspace(-math.pi, math.pi, beams, endpoint=False)
    odom, records = np.zeros(3), list[Record]()
    for k, pose in enumerate(truth):
        stamp = 100.0 + PERIOD * k
        if k > 0:
            before = odom
            lift = (carried or {}).get(k, (0.0, 0.0, 0.0))
            moved = se2.between(se2.compose(truth[k - 1], lift), pose)
            odom = sample_odometry(odom[None], moved, alphas, rng)[0]
            half = se2.interpolate(before, odom, 0.5)
            records.append(OdometryRecord(stamp - 0.5 * PERIOD, as_pose(half)))
        records.append(OdometryRecord(stamp, as_pose(odom)))
        records.append(TruthRecord(stamp, as_pose(pose)))
        ranges = cast_scan(world, pose, bearings, REACH) + 0.01 * rng.standard_normal(beams)
        records.append(scan_record(stamp, ranges, odom))
    return Drive(truth, records)


def scan_record(stamp: float, ranges: np.ndarray, odom: np.ndarray) -> ScanRecord:
    """A scan all round, as a log has it."""
    return ScanRecord(
        stamp=stamp,
        ranges=ranges.astype(np.float32),
        angle_min=-math.pi,
        angle_increment=math.tau / len(ranges) if len(ranges) else 1.0,
        range_max=REACH,
        odom_pose=as_pose(odom),
        laser_mount=(0.0, 0.0, 0.0),
    )


def feed(slam: LaserSlam, records: Iterable[Record]) -> Iterator[np.ndarray]:
    """Yield where the robot is taken to be after each scan that was of use."""
    for record in records:
        step = slam.process(record)
        if step is not None:
            yield step.map_from_base


def mapped(records: Iterable[Record]) -> LaserSlam:
    """The method after all of it, loops closed."""
    slam = LaserSlam()
    for record in records:
        slam.process(record)
    slam.settle()
    return slam


def errors(slam: LaserSlam, drive: Drive) -> np.ndarray:
    """How far (n,) in m the poses at the scans are from the truth, laid over the first one."""
    stamps, poses = slam.trajectory()
    at = np.searchsorted(stamps, [scan.stamp for scan in drive.scans])
    return apart(poses[at], drive.truth)


def odometry_errors(drive: Drive) -> np.ndarray:
    """The same of odometry alone."""
    return apart(np.array([scan.odom_pose for scan in drive.scans]), drive.truth)


def apart(poses: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Distances (n,) in m of poses from the truth, both seen from the first of them."""
    off = se2.between(poses[0], poses)[:, :2] - se2.between(truth[0], truth)[:, :2]
    distances: np.ndarray = np.hypot(off[:, 0], off[:, 1])
    return distances


def as_pose(pose: ArrayLike) -> Pose:
    """A pose as records have it."""
    x, y, theta = np.asarray(pose, float).tolist()
    return x, y, theta
