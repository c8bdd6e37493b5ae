"""A grid that skips what landmarks cannot make matter believes what a whole one does.

Whole beliefs are walked here, which takes compiled kernels: so no twin is asked.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.focus import FocusParams
from pilotage.localizer.landmark_model import weigh_landmarks
from pilotage.localizer.landmark_sightings import Sightings
from pilotage.localizer.markov_grid import MarkovGrid, MotionSpread
from pilotage.localizer.modes import find_modes
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid

SEEDS = st.integers(0, 2**32 - 1)
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
