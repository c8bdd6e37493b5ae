"""Every pass over the belief against its naive twin on random beliefs, masks and tables."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from naive import markov as naive
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.localizer import kernels
from pilotage.localizer.active_blocks import widened, with_neighbours
from pilotage.localizer.kernels import LANES, MOST_COST, Area, Prior, Scan, Sight
from pilotage.localizer.pose_grid import MERGED, PoseGridParams, pose_grid

SEEDS = st.integers(0, 2**32 - 1)
CLOSE = 1e-5
"""Relative: the kernels keep the belief in float32."""


class Case:
    """A random belief on a random floor, every layer empty in places as after a measurement."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.headings, rows = self.rng.integers(1, 6), self.rng.integers(1, 7)
        cols = self.rng.integers(1, 50)
        is_free = self.rng.random((rows, cols)) < self.rng.choice([0.1, 0.5, 0.95])
        is_free[self.rng.integers(rows), self.rng.integers(cols)] = True
        cells = np.where(is_free, 0, 100).astype(np.int8)
        grid = pose_grid(
            OccupancyMap(GridGeometry(int(rows), int(cols), 1.0), cells),
            PoseGridParams(resolution=1.0, headings=int(self.headings)),
        )
        self.admissible = grid.admissible
        self.area = kernels.in_all_layers(grid.admissible, grid.headings)
        self.shape = grid.shape
        sparse = self.rng.random(self.shape) ** 4 * (self.rng.random(self.shape) < 0.7)
        self.belief = (sparse * self.admissible.mask).astype(np.float32)

    @property
    def exact(self) -> np.ndarray:
        return self.belief.astype(np.float64)

    @property
    def no_prior(self) -> Prior:
        return Prior(1.0, 0.0, np.ones(self.shape[0], np.float32))

    @property
    def all_cells(self) -> Area:
        return kernels.whole_area(self.shape)

    def summed(self) -> tuple[np.ndarray, np.ndarray]:
        """Twin of `sum_runs`, in its order: layer by layer."""
        mass, peak = naive.sum_runs(self.exact, self.admissible.runs)
        return mass.ravel(), peak.ravel()

    def bytes_of(self, *shape: int) -> np.ndarray:
        return self.rng.integers(0, 256, shape).astype(np.uint8)


def scan_of(beams: np.ndarray, costs: np.ndarray, likelihood: np.ndarray) -> Scan:
    """Beams (headings, n, 3) of class, row and col in costs (classes, rows, cols)."""
    _, height, width = costs.shape
    starts = (beams[..., 0] * height + beams[..., 1]) * width + beams[..., 2]
    flat = np.append(costs.ravel(), np.full(LANES, MOST_COST, np.uint8))
    return Scan(starts.astype(np.uint64), flat, width, likelihood)


