"""The plain twin of the laser's grid draws what the product draws."""

import itertools

import numpy as np
import pytest

from pilotage.bench import mapping_cases
from pilotage.bench.entry import Stopwatch
from pilotage.bench.reference_laser_grid import PlainLaserGrid, crossed_cells
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_params import LaserGridParams


def test_a_beam_crosses_every_cell_between_its_lines() -> None:
    rows, cols = crossed_cells(np.array([0.5, 0.5]), np.array([2.5, 1.4]))
    assert list(zip(rows.tolist(), cols.tolist(), strict=True)) == [(0, 0), (0, 1), (1, 1), (1, 2)]


def test_a_beam_within_a_cell_crosses_that_cell() -> None:
    rows, cols = crossed_cells(np.array([0.2, 3.5]), np.array([0.2, 3.6]))
    assert (rows.tolist(), cols.tolist()) == ([3], [0])


def test_both_grids_say_the_same_where_no_beam_grazes() -> None:
    rng = np.random.default_rng(2)
    grid = LaserGrid(LaserGridParams(resolution=0.1, graze_max=0.0))
    grid.make_room((-12.8, -12.8), (12.7, 12.7))
    plain = PlainLaserGrid((256, 256), 0.1, np.array([-12.8, -12.8]))
    for _ in range(10):
        origin = rng.uniform(-5.0, 5.0, 2)
        ends = origin + rng.normal(0.0, 2.0, (40, 2))
        is_hit = rng.random(40) < 0.8
        grid.insert(origin, ends, is_hit)
        plain.insert(origin, ends, is_hit)
    ours = grid.log_odds()
    alike = np.isclose(ours, plain.log_odds, atol=0.2, equal_nan=True)
    # The product's points stand on a raster: a beam may touch a corner that the twin's passes by.
    assert (~alike).sum() < 0.005 * np.isfinite(ours).sum()


def test_the_entries_tell_how_much_was_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mapping_cases, "SCANS", 20)
    monkeypatch.setattr(mapping_cases, "REDRAWN", 50)
    ticks = itertools.count(0.0, 0.001)
    one, many = mapping_cases.mapping_cases(Stopwatch(lambda: next(ticks)))
    assert (one.size.beams, one.size.kind) == (361, "cells")
    assert one.size.count > 100_000
    assert one.cpu_ms == pytest.approx(1.0)
    assert one.reference_cpu_ms == pytest.approx(1.0)
    assert many.reference_cpu_ms == pytest.approx(50.0)
    assert many.reference_fraction == 3 / 50
