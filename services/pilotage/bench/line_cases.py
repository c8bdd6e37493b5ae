"""Lines: the walls in a scan of 361 beams, and those of a map."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pilotage.bench.building_cases import OFFICE_CORRIDOR
from pilotage.bench.entry import Entry, Size, Stopwatch
from pilotage.bench.reference_lines import plain_lines
from pilotage.core.grid import OccupancyMap
from pilotage.core.line_extraction import LineParams, extract_lines
from pilotage.core.raycast import cast_scan
from pilotage.robot.simulator.floor_plans import office_floor

BEAMS, VIEW, REACH, SIGMA = 361, np.pi, 30.0, 0.01
"""A laser as on the robots of the recorded logs: beams, rad, m, m."""

SCANS = 50


def line_cases(watch: Stopwatch) -> Iterator[Entry]:
    """Yield finding the walls in one scan, taken in the corridor of the office."""
    angles = -VIEW / 2.0, VIEW / (BEAMS - 1)
    scans = corridor_scans(office_floor())
    found = [len(extract_lines(scan, angles)) for scan in scans]

    def all_scans() -> None:
        for scan in scans:
            extract_lines(scan, angles)

    def plainly() -> None:
        for scan in scans:
            plain_lines(scan, angles, LineParams())

    yield Entry(
        "office: the walls in a scan",
        Size(round(float(np.mean(found))), BEAMS, "lines"),
        watch.median_ms(all_scans, 5) / SCANS,
        watch.median_ms(plainly, 1) / SCANS,
        1.0,
    )


def corridor_scans(world: OccupancyMap) -> list[NDArray[np.float64]]:
    """Return the ranges (361,) that a laser measures along the corridor, looking all about."""
    low, high, y = OFFICE_CORRIDOR
    rng = np.random.default_rng(5)
    bearings = np.linspace(-VIEW / 2.0, VIEW / 2.0, BEAMS)
    poses = np.column_stack(
        [np.linspace(low, high, SCANS), np.full(SCANS, y), rng.uniform(-np.pi, np.pi, SCANS)]
    )
    scans = [cast_scan(world, pose, bearings, REACH) for pose in poses]
    return [scan + SIGMA * rng.standard_normal(BEAMS) for scan in scans]