def blocks_holding(belief: np.ndarray) -> np.ndarray:
    """The blocks (headings, rows, cols) of a belief of whole blocks that hold something."""
    headings, rows, cols = belief.shape
    blocks = belief.reshape(headings, rows // 8, 8, cols // 8, 8)
    return np.asarray(blocks.any(axis=(2, 4)))


def area_of(blocks: np.ndarray, shape: tuple[int, ...]) -> Area:
    """The area of some blocks of a hall without walls."""
    whole = kernels.whole_area(shape)
    runs, starts = kernels.runs_of_blocks(blocks, *shape[1:])
    return Area(whole.mask, runs, starts, whole.gaps)


def close(expected: np.ndarray, smallest: float = 1e-30) -> object:
    return pytest.approx(expected, rel=CLOSE, abs=smallest)


@given(SEEDS)
def test_runs_hold_all_admissible_cells_and_no_long_gap(seed: int) -> None:
    area = Case(seed).admissible
    assert [tuple(run) for run in area.runs] == naive.runs_of(area.mask, MERGED)
    assert not area.mask[~naive.covered(area.mask, area.runs)].any()


@given(SEEDS)
def test_gaps_are_what_the_runs_leave_out(seed: int) -> None:
    area = Case(seed).admissible
    in_runs, in_gaps = (naive.covered(area.mask, stretch) for stretch in (area.runs, area.gaps))
    assert np.array_equal(in_gaps, ~in_runs)
    lengths = np.diff(np.concatenate([area.runs, area.gaps])[:, 1:], axis=1)
    assert lengths.sum() == area.mask.size


@given(SEEDS, st.floats(0.0, 10.0), st.floats(0.0, 1.0))
def test_floor_is_added_where_a_robot_may_stand(seed: int, scale: float, floor: float) -> None:
    case = Case(seed)
    case.belief += 0.5  # what spread into walls must vanish
    heading = case.rng.random(case.shape[0]).astype(np.float32)
    mask = case.admissible.mask
    expected = naive.add_floor(case.exact, mask, scale, floor, heading.astype(np.float64))
    kernels.weigh_prior(case.belief, case.area, Prior(scale, floor, heading))
    assert case.belief == close(expected, 1e-36)


@given(SEEDS, st.integers(0, 20))
def test_scan_weighs_each_state_by_the_costs_of_its_own_beams(seed: int, count: int) -> None:
    case = Case(seed)
    headings, rows, cols = case.shape
    margin, classes = 3, 2
    costs = case.bytes_of(classes, rows + 2 * margin, cols + 2 * margin) // 4
    beams = case.rng.integers(0, 2 * margin + 1, (headings, count, 3))
    beams[:, :, 0] %= classes
    likelihood = case.rng.random(MOST_COST * count + 1).astype(np.float32)
    expected = naive.weigh_scan(case.exact, case.admissible.mask, beams, costs, likelihood)
    scan = scan_of(beams, costs, likelihood)
    kernels.weigh_scan(case.belief, case.area, case.no_prior, scan)
    assert case.belief == close(expected)


@given(SEEDS, st.integers(0, 9))
def test_ranges_weigh_each_state_by_what_it_should_measure(seed: int, count: int) -> None:
    case = Case(seed)
    headings, rows, cols = case.shape
    levels = case.bytes_of(7, rows, cols)
    directions = case.rng.integers(0, 7, (headings, count))
    likelihoods = case.rng.random((headings, count, 256)).astype(np.float32)
    mask = case.admissible.mask
    expected = naive.weigh_ranges(case.exact, mask, directions, levels, likelihoods)
    echoes = kernels.echoes_of(directions, levels, likelihoods)
    kernels.weigh_ranges(case.belief, case.area, case.no_prior, echoes)
    assert case.belief == close(expected)


@given(SEEDS, st.integers(0, 3))
def test_states_ahead_of_their_cells_expect_shorter_ranges(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    likelihoods = rng.random((count, 256)).astype(np.float32)
    ranges = np.cumsum(rng.uniform(0.02, 0.2, 256)) - 0.02
    ahead = rng.uniform(-0.5, 0.5, (4, count)) * rng.integers(0, 2, (4, count))
    moved = kernels.shift_levels(likelihoods, ranges, ahead)
    for k, beam in np.ndindex(4, count):
        expected = naive.shifted(likelihoods[beam].astype(float), ranges, float(ahead[k, beam]))
        assert moved[k, beam] == pytest.approx(expected, abs=1e-5)


@given(SEEDS, st.floats(0.1, 10.0), st.floats(0.0, 1.0))
def test_one_pass_does_what_prior_scan_and_sums_do_one_by_one(
    seed: int, scale: float, floor: float
) -> None:
    case, apart = Case(seed), Case(seed)
    headings, rows, cols = case.shape
    costs = case.bytes_of(1, rows + 2, cols + 2) // 4
    beams = np.ones((headings, 5, 3), np.int64) * [0, 1, 1]
    scan = scan_of(beams, costs, np.exp(-0.01 * np.arange(5 * MOST_COST + 1)).astype(np.float32))
    prior = Prior(scale, floor, case.rng.random(headings).astype(np.float32))
    runs = kernels.weigh_scan(case.belief, case.area, prior, scan)
    kernels.weigh_prior(apart.belief, apart.area, prior)
    kernels.weigh_scan(apart.belief, apart.area, case.no_prior, scan)
    assert case.belief == close(apart.exact)
    mass, peak = case.summed()
    assert runs.mass == close(mass)
    assert np.array_equal(runs.peak, peak)


@given(SEEDS, st.integers(1, 6), st.floats(0.0, 0.8))
def test_visibility_counts_beams_through_walls_and_passes_over_what_is_light(
    seed: int, count: int, least: float
) -> None:
    case = Case(seed)
    levels = case.bytes_of(5, *case.shape[1:])
    directions = case.rng.integers(0, 5, (case.shape[0], count))
    allowed = case.bytes_of(count)
    factors = np.sort(case.rng.random(count + 1).astype(np.float32))[::-1].copy()
    before = case.exact
    sight = Sight(directions, levels, allowed, factors, np.float32(least))
    runs = kernels.sum_runs(case.belief, case.area)
    kernels.weigh_visibility(case.belief, case.area, runs, sight)
    for state in np.ndindex(case.shape):
        through = naive.beams_through_walls(directions, allowed, levels, state)
        expected = before[state] * factors[through]
        if before[state] > np.float32(least):
            assert case.belief[state] == close(expected)
        else:
            assert case.belief[state] == close(expected) or case.belief[state] == before[state]
    mass, peak = case.summed()
    assert runs.mass == close(mass)
    assert np.array_equal(runs.peak, peak)


@given(SEEDS)
def test_runs_are_summed_and_their_peaks_found(seed: int) -> None:
    case = Case(seed)
    runs = kernels.sum_runs(case.belief, case.area)
    mass, peak = case.summed()
    assert runs.mass == close(mass)
    assert np.array_equal(runs.peak, peak)


@given(SEEDS, st.floats(0.0, 0.5))
def test_states_above_a_threshold_are_those_of_the_chosen_runs(seed: int, threshold: float) -> None:
    case = Case(seed)
    is_chosen = case.rng.random(len(case.area.runs)) < 0.7
    chosen = np.flatnonzero(is_chosen)
    states, weights = kernels.states_above(case.belief, case.area, chosen, threshold)
    expected = []
    for k in range(case.shape[0]):
        for i in range(case.area.starts[k], case.area.starts[k + 1]):
            row, first, last = case.area.runs[i]
            above = np.flatnonzero(case.belief[k, row, first:last] > threshold) + first
            expected += [(k, row, col) for col in above] if is_chosen[i] else []
    assert [tuple(state) for state in states] == expected
    assert np.array_equal(weights, case.belief[tuple(states.T)])


@given(SEEDS, st.floats(0.0, 0.5))
def test_headings_sum_to_the_marginal_but_for_runs_that_are_light(seed: int, least: float) -> None:
    case = Case(seed)
    runs = kernels.sum_runs(case.belief, case.area)
    marginal = kernels.sum_headings(case.belief, case.area, runs.mass, least)
    left_out = runs.mass[runs.mass <= least].sum()
    exact = case.exact.sum(axis=0)
    assert (marginal <= exact * (1.0 + CLOSE) + 1e-30).all()
    assert exact.sum() - marginal.sum() == pytest.approx(left_out, rel=1e-4, abs=1e-5)


@given(SEEDS, st.integers(-30, 10))
def test_logarithms_give_the_entropy_in_bits(seed: int, exponent: int) -> None:
    case = Case(seed)
    case.belief[0, *np.argwhere(case.admissible.mask)[0]] = 0.5
    case.belief *= np.float32(2.0**exponent)
    runs = kernels.sum_runs(case.belief, case.area)
    bits = case.belief.view(np.int32)
    summed = kernels.sum_logarithms(case.belief, bits, case.area, runs.mass)
    total = float(runs.mass.sum())
    entropy = np.log2(total) - summed / total
    assert entropy == pytest.approx(naive.entropy_bits(case.exact), abs=2e-3)


@given(SEEDS, st.integers(-8, 8), st.integers(-60, 60))
def test_shift_moves_a_layer_by_whole_cells(seed: int, up: int, right: int) -> None:
    case = Case(seed)
    expected = np.array([naive.shift_layer(layer, up, right) for layer in case.exact])
    cells = np.tile([up, right], (case.shape[0], 1))
    kernels.shift_layers(case.belief, case.all_cells, cells)
    assert np.array_equal(case.belief, expected)


@given(SEEDS, st.floats(0.0, 0.25))
def test_spread_gives_each_neighbour_its_share(seed: int, share: float) -> None:
    case = Case(seed)
    expected = np.array([naive.spread_layer(layer, share) for layer in case.exact])
    kernels.spread_layers(case.belief, case.all_cells, share)
    assert case.belief == close(expected, 1e-7)


@given(SEEDS, st.floats(0.0, 0.25))
def test_headings_spread_to_the_places_where_their_neighbours_lie(seed: int, share: float) -> None:
    case = Case(seed)
    shifts = case.rng.integers(-2, 3, (case.shape[0], 2))
    expected = naive.spread_headings(case.exact, share, shifts)
    kernels.spread_headings(case.belief, case.all_cells, share, shifts)
    assert case.belief == close(expected, 1e-7)


@given(SEEDS, st.integers(-2, 2), st.integers(-2, 2), st.floats(0.0, 0.25))
def test_what_lies_well_inside_an_area_moves_as_if_all_cells_were_worked_on(
    seed: int, up: int, right: int, share: float
) -> None:
    rng = np.random.default_rng(seed)
    belief = np.zeros((4, 24, 40), np.float32)
    belief[1, 8:12, 9:20] = rng.random((4, 11))
    belief[2, 17:20, 1:4] = rng.random((3, 3))
    blocks = widened(blocks_holding(belief), 8)
    area = area_of(with_neighbours(blocks), belief.shape)
    inside = belief.copy()
    cells, shifts = rng.integers(-2, 3, (4, 2)), np.array([[up, right]] * 4)
    for layers, where in ((belief, kernels.whole_area(belief.shape)), (inside, area)):
        kernels.shift_layers(layers, where, cells)
        kernels.spread_layers(layers, where, share)
        kernels.spread_headings(layers, where, share, shifts)
    np.testing.assert_allclose(inside, belief, rtol=1e-6, atol=1e-30)


@given(arrays(np.float32, (9, 11), elements=st.floats(0.0, 1.0, width=32)), st.floats(0.01, 0.25))
def test_spread_conserves_mass(layer: np.ndarray, share: float) -> None:
    mass = layer.sum(dtype=np.float64)
    kernels.spread_layers(layer[None], kernels.whole_area((1, 9, 11)), share)
    assert layer.sum(dtype=np.float64) == pytest.approx(mass, rel=1e-6, abs=1e-30)


@given(st.floats(0.02, 0.25), st.integers(1, 9))
def test_spread_adds_twice_its_share_of_variance_per_axis(share: float, times: int) -> None:
    layer = np.zeros((21, 21), np.float32)
    layer[10, 10] = 1.0
    for _ in range(times):
        kernels.spread_layers(layer[None], kernels.whole_area((1, 21, 21)), share)
    squared = (np.arange(21) - 10.0) ** 2
    for axis in (0, 1):
        variance = float(layer.sum(axis=1 - axis, dtype=np.float64) @ squared)
        assert variance == pytest.approx(2.0 * share * times, rel=1e-5)


@settings(max_examples=20)
@given(SEEDS, st.floats(0.0, 0.25))
def test_spread_over_headings_conserves_mass_and_turns_alike_both_ways(
    seed: int, share: float
) -> None:
    rng = np.random.default_rng(seed)
    belief = rng.random((7, 3, 4), np.float32)
    mirrored = belief[::-1].copy()
    none = np.zeros((7, 2), np.int64)
    mass = belief.sum(dtype=np.float64)
    all_cells = kernels.whole_area(belief.shape)
    kernels.spread_headings(belief, all_cells, share, none)
    kernels.spread_headings(mirrored, all_cells, share, none)
    assert belief.sum(dtype=np.float64) == pytest.approx(mass, rel=1e-6)
    assert mirrored[::-1] == pytest.approx(belief, rel=1e-5)


def test_kernels_are_warmed_up_for_every_type_they_meet() -> None:
    kernels.warm_up()
    one = np.ones((1, 1, 1), np.float32)
    assert kernels.sum_runs(one, kernels.whole_area(one.shape)).mass == 1.0
