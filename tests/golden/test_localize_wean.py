"""Two recorded runs through Wean Hall, from an unknown start.

Nobody measured the truth. But of all ways that odometry allows, from six thousand places in the
middle of a log forwards to its end and backwards to its beginning, one fits all scans better than
any other, and for both logs it begins in the same doorway: those are the waypoints below. Its
rivals are one, two and three doors farther along the corridor (6 m each) and fit nearly as well,
but begin inside walls.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from localizer_world import error
from pilotage.core import se2
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import Log, ScanRecord, read_log
from pilotage.core.map_files import load_map
from pilotage.core.scans import scan_points
from pilotage.localizer.log_run import LogEstimate, LogSensors, localize_log
from pilotage.localizer.markov_localizer import MarkovLocalizer, MarkovParams

pytestmark = [pytest.mark.data, pytest.mark.timeout(180)]


@dataclass(frozen=True)
class Recorded:
    """A log, every how many scans are used (so that a test is quick), and where it goes.

    `way`: time from the first scan [s], x, y [m] and heading [rad] in the map.
    """

    name: str
    every: int
    way: tuple[tuple[float, float, float, float], ...]


ONE = Recorded(
    "robotdata1.log.gz",
    3,
    (
        (0.0, 40.0, 41.5, -1.7),
        (10.6, 40.5, 40.1, -0.3),
        (21.0, 44.5, 39.6, -0.1),
        (31.4, 48.5, 39.2, -0.1),
        (41.9, 51.6, 39.3, 2.1),
        (52.5, 49.2, 38.9, -3.0),
        (63.0, 45.7, 38.8, 3.1),
        (73.4, 41.5, 39.2, 2.8),
        (84.6, 38.3, 39.9, 3.0),
        (95.1, 33.9, 40.3, 2.8),
        (105.7, 32.5, 40.7, -1.8),
        (116.2, 35.2, 40.5, 0.1),
        (126.6, 38.6, 40.0, -0.1),
        (134.8, 39.7, 41.1, 1.3),
    ),
)
THREE = Recorded(
    "robotdata3.log.gz",
    5,
    (
        (0.0, 40.0, 41.6, -1.7),
        (10.6, 41.4, 39.6, -0.1),
        (21.3, 42.8, 39.9, -1.7),
        (32.0, 46.3, 39.4, -0.2),
        (42.6, 46.4, 39.7, -3.1),
        (53.3, 42.1, 39.5, 3.1),
        (64.0, 37.9, 40.1, 2.9),
        (74.7, 35.9, 40.1, 0.9),
        (85.4, 33.1, 40.3, 2.8),
        (96.0, 29.4, 41.0, -2.8),
        (106.7, 31.3, 40.8, 0.0),
        (117.4, 35.4, 40.1, 0.0),
        (128.1, 39.5, 39.7, 0.0),
        (132.3, 40.0, 39.7, 0.0),
    ),
)

OFF_THE_WAY = 1.5
"""Farther from the way [m] a fix is wrong: odometry leads on from waypoints that are 10 s apart,
and it slips; the next door is 6 m off."""


LATEST_FIX = 40
"""Scans of the thinned logs before the first fix. The corridor repeats itself, and what fits as
well elsewhere is called ambiguous until the robot has seen more."""

NEAR = 0.2
"""An end within this distance [m] of a wall lies on it: two cells of the map."""


SHORT = pytest.mark.xfail(
    strict=True,
    reason="falls short: doors repeat every 6 m, and some are shut now that the map shows open",
)
BOTH = pytest.mark.parametrize("recorded", [ONE, THREE], ids=["robotdata1", "robotdata3"])


@cache
def hall(folder: Path) -> OccupancyMap:
    return load_map(folder / "wean.dat.gz")


def thinned(log: Log, every: int, *, from_the_middle: bool) -> Log:
    """The log with one scan of `every`, all of it or its second half."""
    begin = log.records[len(log.records) // 2].stamp if from_the_middle else log.records[0].stamp
    kept = {id(scan) for scan in log.scans[::every]}
    records = tuple(
        record
        for record in log.records
        if record.stamp >= begin and (not isinstance(record, ScanRecord) or id(record) in kept)
    )
    return Log(log.format, records, log.skipped_lines)


@cache
def run(
    folder: Path, recorded: Recorded, *, from_the_middle: bool = False
) -> list[tuple[ScanRecord, LogEstimate]]:
    log = thinned(read_log(folder / recorded.name), recorded.every, from_the_middle=from_the_middle)
    localizer = MarkovLocalizer(hall(folder), MarkovParams())
    estimates = localize_log(log, localizer, LogSensors())
    return list(zip(log.scans, estimates, strict=True))


@pytest.fixture
def folder(data_dir: Path) -> Path:
    return data_dir / "wean_hall"


@SHORT
@BOTH
def test_the_robot_is_found_followed_and_stands_in_free_space(
    folder: Path, recorded: Recorded
) -> None:
    estimates = [estimate for _, estimate in run(folder, recorded)]
    is_localized = [e.estimate.state == "localized" for e in estimates]
    assert is_localized[-1]
    first = is_localized.index(True)
    assert first <= LATEST_FIX
    assert np.mean(is_localized[first:]) > 0.6
    poses = np.array([e.pose for e in estimates])[is_localized]
    rows, cols = hall(folder).geometry.cells_of(poses[:, :2]).T
    assert hall(folder).is_free[rows, cols].all()
    away, turn = error(estimates[-1].pose, recorded.way[-1][1:])
    assert away < 0.4
    assert turn < 0.1


def off_the_way(folder: Path, recorded: Recorded, *, from_the_middle: bool) -> list[float]:
    """How far [m] each fix lies from where odometry leads from the waypoint next in time."""
    scans = read_log(folder / recorded.name).scans
    stamps = np.array([scan.stamp - scans[0].stamp for scan in scans])
    times = np.array([point[0] for point in recorded.way])
    away = []
    for scan, estimate in run(folder, recorded, from_the_middle=from_the_middle):
        if estimate.estimate.state == "localized":
            near = int(np.argmin(np.abs(times - (scan.stamp - scans[0].stamp))))
            there = scans[int(np.argmin(np.abs(stamps - times[near])))]
            assert there.odom_pose is not None
            assert scan.odom_pose is not None
            moved = se2.between(there.odom_pose, scan.odom_pose)
            expected = se2.compose(recorded.way[near][1:], moved)
            away.append(error(estimate.pose, expected)[0])
    return away


@BOTH
def test_what_is_called_localized_is_right(folder: Path, recorded: Recorded) -> None:
    """From the beginning and from the middle, where nothing tells the doors apart."""
    whole = off_the_way(folder, recorded, from_the_middle=False)
    half = off_the_way(folder, recorded, from_the_middle=True)
    assert len(whole) > 50
    assert max(whole + half) < OFF_THE_WAY


@BOTH
def test_scans_lie_on_the_walls_once_the_robot_is_localized(
    folder: Path, recorded: Recorded
) -> None:
    world = hall(folder)
    distances = distance_to_walls(world.is_wall, world.geometry.resolution)
    medians, matched = [], []
    for scan, e in run(folder, recorded):
        if e.estimate.state == "localized":
            ends = scan_points(scan.ranges, scan.angle_min, scan.angle_increment)
            ends = se2.transform_points(scan.laser_mount, ends)
            cells = world.geometry.cells_of(se2.transform_points(e.pose, ends))
            on_map = cells[world.geometry.contains(cells)]
            distance = distances[tuple(on_map.T)]
            medians.append(np.median(distance))
            matched.append(np.mean(distance <= NEAR))
    assert np.median(medians) <= 0.05
    assert max(medians) <= 0.15
    assert np.mean(matched) >= 0.85


@SHORT
@BOTH
def test_a_run_that_begins_in_the_middle_ends_at_the_same_place(
    folder: Path, recorded: Recorded
) -> None:
    whole, half = run(folder, recorded), run(folder, recorded, from_the_middle=True)
    assert len(half) < 0.6 * len(whole)
    (_, one), (_, other) = whole[-1], half[-1]
    assert other.estimate.state == "localized"
    assert error(other.pose, one.pose)[0] < 0.25


@SHORT
@BOTH
def test_runs_agree_wherever_both_say_that_they_are_localized(
    folder: Path, recorded: Recorded
) -> None:
    whole, half = run(folder, recorded), run(folder, recorded, from_the_middle=True)
    away = [
        error(other.pose, one.pose)[0]
        for (_, one), (_, other) in zip(whole[-len(half) :], half, strict=True)
        if one.estimate.state == other.estimate.state == "localized"
    ]
    assert len(away) > 20
    assert max(away) < 0.25


@BOTH
def test_from_fix_to_fix_the_robot_goes_where_odometry_says(
    folder: Path, recorded: Recorded
) -> None:
    """One of two fixes that do not follow from each other was wrong."""
    fixes = [(s, e) for s, e in run(folder, recorded) if e.estimate.state == "localized"]
    for (scan, estimate), (next_scan, next_estimate) in pairwise(fixes):
        assert scan.odom_pose is not None
        assert next_scan.odom_pose is not None
        moved = se2.between(scan.odom_pose, next_scan.odom_pose)
        expected = se2.compose(estimate.pose, moved)
        assert error(next_estimate.pose, expected)[0] < 1.0 + 0.1 * np.hypot(moved[0], moved[1])
