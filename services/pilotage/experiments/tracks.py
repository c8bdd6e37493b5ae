"""Simulated tracks through buildings: where a robot was, what it counted and what it saw."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.jit import kernel
from pilotage.core.logs import Log, Record, ScanRecord, TruthRecord
from pilotage.core.motion import OdometryNoise, sample_odometry
from pilotage.experiments.clutter import Condition
from pilotage.robot.simulator.people import People
from pilotage.robot.simulator.range_sensors import LaserParams, Surroundings, scan
from pilotage.robot.simulator.walls import Walls

STRIDE = 0.3
"""Way between two scans [m]."""

SHARPEST_TURN = 0.5
"""Most turn between two scans [rad]."""

PERIOD = 0.5
"""Time between two scans [s]."""

BODY = 0.22
"""Radius of the robot [m]."""

AHEAD = 0.4
"""Way [m] to the point of the path that is steered for."""


@dataclass(frozen=True)
class Track:
    """A run of n scans: `truth` (n, 3) in map, `odometry` (n, 3) in odom, `ranges` (n, beams).

    `kidnapped`: index of the first scan after the robot was carried off, if it was.
    """

    truth: NDArray[np.float64]
    odometry: NDArray[np.float64]
    ranges: NDArray[np.float32]
    laser: LaserParams
    kidnapped: int | None = None

    def log(self) -> Log:
        """Return the run as a recorded log would show it."""
        records: list[Record] = []
        step = self.laser.bearings[1] - self.laser.bearings[0]
        for index, (truth, odom, ranges) in enumerate(
            zip(self.truth, self.odometry, self.ranges, strict=True)
        ):
            stamp = 1.0 + index * PERIOD
            records.append(TruthRecord(stamp, _pose(truth)))
            records.append(
                ScanRecord(
                    stamp=stamp,
                    ranges=ranges,
                    angle_min=float(self.laser.bearings[0]),
                    angle_increment=float(step),
                    range_max=self.laser.range_max,
                    odom_pose=_pose(odom),
                    laser_mount=(self.laser.mount_x, 0.0, 0.0),
                )
            )
        return Log(records=tuple(records), format="simulated", skipped_lines=0)


def drive_through(
    walls: Walls, condition: Condition, lengths: tuple[int, ...], rng: np.random.Generator
) -> Track:
    """Return a track of sum(lengths) scans; between its parts the robot is carried off.

    Args:
        walls: what really stands in the building.
        condition: people, outliers, odometry noise, laser.
        lengths: scans of each part; two parts are one kidnapping.
        rng: of everything.
    """
    people = People(walls, condition.people, rng)
    truth = np.concatenate([_walk(walls, count, rng) for count in lengths])
    starts = set(np.cumsum(lengths)[:-1].tolist())
    odometry = _counted(truth, starts, condition.odometry, rng)
    ranges = np.empty((len(truth), condition.laser.beams), np.float32)
    for index, pose in enumerate(truth):
        around = Surroundings(walls, people.discs)
        ranges[index] = _with_outliers(scan(around, pose, condition.laser, rng), condition, rng)
        people.walk(pose, PERIOD, rng)
    kidnapped = lengths[0] if len(lengths) > 1 else None
    return Track(truth, odometry, ranges, condition.laser, kidnapped)


def _with_outliers(
    ranges: NDArray[np.float32], condition: Condition, rng: np.random.Generator
) -> NDArray[np.float32]:
    wrong = rng.random(len(ranges)) < condition.outliers
    anything = rng.uniform(condition.laser.range_min, condition.laser.range_max, len(ranges))
    return np.where(wrong, anything, ranges).astype(np.float32)


def _counted(
    truth: NDArray[np.float64], starts: set[int], factor: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return what odometry says; it does not notice that it is carried off at `starts`."""
    usual = vars(OdometryNoise())
    noise = OdometryNoise(**{name: value * factor**2 for name, value in usual.items()})
    odometry = [np.zeros(3)]
    for index in range(1, len(truth)):
        carried = index in starts
        moved = np.zeros(3) if carried else se2.between(truth[index - 1], truth[index])
        odometry.append(sample_odometry(odometry[-1][None], moved, noise, rng)[0])
    return np.array(odometry)


