"""What is not worked on state by state is bounded: by the twin's states, pass by pass."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import markov as naive
from pilotage.localizer import kernels
from pilotage.localizer.active_blocks import add_tiles, no_blocks, widened, with_neighbours
from pilotage.localizer.kernels import LANES, MOST_COST, SIDE, Admissible, Prior, Scan
from pilotage.localizer.least_costs import least_costs
from pilotage.localizer.rest import Rest
from pilotage.localizer.state_likelihood import ScanLikelihood

SEEDS = st.integers(0, 2**32 - 1)
MARGIN = 12
"""Cells round the layers' own in the field of costs: beams, and tiles that stick out."""


class Case:
    """A random belief of which everything has gone to the rest; its twin is in `states`."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        headings, rows, cols = (int(n) for n in self.rng.integers((1, 3, 3), (5, 30, 40)))
        self.shape = headings, rows, cols
        self.mask = (self.rng.random((rows, cols)) < self.rng.choice([0.2, 0.9])).astype(np.float32)
        admissible = Admissible(self.mask, kernels.whole_area(self.shape).runs[:rows])
        self.area = kernels.in_all_layers(admissible, headings)
        self.rest = Rest(headings, admissible)
        self.rest.tiles.phases[:] = self.rng.integers(0, SIDE, (headings, 2))
        self.belief = (self.rng.random(self.shape) ** 9 * self.mask).astype(np.float32)
        self.states = self.belief.astype(np.float64)

    @property
    def prior(self) -> Prior:
        return Prior(0.7, 0.01, self.rng.random(self.shape[0]).astype(np.float32))

    def retire(self, limit: float) -> np.ndarray:
        runs = kernels.sum_runs(self.belief, self.area)
        sums = kernels.sum_tiles(self.belief, self.area, self.rest.tiles, runs.mass)
        return self.rest.retire(self.belief, self.area, sums, limit)

    def tile_sums(self, states: np.ndarray) -> np.ndarray:
        return naive.tile_sums(states, self.rest.tiles.phases, SIDE)

    def scan(self, count: int = 6) -> tuple[Scan, Scan, np.ndarray]:
        """A scan by states and by tiles, and its likelihood (headings, rows, cols)."""
        headings, rows, cols = self.shape
        field = (2, rows + 2 * MARGIN, cols + 2 * MARGIN)
        costs = self.rng.integers(0, MOST_COST + 1, field).astype(np.uint8)
        beams = self.rng.integers((0, SIDE, SIDE), (2, 2 * MARGIN - SIDE, 2 * MARGIN - SIDE),
                                  (headings, count, 3))  # fmt: skip
        starts = (beams[..., 0] * field[1] + beams[..., 1]) * field[2] + beams[..., 2]
        likelihood = np.exp(-0.02 * np.arange(MOST_COST * count + 1)).astype(np.float32)
        flat = np.append(costs.ravel(), np.zeros(LANES, np.uint8))
        fine = Scan(starts.astype(np.uint64), flat, field[2], likelihood)
        coarse = least_costs(costs).scan(fine, field, self.rest.tiles.phases)
        ones = np.ones(self.shape)
        return fine, coarse, naive.weigh_scan(ones, self.mask, beams, costs, likelihood)


def at_most(states: np.ndarray, bound: np.ndarray) -> bool:
    return bool((states <= bound * (1.0 + 1e-5) + 1e-12).all())


@given(SEEDS)
def test_counts_are_the_admissible_states_of_each_tile_at_each_phase(seed: int) -> None:
    case = Case(seed)
    standing = np.repeat(case.mask[None].astype(np.float64), case.shape[0], axis=0)
    up, right = case.rest.tiles.phases.T
    assert np.array_equal(case.rest.tiles.counts[up, right], case.tile_sums(standing))


@given(SEEDS, st.floats(0.0, 5.0))
def test_light_tiles_are_retired_and_nothing_is_lost(seed: int, limit: float) -> None:
    case = Case(seed)
    sums = case.tile_sums(case.states)
    is_kept = case.retire(limit)
    assert case.tile_sums(case.belief.astype(np.float64)) == pytest.approx(
        np.where(sums > limit, sums, 0.0), abs=1e-5
    )
    assert case.rest.tiles.mass == pytest.approx(np.where(sums > limit, 0.0, sums), abs=1e-5)
    held = np.argwhere(case.belief > 0.0)
    assert is_kept[held[:, 0], held[:, 1] // SIDE, held[:, 2] // SIDE].all()


@given(SEEDS)
def test_what_is_opened_again_weighs_the_same_and_stands_in_free_cells(seed: int) -> None:
    case = Case(seed)
    sums = case.tile_sums(case.states)
    case.retire(np.inf)
    assert not case.belief.any()
    case.rest.open(case.belief)
    assert case.tile_sums(case.belief.astype(np.float64)) == pytest.approx(sums, rel=1e-4, abs=1e-5)
    assert not (case.belief * (1.0 - case.mask)).any()
    assert case.rest.mass == 0.0


@given(SEEDS, st.integers(-20, 20), st.integers(-20, 20))
def test_a_shift_moves_tiles_with_their_states(seed: int, up: int, right: int) -> None:
    case = Case(seed)
    case.retire(np.inf)
    case.rest.shift(np.tile([up, right], (case.shape[0], 1)))
    moved = np.array([naive.shift_layer(layer, up, right) for layer in case.states])
    assert at_most(case.tile_sums(moved), case.rest.tiles.mass)
    assert case.rest.mass <= case.states.sum() * (1.0 + 1e-5)


@given(SEEDS, st.floats(0.0, 0.25), st.integers(1, 3))
def test_spreading_stays_below_the_bound(seed: int, share: float, times: int) -> None:
    case = Case(seed)
    case.retire(np.inf)
    states = case.states
    for _ in range(times):
        case.rest.spread(share)
        states = np.array([naive.spread_layer(layer, share) for layer in states])
    assert at_most(case.tile_sums(states), case.rest.tiles.mass)


@given(SEEDS, st.floats(0.0, 0.25))
def test_spreading_over_headings_stays_below_the_bound(seed: int, share: float) -> None:
    case = Case(seed)
    case.retire(np.inf)
    shifts = case.rng.integers(-1, 2, (case.shape[0], 2))
    case.rest.spread_headings(share, shifts)
    states = naive.spread_headings(case.states, share, shifts)
    assert at_most(case.tile_sums(states), case.rest.tiles.mass)


@settings(max_examples=40)
@given(SEEDS)
def test_a_scan_stays_below_the_bound_and_the_tightened_bound(seed: int) -> None:
    case = Case(seed)
    case.retire(np.inf)
    fine, coarse, likelihood = case.scan()
    prior = case.prior
    case.rest.weigh(prior, coarse)
    states = naive.add_floor(
        case.states, case.mask, prior.scale, prior.floor, prior.heading.astype(float)
    )
    sums = case.tile_sums(states * likelihood)
    rough = case.rest.tiles.mass.copy()
    assert at_most(sums, rough)
    case.rest.tighten(np.argwhere(rough > 0.0), ScanLikelihood(fine))
    assert at_most(sums, case.rest.tiles.mass)
    assert at_most(case.rest.tiles.mass, rough)


@settings(max_examples=40)
@given(SEEDS)
def test_a_woken_tile_gets_its_mass_evenly_and_weighed(seed: int) -> None:
    case = Case(seed)
    case.retire(np.inf)
    fine, coarse, likelihood = case.scan()
    before = case.rest.tiles.mass.copy()
    unchanged = Prior(1.0, 0.0, np.ones(case.shape[0], np.float32))
    case.rest.weigh(unchanged, coarse)
    heavy = case.rest.above(0.0)[::2]
    case.rest.tighten(heavy, ScanLikelihood(fine))
    case.rest.wake(case.belief, heavy, ScanLikelihood(fine))
    even = np.zeros_like(before)
    up, right = case.rest.tiles.phases.T
    at = tuple(heavy.T)
    even[at] = before[at] / case.rest.tiles.counts[up, right][at]
    expected = case.tile_sums(likelihood * case.mask) * even
    woken = case.tile_sums(case.belief.astype(np.float64))
    assert woken == pytest.approx(expected, rel=1e-3, abs=1e-6)
    assert not case.rest.tiles.mass[at].any()


@given(SEEDS, st.floats(0.0, 2.0))
def test_tiles_below_the_limit_stay_within_the_budget(seed: int, budget: float) -> None:
    case = Case(seed)
    case.retire(np.inf)
    mass = case.rest.tiles.mass.astype(np.float64)
    limit = case.rest.limit_of(budget)
    assert mass[mass < limit].sum() <= budget * (1.0 + 1e-6)
    with_next = mass[mass < 2.0 * limit].sum()
    assert with_next > budget * (1.0 - 1e-6) or with_next == mass.sum()


@given(SEEDS)
def test_a_correction_without_a_scan_adds_the_floor_of_its_states(seed: int) -> None:
    case = Case(seed)
    case.retire(np.inf)
    prior = case.prior
    case.rest.begin(prior)
    states = naive.add_floor(
        case.states, case.mask, prior.scale, prior.floor, prior.heading.astype(float)
    )
    assert case.rest.tiles.mass == pytest.approx(case.tile_sums(states), rel=1e-4, abs=1e-6)


@given(SEEDS)
def test_least_costs_are_those_of_each_window(seed: int) -> None:
    rng = np.random.default_rng(seed)
    costs = rng.integers(0, MOST_COST + 1, (2, *rng.integers(1, 30, 2))).astype(np.uint8)
    planes = least_costs(costs).planes
    for c, up, right, row, col in np.ndindex(planes.shape):
        low, left = SIDE * (row - 1) + up, SIDE * (col - 1) + right
        window = costs[c, max(0, low) : max(0, low + SIDE), max(0, left) : max(0, left + SIDE)]
        if window.size:
            assert planes[c, up, right, row, col] == window.min()


@given(SEEDS)
def test_runs_hold_exactly_the_active_blocks(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(1, 40, 3))
    blocks = no_blocks(shape)
    blocks[:] = rng.random(blocks.shape) < 0.4
    runs, starts = kernels.runs_of_blocks(blocks, *shape[1:])
    covered = np.zeros(shape, bool)
    for k in range(shape[0]):
        for row, first, last in runs[starts[k] : starts[k + 1]]:
            assert not covered[k, row, first:last].any()
            covered[k, row, first:last] = True
    expected = np.kron(blocks, np.ones((1, SIDE, SIDE), bool))[:, : shape[1], : shape[2]]
    assert np.array_equal(covered, expected)


def test_blocks_widen_by_whole_blocks_and_to_the_next_headings() -> None:
    blocks = no_blocks((5, 80, 80))
    blocks[0, 4, 4] = True
    near = [[row, col] for row in (3, 4, 5) for col in (3, 4, 5)]
    assert np.argwhere(widened(blocks, 1)[0]).tolist() == near
    assert widened(blocks, 9)[0].sum() == 25
    assert np.flatnonzero(with_neighbours(blocks).any(axis=(1, 2))).tolist() == [0, 1, 4]
    assert np.array_equal(widened(blocks, 0), blocks)


def test_a_tile_reaches_into_up_to_four_blocks() -> None:
    blocks = no_blocks((2, 32, 32))
    add_tiles(blocks, np.array([[1, 2, 1]]), np.array([[0, 0], [3, 0]]))
    # Rows 11 to 18, columns 0 to 7.
    assert np.argwhere(blocks).tolist() == [[1, 1, 0], [1, 2, 0]]
