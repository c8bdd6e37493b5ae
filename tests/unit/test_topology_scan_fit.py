"""Whether a whole scan fits the map at a pose."""

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.raycast import cast_scan
from pilotage.topology.seeing.scan_fit import scan_fits
from pilotage.topology.seeing.scan_view import ScanView
from topology_bench import BEARINGS, FLAT, LASER, REACH

HERE = np.array([9.0, 3.0, -1.0])
"""In the lower room."""


def ranges_at(pose: np.ndarray) -> np.ndarray:
    return cast_scan(FLAT, se2.compose(pose, LASER), BEARINGS, REACH)


def view_of(ranges: np.ndarray) -> ScanView:
    angles = float(BEARINGS[0]), float(BEARINGS[1] - BEARINGS[0])
    return ScanView.of(ranges, angles, LASER)


def test_a_scan_fits_where_it_was_taken() -> None:
    assert scan_fits(FLAT, HERE, view_of(ranges_at(HERE)))


@pytest.mark.parametrize(
    "elsewhere", [(3.0, 7.0, 0.0), (9.0, 3.0, 1.0), (2.7, 10.5, -1.0), (7.0, 7.0, 3.1)]
)
def test_it_fits_nowhere_else(elsewhere: tuple[float, float, float]) -> None:
    assert not scan_fits(FLAT, np.array(elsewhere), view_of(ranges_at(HERE)))


def test_people_before_every_third_beam_are_no_reason_to_doubt() -> None:
    ranges = ranges_at(HERE)
    ranges[100:220] = np.minimum(ranges[100:220], 0.8)
    assert scan_fits(FLAT, HERE, view_of(ranges))


def test_beams_that_go_through_walls_are_a_reason_to_doubt() -> None:
    ranges = ranges_at(HERE)
    ranges[100:180] += 1.5
    assert not scan_fits(FLAT, HERE, view_of(ranges))


def test_beams_without_return_say_nothing() -> None:
    ranges = ranges_at(HERE)
    ranges[::2] = np.inf
    assert scan_fits(FLAT, HERE, view_of(ranges))
    assert not scan_fits(FLAT, HERE, view_of(np.full(len(ranges), np.inf)))


def test_off_the_map_nothing_fits() -> None:
    assert not scan_fits(FLAT, np.array([500.0, 500.0, 0.0]), view_of(ranges_at(HERE)))