def _walk(walls: Walls, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return poses (count, 3) of a robot that goes to one random place after the other."""
    places = walls.places(BODY + 0.08)
    pose = np.array([*places[rng.integers(len(places))], rng.uniform(-np.pi, np.pi)])
    poses: list[NDArray[np.float64]] = [pose]
    while len(poses) < count:
        goal = places[rng.integers(len(places))]
        for following in _follow(poses[-1], _path(walls, poses[-1][:2], goal)):
            poses.append(following)
            if len(poses) == count:
                break
    return np.array(poses[:count])


def _follow(pose: NDArray[np.float64], path: NDArray[np.float64]) -> Iterator[NDArray[np.float64]]:
    """Yield the poses of a robot that drives along points (n, 2), one per scan."""
    at = 0
    while at < len(path) - 1:
        near = np.hypot(*(path[at:] - pose[:2]).T)
        beyond = np.nonzero(near > AHEAD)[0]
        at = at + int(beyond[0]) if len(beyond) else len(path) - 1
        while np.hypot(*(path[at] - pose[:2])) > STRIDE / 2.0:
            bearing = float(np.arctan2(*(path[at] - pose[:2])[::-1]))
            error = wrap(bearing - pose[2])
            turn = float(np.clip(error, -SHARPEST_TURN, SHARPEST_TURN))
            distance = float(np.hypot(*(path[at] - pose[:2])))
            way = min(STRIDE, distance) if abs(error) < SHARPEST_TURN else 0.0
            heading = pose[2] + turn
            step = way * np.array([np.cos(heading), np.sin(heading)])
            pose = np.array([*(pose[:2] + step), wrap(heading)])
            yield pose


def _path(
    walls: Walls, start: NDArray[np.float64], goal: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return points (n, 2) from start to goal, as short as steps from cell to cell can be."""
    half_diagonal = walls.geometry.resolution * np.sqrt(0.5)
    passable = walls.clearance >= BODY + half_diagonal
    cells = walls.geometry.cells_of(np.array([start, goal]))
    passable[tuple(cells[0])] = True
    steps = _steps_to(passable, cells[1])
    return walls.geometry.centres_of(_descend(steps, cells[0]))


@kernel
def _steps_to(passable: NDArray[np.bool_], goal: NDArray[np.int64]) -> NDArray[np.int32]:
    """Return the number of steps (rows, cols) to the goal, -1 where it cannot be reached."""
    rows, cols = passable.shape
    steps = np.full((rows, cols), -1, np.int32)
    queue = np.empty((rows * cols, 2), np.int32)
    queue[0, 0], queue[0, 1] = goal[0], goal[1]
    steps[goal[0], goal[1]] = 0
    first, last = 0, 1
    while first < last:
        row, col = queue[first]
        first += 1
        for dr, dc in ((0, 1), (1, 0), (0, -1), (-1, 0)):
            r, c = row + dr, col + dc
            inside = 0 <= r < rows and 0 <= c < cols
            if inside and passable[r, c] and steps[r, c] < 0:
                steps[r, c] = steps[row, col] + 1
                queue[last, 0], queue[last, 1] = r, c
                last += 1
    return steps


@kernel
def _descend(steps: NDArray[np.int32], start: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the cells (n, 2) from the start to the goal, straight on and across corners."""
    rows, cols = steps.shape
    cells = np.empty((rows * cols, 2), np.int64)
    row, col = start
    count = 0
    while True:
        cells[count, 0], cells[count, 1] = row, col
        count += 1
        best, next_row, next_col = steps[row, col], row, col
        for dr in (-1, 0, 1):
            for dc in (-1, 0, 1):
                r, c = row + dr, col + dc
                if 0 <= r < rows and 0 <= c < cols and 0 <= steps[r, c] < best:
                    best, next_row, next_col = steps[r, c], r, c
        if best == steps[row, col]:
            return cells[:count].copy()
        row, col = next_row, next_col


def _pose(pose: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(pose[0]), float(pose[1]), float(pose[2])
