"""Kernels over particles against their plain twins, and the laws that they keep."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from naive import particles as naive
from pilotage.core import se2
from pilotage.core.grid import GridGeometry
from pilotage.localizer import particle_kernels as kernels
from pilotage.localizer.particle_resampling import draw

seeds = st.integers(0, 2**32 - 1)


def poses_near(geometry: GridGeometry, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Poses on a grid and a little beyond its edges."""
    width, height = geometry.size_m
    local = np.column_stack(
        [
            rng.uniform(-0.2 * width, 1.2 * width, count),
            rng.uniform(-0.2 * height, 1.2 * height, count),
            rng.uniform(-np.pi, np.pi, count),
        ]
    )
    return se2.compose(geometry.origin, local)


def cells_of(
    geometry: GridGeometry, table: NDArray[np.uint8] | None = None, margin: int = 0
) -> kernels.Cells:
    values = np.empty((0, geometry.cols), np.uint8) if table is None else table
    return kernels.Cells(
        values.ravel(), values.shape[1], margin, *geometry.origin, geometry.resolution
    )


@given(seeds, st.integers(0, 9), st.floats(-3.0, 3.0))
def test_the_ends_of_beams_cost_what_their_cells_say(seed: int, beams: int, turn: float) -> None:
    rng = np.random.default_rng(seed)
    geometry, margin = GridGeometry(9, 13, 0.25, (3.0, -2.0, turn)), 14
    table = rng.integers(0, 256, (9 + 2 * margin, 13 + 2 * margin)).astype(np.uint8)
    is_free = rng.random(geometry.shape) < 0.8
    poses = poses_near(geometry, 40, rng)
    # Not longer than the margin, even cornerwise.
    ends = rng.uniform(-2.1, 2.1, (beams, 2))
    total = np.empty(len(poses), np.int64)
    in_cells = np.ascontiguousarray(ends.T / geometry.resolution, np.float32)
    kernels.weigh_ends(poses, in_cells, cells_of(geometry, table, margin), is_free, total)
    twin = naive.summed_costs(poses, ends, table, geometry, is_free)
    # An end on the edge of a cell may be rounded into either; that is one beam of a thousand.
    assert np.mean(total == twin) >= 0.95


@given(seeds, st.integers(0, 6), st.floats(-3.0, 3.0))
def test_expected_ranges_cost_what_their_levels_say(seed: int, beams: int, turn: float) -> None:
    rng = np.random.default_rng(seed)
    geometry = GridGeometry(5, 8, 0.5, (-1.0, 4.0, turn))
    levels = rng.integers(0, 256, (5, 8, 12)).astype(np.uint8)
    costs = rng.random((beams, 256)).astype(np.float32)
    bearings = rng.uniform(-np.pi, np.pi, beams)
    poses = poses_near(geometry, 30, rng)
    total = np.empty(len(poses))
    kernels.sum_levels(poses, bearings, costs, (levels, cells_of(geometry)), total)
    twin = naive.summed_levels(poses, bearings, costs, levels, geometry)
    assert np.mean(np.isclose(total, twin)) >= 0.95


@given(seeds)
def test_moving_composes_and_wraps(seed: int) -> None:
    rng = np.random.default_rng(seed)
    poses, steps = rng.uniform(-np.pi, np.pi, (2, 30, 3))
    poses[0, 2], steps[0, 2] = np.pi, np.pi
    poses[1, 2], steps[1, 2] = -np.pi, 0.0
    moved = poses.copy()
    kernels.move(moved, steps)
    twin = se2.compose(poses, steps)
    assert moved[:, :2] == pytest.approx(twin[:, :2])
    assert np.cos(moved[:, 2] - twin[:, 2]) == pytest.approx(1.0)
    assert (moved[:, 2] >= -np.pi).all()
    assert (moved[:, 2] < np.pi).all()


weights_of_many = st.lists(st.sampled_from([0.0, 1e-12, 0.1, 1.0, 7.0]), min_size=1, max_size=30)


@given(weights_of_many, st.integers(1, 60), st.floats(0.0, 1.0, exclude_max=True))
def test_a_comb_draws_each_particle_by_its_weight(
    values: list[float], count: int, offset: float
) -> None:
    weights = np.array(values)
    if weights.sum() == 0.0:
        weights[0] = 1.0
    drawn = np.empty(count, np.int64)
    kernels.draw_systematic(weights, offset, drawn)
    counts = np.bincount(drawn, minlength=len(weights))
    expected = weights / weights.sum() * count
    assert np.abs(counts - expected).max() <= 1.0 + 1e-6
    assert counts.sum() == count
    assert not counts[weights == 0.0].any()
    assert (np.diff(drawn) >= 0).all()
    twin = naive.systematic_indices(weights, count, offset)
    # On the border between two particles rounding may choose either.
    assert np.sum(drawn != twin) <= 1 + np.sum(weights == 1e-12)


def test_drawing_favours_nobody() -> None:
    rng = np.random.default_rng(5)
    weights = np.array([0.31, 0.02, 0.0, 0.17, 0.5])
    drawn = np.concatenate([draw(weights, 3, rng) for _ in range(20_000)])
    shares = np.bincount(drawn, minlength=5) / len(drawn)
    assert shares == pytest.approx(weights, abs=0.004)


bins_met = st.lists(st.integers(0, 3_000_000_000), min_size=1, max_size=60)


@given(bins_met, st.integers(1, 20), st.integers(1, 60), st.floats(0.01, 0.9))
def test_as_many_particles_are_called_for_as_fox_says(
    bins: list[int], least: int, more: int, epsilon: float
) -> None:
    limits = least, least + more, epsilon, 2.33
    asked = kernels.count_needed(np.array(bins, np.int64), 1, 0, limits)
    assert asked == naive.needed(bins, limits)
    assert least <= asked <= least + more


@given(bins_met, st.integers(0, 10_000))
def test_the_order_of_the_count_visits_everyone(bins: list[int], first: int) -> None:
    limits = 1, 10**9, 1e-9, 2.33
    stride = 1 if len(bins) < 3 else len(bins) - 1
    asked = kernels.count_needed(np.array(bins, np.int64), stride, first % len(bins), limits)
    assert asked == naive.needed(bins, limits)
