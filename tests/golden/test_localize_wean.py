"""Two recorded runs through Wean Hall, from an unknown start.

There is no truth to compare with: what is judged is how the scans lie on the map, and whether
runs that begin at different points of a log end at the same place. The ends and shares are from
runs of November 2026, with room for what rounding does to a belief.
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
    """A log, every how many scans are used (so that a test is quick), and where it ends."""

    name: str
    every: int
    end: tuple[float, float, float]


ONE = Recorded("robotdata1.log.gz", 3, (39.75, 41.49, 1.29))
THREE = Recorded("robotdata3.log.gz", 5, (33.7, 40.5, -0.09))


LATEST_FIX = 40
"""Scans of the thinned logs before the first fix. The corridor repeats itself, and what fits as
well elsewhere is called ambiguous until the robot has seen more."""

NEAR = 0.2
"""An end within this distance [m] of a wall lies on it: two cells of the map."""


SHORT = pytest.mark.xfail(
    strict=True,
    reason="falls short: doors repeat every 6 m, and the room at the end has changed",
)
FIRST_SHORT = pytest.mark.parametrize(
    "recorded", [pytest.param(ONE, marks=SHORT), THREE], ids=["robotdata1", "robotdata3"]
)
THIRD_SHORT = pytest.mark.parametrize(
    "recorded", [ONE, pytest.param(THREE, marks=SHORT)], ids=["robotdata1", "robotdata3"]
)
BOTH_SHORT = pytest.mark.parametrize(
    "recorded",
    [pytest.param(ONE, marks=SHORT), pytest.param(THREE, marks=SHORT)],
    ids=["robotdata1", "robotdata3"],
)


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


@BOTH_SHORT
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
    away, turn = error(estimates[-1].pose, recorded.end)
    assert away < 0.4
    assert turn < 0.1


@THIRD_SHORT
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


@FIRST_SHORT
def test_a_run_that_begins_in_the_middle_ends_at_the_same_place(
    folder: Path, recorded: Recorded
) -> None:
    whole, half = run(folder, recorded), run(folder, recorded, from_the_middle=True)
    assert len(half) < 0.6 * len(whole)
    (_, one), (_, other) = whole[-1], half[-1]
    assert other.estimate.state == "localized"
    assert error(other.pose, one.pose)[0] < 0.25


@BOTH_SHORT
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


@pytest.mark.parametrize("recorded", [ONE, THREE], ids=["robotdata1", "robotdata3"])
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
