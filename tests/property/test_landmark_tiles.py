"""What is not worked on state by state is weighed by landmarks too: bounded, and woken in time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import landmarks as naive
from naive.markov import tile_sums
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer import kernels
from pilotage.localizer.focus import FocusParams
from pilotage.localizer.kernels import SIDE, Admissible
from pilotage.localizer.landmark_kernels import KnownSightings
from pilotage.localizer.landmark_model import weigh_landmarks
from pilotage.localizer.landmark_sightings import Sightings
from pilotage.localizer.landmark_states import SightingsLikelihood
from pilotage.localizer.markov_grid import MarkovGrid, MotionSpread
from pilotage.localizer.modes import find_modes
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid
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


ROWS, COLS, CELL, HEADINGS = 40, 60, 0.2, 24
POSTS = LandmarkMap(
    np.array([[1.0, 1.0], [11.0, 2.0], [6.0, 7.0], [2.5, 6.5], [9.0, 6.0]]),
    ("post",) * 5,
    tuple("abcde"),
)
"""In an empty hall of 12 m x 8 m."""

SMALL = FocusParams(least_states=0)


class Walk:
    """A robot that walks among posts, and two beliefs: a focused and a whole one."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        world = OccupancyMap(GridGeometry(ROWS, COLS, CELL), np.zeros((ROWS, COLS), np.int8))
        states = pose_grid(world, PoseGridParams(CELL, HEADINGS))
        whole = FocusParams(least_states=10**9)
        self.whole = MarkovGrid(states, MotionSpread(), whole)
        self.focused = MarkovGrid(states, MotionSpread(), SMALL)
        self.pose = self.anywhere()
        for grid in (self.whole, self.focused):
            grid.set_gaussian(self.pose, np.diag([0.02, 0.02, 0.01]))

    def anywhere(self) -> np.ndarray:
        return self.rng.uniform((2.0, 2.0, -3.0), (10.0, 6.0, 3.0))

    def go_and_look(self) -> None:
        step = [0.1, 0.0, 0.3]
        self.pose = se2.compose(self.pose, step)
        seen = self.sightings()
        for grid in (self.whole, self.focused):
            grid.predict(step)
            grid.add_floor(1e-6)
            weigh_landmarks(grid, seen, POSTS)
            grid.settle()

    def sightings(self) -> Sightings:
        x, y = se2.transform_points(se2.inverse(self.pose), POSTS.positions).T
        count = len(x)
        return Sightings(
            ranges=np.hypot(x, y) + self.rng.normal(0.0, 0.1, count),
            bearings=np.arctan2(y, x) + self.rng.normal(0.0, 0.03, count),
            range_sigmas=np.full(count, 0.15),
            bearing_sigmas=np.full(count, 0.05),
            kinds=("post",) * count,
            identities=POSTS.identities,
        )

    def difference(self) -> float:
        """The total variation between the two, what is only bounded counting as different."""
        shares = [
            grid.belief.astype(np.float64) / grid.total for grid in (self.whole, self.focused)
        ]
        return float(0.5 * (np.abs(shares[0] - shares[1]).sum() + self.focused.rest_mass))


def best(grid: MarkovGrid) -> np.ndarray:
    return find_modes(*grid.heaviest(20_000))[0].pose


@settings(max_examples=8, deadline=None)
@given(SEEDS)
def test_among_landmarks_little_is_worked_on_and_the_belief_is_that_of_the_whole(seed: int) -> None:
    walk = Walk(seed)
    for _ in range(6):
        walk.go_and_look()
        assert walk.focused.rest_mass < SMALL.most
        assert walk.difference() <= walk.focused.rest_mass + 1e-5
        assert best(walk.focused) == pytest.approx(best(walk.whole), abs=1e-4)
    assert not np.array_equal(walk.focused.area.runs, walk.whole.area.runs)


@settings(max_examples=12, deadline=None)
@given(SEEDS)
def test_a_robot_carried_off_is_found_by_landmarks_alone_as_if_nothing_were_skipped(
    seed: int,
) -> None:
    """The posts speak for places that hold but a bound: these are woken, nobody has to say so."""
    walk = Walk(seed)
    for _ in range(3):
        walk.go_and_look()
    walk.pose = walk.anywhere()
    for _ in range(6):
        walk.go_and_look()
        assert walk.focused.rest_mass < SMALL.most
    assert best(walk.whole) == pytest.approx(walk.pose, abs=0.5)
    assert best(walk.focused) == pytest.approx(best(walk.whole), abs=0.01)
