"""Walls followed through Wean Hall, from the doorway where both recorded runs begin.

The way is the one that `test_localize_wean` says how it was found. The hall's map is thirty years
old, drawn by hand in cells of 0.10 m, and shows jambs up to half a metre from where the laser sees
them: so far along the corridor the filter may be led.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from golden.test_localize_wean import ONE, THREE, Recorded, hall, thinned
from localizer_world import error
from pilotage.core import se2
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.logs import ScanRecord, read_log
from pilotage.core.scans import scan_points
from pilotage.localizer.ekf_localizer import EkfLocalizer
from pilotage.localizer.log_run import LogEstimate, LogSensors, localize_log

pytestmark = [pytest.mark.data, pytest.mark.timeout(120)]

BY_HAND = np.diag([0.25, 0.25, np.deg2rad(15.0) ** 2])
BOTH = pytest.mark.parametrize("recorded", [ONE, THREE], ids=["robotdata1", "robotdata3"])

Run = list[tuple[ScanRecord, LogEstimate, int]]


@pytest.fixture
def folder(data_dir: Path) -> Path:
    return data_dir / "wean_hall"


@cache
def run(folder: Path, recorded: Recorded, *, is_known: bool = True) -> Run:
    """All scans of a log, what was said after each, and how many pairs there were."""
    log = thinned(read_log(folder / recorded.name), 1 if is_known else 20, from_the_middle=False)
    localizer = EkfLocalizer(hall(folder))
    if is_known:
        localizer.start_at(recorded.way[0][1:], BY_HAND)
    told = localize_log(log, localizer, LogSensors())
    return [(s, e, len(localizer.matched)) for s, e in zip(log.scans, told, strict=True)]


def off_the_way(told: Run, recorded: Recorded) -> list[float]:
    """How far [m] the pose is from each waypoint when the robot is there."""
    begin = told[0][0].stamp
    away = []
    for time, *pose in recorded.way:
        _, estimate, _ = min(told, key=lambda row: abs(row[0].stamp - begin - time))
        away.append(error(estimate.pose, pose)[0])
    return away


@BOTH
def test_the_robot_is_followed_to_the_end(folder: Path, recorded: Recorded) -> None:
    away = off_the_way(run(folder, recorded), recorded)
    assert np.median(away) < 0.7
    assert max(away) < 2.0, "the next door is 6 m off"


@BOTH
def test_most_of_the_way_it_is_said_to_be_localized(folder: Path, recorded: Recorded) -> None:
    told = run(folder, recorded)
    assert np.mean([e.estimate.state == "localized" for _, e, _ in told]) > 0.8
    assert np.mean([count for _, _, count in told]) > 1.5


@BOTH
def test_scans_lie_on_the_walls_while_it_is(folder: Path, recorded: Recorded) -> None:
    world = hall(folder)
    distances = distance_to_walls(world.is_wall, world.geometry.resolution)
    medians = []
    for scan, told, _ in run(folder, recorded)[::5]:
        if told.estimate.state == "localized":
            ends = scan_points(scan.ranges, scan.angle_min, scan.angle_increment)
            ends = se2.transform_points(scan.laser_mount, ends)
            cells = world.geometry.cells_of(se2.transform_points(told.pose, ends))
            on_map = cells[world.geometry.contains(cells)]
            medians.append(np.median(distances[tuple(on_map.T)]))
    assert np.median(medians) < 0.15
    assert np.percentile(medians, 95) < 0.4


def test_from_an_unknown_start_nothing_is_claimed(folder: Path) -> None:
    told = run(folder, ONE, is_known=False)
    assert {e.estimate.state for _, e, _ in told} == {"unknown"}
    assert {count for _, _, count in told} == {0}
