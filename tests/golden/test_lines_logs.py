"""Walls in what real lasers measured: an office in Freiburg and a corridor of Wean Hall."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.corners import find_corners
from pilotage.core.line_extraction import extract_lines
from pilotage.core.lines import Lines
from pilotage.core.logs import Log, read_log
from pilotage.core.logs.records import ScanRecord
from pilotage.core.map_files import load_map
from pilotage.core.map_lines import map_lines

pytestmark = pytest.mark.data

FREIBURG, WEAN = "slam/fr079.clf.gz", "wean_hall/robotdata1.log.gz"


@cache
def recorded(file: Path) -> Log:
    """Return a log, read but once."""
    return read_log(file)


def lines_of(scan: ScanRecord) -> Lines:
    return extract_lines(scan.ranges, (scan.angle_min, scan.angle_increment))


def test_corridor_of_wean_hall_has_two_sides(data_dir: Path) -> None:
    """A scan along the corridor: five straight pieces, all along it, 2.5 m apart."""
    lines = lines_of(recorded(data_dir / WEAN).scans[450])
    assert len(lines) == 5
    assert sorted(lines.lengths)[-2:] == pytest.approx([3.1, 3.7], abs=0.1)
    off_along = np.abs(np.abs(lines.polar[:, 0]) - np.pi / 2.0)
    assert off_along.max() < 0.06
    left, right = lines.polar[:, 0] < 0.0, lines.polar[:, 0] > 0.0
    width = -lines.polar[left, 1].mean() - lines.polar[right, 1].mean()
    assert width == pytest.approx(2.5, abs=0.1)


def test_corridor_of_freiburg_has_its_walls_and_a_door_niche(data_dir: Path) -> None:
    lines = lines_of(recorded(data_dir / FREIBURG).scans[4000])
    assert 7 <= len(lines) <= 10
    assert sorted(lines.lengths)[-2:] == pytest.approx([2.0, 2.9], abs=0.15)
    assert len(find_corners(lines)) == 2


@pytest.mark.parametrize(
    ("name", "most", "longest"), [(FREIBURG, 14, (1.0, 2.5)), (WEAN, 10, (3.0, 4.5))]
)
def test_nearly_every_scan_has_a_few_walls(
    data_dir: Path, name: str, most: int, longest: tuple[float, float]
) -> None:
    found = [lines_of(scan) for scan in recorded(data_dir / name).scans[::20]]
    counts = np.array([len(lines) for lines in found])
    assert counts.max() <= most
    assert np.mean(counts >= 2) > 0.97
    median = np.median([lines.lengths.max(initial=0.0) for lines in found])
    assert longest[0] < median < longest[1]


@pytest.mark.parametrize(("name", "least"), [(FREIBURG, 0.8), (WEAN, 0.95)])
def test_long_walls_are_seen_again_in_the_next_scan(
    data_dir: Path, name: str, least: float
) -> None:
    """Walls of a metre and more lie, by odometry, where the scan before had them."""
    scans = recorded(data_dir / name).scans
    again = []
    for former, later in zip(scans[:-1:20], scans[1::20], strict=False):
        here, there = (
            se2.compose(scan.odom_pose or np.zeros(3), scan.laser_mount) for scan in (former, later)
        )
        next_lines = lines_of(later).moved(se2.between(here, there))
        before = lines_of(former)
        for alpha, rho in before.polar[before.lengths > 1.0]:
            turned = np.abs(wrap(next_lines.polar[:, 0] - alpha))
            pushed = np.abs(next_lines.polar[:, 1] - rho)
            again.append(bool(((turned < 0.05) & (pushed < 0.1)).any()))
    assert len(again) > 50
    assert np.mean(again) > least


@pytest.mark.parametrize(
    ("name", "lines", "metres"),
    [("gdc2", 950, 1000.0), ("hospital", 500, 910.0), ("thickwean", 95, 118.0)],
)
def test_map_has_the_known_faces(data_dir: Path, name: str, lines: int, metres: float) -> None:
    found = map_lines(load_map(data_dir / "maps" / f"{name}.yaml"))
    assert len(found) == pytest.approx(lines, rel=0.1)
    assert found.lengths.sum() == pytest.approx(metres, rel=0.05)


def test_long_side_of_thick_weans_corridor_is_one_wall(data_dir: Path) -> None:
    found = map_lines(load_map(data_dir / "maps" / "thickwean.yaml"))
    assert found.lengths.max() > 25.0


def test_walls_of_the_hospital_stand_square(data_dir: Path) -> None:
    """An architect drew it: three of four metres of wall lie along the axes."""
    found = map_lines(load_map(data_dir / "maps" / "hospital.yaml"))
    aside = np.abs(wrap(4.0 * found.polar[:, 0])) / 4.0
    assert found.lengths[aside < 0.03].sum() > 0.75 * found.lengths.sum()
