import math

import numpy as np
import pytest

from pilotage.core.scans import bearings_of, pick_beams, scan_points

RANGES = np.array([1.0, np.inf, 2.0, np.nan, 3.0], np.float32)


def test_beams_without_a_return_have_no_point() -> None:
    points = scan_points(RANGES, -math.pi / 2.0, math.pi / 4.0)
    diagonal = 3.0 * math.cos(math.pi / 2.0)
    assert points == pytest.approx(np.array([[0.0, -1.0], [2.0, 0.0], [diagonal, 3.0]]))
    assert points.dtype == np.float64


def test_scan_that_sees_nothing_gives_an_empty_list_of_points() -> None:
    assert scan_points(np.full(4, np.inf, np.float32), 0.0, 0.1).shape == (0, 2)


def test_bearings_count_from_the_first_beam() -> None:
    assert bearings_of(3, -0.5, 0.25) == pytest.approx([-0.5, -0.25, 0.0])


def test_picked_beams_are_evenly_spread_from_the_first_to_the_last() -> None:
    ranges = np.arange(181, dtype=np.float32)
    bearings, picked = pick_beams(ranges, -math.pi / 2.0, math.pi / 180.0, 5)
    assert picked.tolist() == [0.0, 45.0, 90.0, 135.0, 180.0]
    assert bearings == pytest.approx(np.linspace(-math.pi / 2.0, math.pi / 2.0, 5))


def test_picked_beam_without_a_return_stays_infinite() -> None:
    _, picked = pick_beams(RANGES[:3], 0.0, 0.1, 3)
    assert picked[1] == np.inf


def test_more_beams_than_there_are_means_all() -> None:
    bearings, picked = pick_beams(RANGES, 0.0, 0.1, 99)
    assert len(bearings) == len(picked) == len(RANGES)


def test_no_beams_give_none() -> None:
    bearings, picked = pick_beams(np.empty(0, np.float32), 0.0, 0.1, 5)
    assert len(bearings) == len(picked) == 0
