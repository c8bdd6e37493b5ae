"""What is not worked on state by state is weighed by landmarks too: bounded, and woken in time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import landmarks as naive
from naive.markov import tile_sums
from pilotage.localizer import kernels
from pilotage.localizer.kernels import SIDE, Admissible
from pilotage.localizer.landmark_kernels import KnownSightings
from pilotage.localizer.landmark_states import SightingsLikelihood
from pilotage.localizer.rest import Rest

SEEDS = st.integers(0, 2**32 - 1)


class Case:
    """A random belief of which everything has gone to the rest, and random sightings.

    `weighed`: what the twin makes of the states.
    """

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        headings, rows, cols = (int(n) for n in rng.integers((1, 3, 3), (4, 20, 25)))
        shape = headings, rows, cols
        self.mask = (rng.random((rows, cols)) < rng.choice([0.2, 0.9])).astype(np.float32)
        admissible = Admissible(self.mask, kernels.whole_area(shape).runs[:rows])
        self.area = kernels.in_all_layers(admissible, headings)
        self.said = said_by(rng, headings)
        self.likelihood = naive.state_likelihoods(
            shape, self.said.layers, self.said.sightings, self.said.exponent
        )
        self.belief = (rng.random(shape) ** 9 * self.mask).astype(np.float32)
        self.weighed = self.belief * self.likelihood
        self.rest = Rest(headings, admissible)
        self.rest.tiles.phases[:] = rng.integers(0, SIDE, (headings, 2))
        runs = kernels.sum_runs(self.belief, self.area)
        sums = kernels.sum_tiles(self.belief, self.area, self.rest.tiles, runs.mass)
        self.rest.retire(self.belief, self.area, sums, np.inf)

    def tile_sums(self, states: np.ndarray) -> np.ndarray:
        return tile_sums(states, self.rest.tiles.phases, SIDE)


def said_by(rng: np.random.Generator, headings: int) -> SightingsLikelihood:
    """One to three sightings, each of one to three places, near or far, exact or hardly."""
    count = int(rng.integers(1, 4))
    offsets = np.concatenate([[0], np.cumsum(rng.integers(1, 4, count))])
    values = rng.uniform((0.0, -4.0, 0.05, 0.02), (4.0, 4.0, 0.6, 0.6), (count, 4))
    seen = KnownSightings(values, offsets, rng.uniform(-1.0, 4.0, (offsets[-1], 2)), 0.05)
    corners = rng.uniform((-0.1, -0.1, -4.0), (0.1, 0.1, 4.0), (headings, 3))
    return SightingsLikelihood((corners, 0.1), seen, float(rng.uniform(0.1, 1.0)))


def at_most(states: np.ndarray, bound: np.ndarray) -> bool:
    return bool((states <= bound * (1.0 + 1e-4) + 1e-12).all())


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_sightings_stay_below_the_bound_and_the_tightened_bound(seed: int) -> None:
    case = Case(seed)
    case.rest.weigh_more(case.said.bounds(case.rest.tiles))
    rough = case.rest.tiles.mass.copy()
    sums = case.tile_sums(case.weighed)
    assert at_most(sums, rough)
    case.rest.tighten(np.argwhere(rough > 0.0), case.said)
    assert at_most(sums, case.rest.tiles.mass)
    assert at_most(case.rest.tiles.mass, rough)


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_a_woken_tile_gets_its_mass_evenly_and_weighed(seed: int) -> None:
    case = Case(seed)
    before = case.rest.tiles.mass.copy()
    case.rest.weigh_more(case.said.bounds(case.rest.tiles))
    heavy = case.rest.above(0.0)[::2]
    case.rest.tighten(heavy, case.said)
    case.rest.wake(case.belief, heavy, case.said)
    even, at = np.zeros_like(before), tuple(heavy.T)
    up, right = case.rest.tiles.phases.T
    even[at] = before[at] / case.rest.tiles.counts[up, right][at]
    expected = case.tile_sums(case.likelihood * case.mask) * even
    woken = case.tile_sums(case.belief.astype(np.float64))
    # A fit of less than e^-12.5 counts as none.
    assert woken == pytest.approx(expected, rel=1e-3, abs=1e-6)
    assert not case.rest.tiles.mass[at].any()


@settings(max_examples=40, deadline=None)
@given(SEEDS)
def test_what_was_said_can_be_taken_back(seed: int) -> None:
    case = Case(seed)
    case.rest.open(case.belief)
    before = case.belief.copy()
    case.said.weigh(case.belief, case.area)
    assert case.belief == pytest.approx(before * case.likelihood, rel=2e-3, abs=1e-6)
    case.said.take_back(case.belief, case.area)
    assert case.belief == pytest.approx(before, rel=1e-4)
