"""The plain twins draw what the product draws, and match as it matches."""

import itertools

import numpy as np
import pytest

from pilotage.bench import mapping_cases
from pilotage.bench.building_cases import OFFICE_CORRIDOR
from pilotage.bench.entry import Stopwatch
from pilotage.bench.reference_laser_grid import PlainLaserGrid, crossed_cells
from pilotage.bench.reference_scan_match import normal_equations as plain_equations
from pilotage.bench.reference_scan_match import plain_match
from pilotage.core import se2
from pilotage.core.raycast import cast_scan
from pilotage.mapper.laser_grid import LaserGrid
from pilotage.mapper.laser_grid_params import LaserGridParams
from pilotage.mapper.matching_kernels import normal_equations
from pilotage.mapper.scan_tracker import HERE, TrackerParams, corrected, local_map, predicted
from pilotage.mapper.surfels import SurfelParams, surfel_map
from pilotage.robot.simulator.floor_plans import office_floor


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
    one, many, matched = mapping_cases.mapping_cases(Stopwatch(lambda: next(ticks)))
    assert (one.size.beams, one.size.kind) == (361, "cells")
    assert one.size.count > 100_000
    assert one.cpu_ms == pytest.approx(1.0)
    assert one.reference_cpu_ms == pytest.approx(1.0)
    assert many.reference_cpu_ms == pytest.approx(50.0)
    assert many.reference_fraction == 3 / 50
    assert (matched.size.beams, matched.size.kind) == (361, "cells")
    assert matched.cpu_ms == pytest.approx(1.0)
    assert matched.reference_fraction == 1.0


@pytest.mark.parametrize("seed", range(6))
def test_both_matchers_find_the_same_pose(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world, params = office_floor(), TrackerParams()
    bearings = np.linspace(-np.pi / 2.0, np.pi / 2.0, 181)
    along = np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
    x_from, x_to, y = OFFICE_CORRIDOR
    first = np.array([rng.uniform(x_from, x_to - 1.0), y, rng.uniform(-1.0, 1.0)])
    moved = np.array([0.25, 0.0, 0.1])
    seen = [cast_scan(world, pose, bearings, 30.0) for pose in (first, se2.compose(first, moved))]
    before, now = ((along * ranges[:, None])[np.isfinite(ranges)] for ranges in seen)
    guess = predicted(HERE, moved + rng.normal(0.0, 0.03, 3), params.drift)
    here = local_map(before, params)
    found = corrected(guess, now, here, params)
    assert found.is_matched
    assert plain_match(guess, now, here, params) == pytest.approx(found.pose, abs=1e-3)


def test_a_step_of_the_plain_matcher_is_that_of_the_loops() -> None:
    rng = np.random.default_rng(4)
    points = np.vstack([np.column_stack([np.full(40, 1.0), rng.uniform(-1.0, 1.0, 40)])] * 2)
    points[40:] = points[40:, ::-1] + rng.normal(0.0, 0.01, (40, 2))
    walls, pose, sigmas = surfel_map(points, SurfelParams()), np.full(3, 0.02), (0.03, 3.0, 0.08)
    H, g, _, _ = normal_equations(pose, points, walls, sigmas)
    plain_H, plain_g = plain_equations(pose, points, walls, sigmas)
    assert plain_H == pytest.approx(H, rel=1e-9)
    assert plain_g == pytest.approx(g, rel=1e-9)
