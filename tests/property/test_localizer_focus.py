"""A belief of which little is worked on is that of one worked on as a whole, to a stated bound."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.raycast import cast_scan
from pilotage.localizer.focus import FocusParams
from pilotage.localizer.kernels import Area
from pilotage.localizer.likelihood_field import LikelihoodFieldParams, likelihood_field
from pilotage.localizer.markov_grid import MarkovGrid
from pilotage.localizer.modes import find_modes
from pilotage.localizer.motion_spread import MotionSpread
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid

SEEDS = st.integers(0, 2**32 - 1)
CELL, SIZE, HEADINGS = 0.2, 72, 24
BEARINGS = np.linspace(-math.pi, math.pi, 40, endpoint=False)
TIGHT = np.diag([0.02, 0.02, 0.01])
FIELD = LikelihoodFieldParams(class_limits=(4.0, 12.0))


def world_of(rng: np.random.Generator) -> OccupancyMap:
    """A hall with boxes of random places and sizes in it."""
    cells = np.zeros((SIZE, SIZE), np.int8)
    cells[[0, -1]], cells[:, [0, -1]] = 100, 100
    for row, col, high, wide in rng.integers((3, 3, 2, 2), (SIZE - 9, SIZE - 9, 9, 9), (14, 4)):
        cells[row : row + high, col : col + wide] = 100
    return OccupancyMap(GridGeometry(SIZE, SIZE, CELL), cells)


class Walk:
    """A robot that walks at random, and two beliefs of where it is: a focused and a whole one."""

    def __init__(self, seed: int, focus: FocusParams) -> None:
        self.rng = np.random.default_rng(seed)
        self.world = world_of(self.rng)
        states = pose_grid(self.world, PoseGridParams(CELL, HEADINGS))
        self.whole = MarkovGrid(states, MotionSpread(), FocusParams(least_states=10**9))
        self.focused = MarkovGrid(states, MotionSpread(), focus)
        self.field = likelihood_field(self.world, states.geometry, states.heading_step, FIELD)
        self.pose = self._free_pose()

    def begin_here(self) -> None:
        for grid in (self.whole, self.focused):
            grid.set_gaussian(self.pose, TIGHT)

    def carry_off(self) -> None:
        self.pose = self._free_pose()

    def look(self, weight: float = 1e-6) -> None:
        ranges = cast_scan(self.world, self.pose, BEARINGS, 12.0)
        ranges = np.where(np.isfinite(ranges), ranges, 99.0) + self.rng.normal(0.0, 0.03, 40)
        ends = ranges[:, None] * np.stack([np.cos(BEARINGS), np.sin(BEARINGS)], axis=1)
        for grid in (self.whole, self.focused):
            grid.add_floor(weight)
            grid.weigh_scan(ends, self.field, 0.3)
            grid.settle()

    def go(self) -> None:
        step = [self.rng.uniform(0.0, 0.3), 0.0, self.rng.normal(0.0, 0.3)]
        there = se2.compose(self.pose, step)
        cells = self.world.geometry.cells_of([there[:2]])
        is_free = self.world.geometry.contains(cells)[0] and self.world.is_free[tuple(cells[0])]
        if not is_free:
            step, there = [0.0, 0.0, 0.8], se2.compose(self.pose, [0.0, 0.0, 0.8])
        self.pose = there
        for grid in (self.whole, self.focused):
            grid.predict(step)

    def difference(self) -> float:
        """The total variation between the two, what is only bounded counting as different."""
        apart = np.abs(self.share(self.whole) - self.share(self.focused)).sum()
        return float(0.5 * (apart + self.focused.rest_mass))

    @staticmethod
    def share(grid: MarkovGrid) -> np.ndarray:
        return grid.belief.astype(np.float64) / grid.total

    def _free_pose(self) -> np.ndarray:
        free = self.world.geometry.centres_of(np.argwhere(self.world.is_free))
        return np.array([*free[self.rng.integers(len(free))], self.rng.uniform(-3.0, 3.0)])


def best(grid: MarkovGrid) -> np.ndarray:
    return find_modes(*grid.heaviest(20_000))[0].pose


def states_in(area: Area) -> int:
    return int((area.runs[:, 2] - area.runs[:, 1]).sum())


SMALL = FocusParams(least_states=0)


@settings(max_examples=12, deadline=None)
@given(SEEDS)
def test_a_tracked_robot_has_the_same_pose_and_a_belief_within_the_bound(seed: int) -> None:
    walk = Walk(seed, SMALL)
    walk.begin_here()
    for _ in range(6):
        walk.go()
        walk.look()
        assert walk.focused.rest_mass < SMALL.most
        assert walk.difference() <= walk.focused.rest_mass + 1e-5
        assert best(walk.focused) == pytest.approx(best(walk.whole), abs=1e-5)


@settings(max_examples=4, deadline=None)
@given(SEEDS)
def test_nothing_dropped_and_nothing_woken_late_is_the_whole_belief(seed: int) -> None:
    walk = Walk(seed, FocusParams(least_states=0, dropped=0.0, woken=0.0))
    walk.begin_here()
    for _ in range(2):
        walk.go()
        walk.look(0.0)
        share, whole = walk.share(walk.focused), walk.share(walk.whole)
        np.testing.assert_allclose(share, whole, rtol=2e-5, atol=1e-12)
        assert walk.focused.rest_mass == 0.0


@settings(max_examples=8, deadline=None)
@given(SEEDS)
def test_an_unknown_start_ends_at_the_same_place(seed: int) -> None:
    walk = Walk(seed, SMALL)
    for _ in range(8):
        walk.look()
        walk.go()
    walk.look()
    assert walk.difference() < 1e-3
    assert best(walk.focused) == pytest.approx(best(walk.whole), abs=1e-3)


@settings(max_examples=8, deadline=None)
@given(SEEDS)
def test_a_robot_carried_off_is_found_at_once_when_the_floor_says_so(seed: int) -> None:
    """As the localizer does when a scan contradicts the pose: all of the floor, everywhere."""
    walk = Walk(seed, SMALL)
    walk.begin_here()
    for _ in range(3):
        walk.go()
        walk.look()
    walk.carry_off()
    walk.look(1.0)
    assert walk.focused.rest_mass == 0.0
    assert walk.difference() < 1e-4


@settings(max_examples=8, deadline=None)
@given(SEEDS)
def test_a_robot_carried_off_unnoticed_is_found_by_the_floor_of_the_rest(seed: int) -> None:
    """What the rest may hold is woken when it matters: nobody has to say that it does."""
    walk = Walk(seed, SMALL)
    walk.begin_here()
    for _ in range(3):
        walk.go()
        walk.look()
    walk.carry_off()
    for _ in range(12):
        walk.look()
        walk.go()
    walk.look()
    assert best(walk.focused) == pytest.approx(best(walk.whole), abs=0.05)


@settings(max_examples=8, deadline=None)
@given(SEEDS)
def test_a_scan_that_speaks_for_another_place_has_everything_weighed_anew(seed: int) -> None:
    """Where the belief breaks down, so much of the rest may matter that all of it is opened."""
    walk = Walk(seed, SMALL)
    walk.begin_here()
    for _ in range(3):
        walk.go()
        walk.look(1e-5)
    walk.go()
    walk.carry_off()
    poor = walk.field
    walk.field = replace(poor, step=6.0 * poor.step)
    walk.look(1e-5)
    assert walk.focused.rest_mass < SMALL.most
    assert walk.difference() < 0.9
    walk.field = poor
    for _ in range(4):
        walk.look(1e-5)
        walk.go()
    walk.look(1e-5)
    assert best(walk.focused) == pytest.approx(best(walk.whole), abs=0.05)


@given(SEEDS)
@settings(max_examples=10, deadline=None)
def test_the_rest_holds_what_the_belief_does_not(seed: int) -> None:
    walk = Walk(seed, SMALL)
    walk.begin_here()
    walk.go()
    walk.look()
    walk.go()
    outside = np.ones(walk.focused.grid.shape, bool)
    area = walk.focused.area
    for k in range(HEADINGS):
        for row, first, last in area.runs[area.starts[k] : area.starts[k + 1]]:
            outside[k, row, first:last] = False
    assert not walk.focused.belief[outside].any()
    missed = walk.share(walk.whole)[outside].sum()
    assert missed <= walk.focused.rest_mass * 1.01 + 1e-9


def test_little_is_worked_on_while_a_robot_is_tracked() -> None:
    walk = Walk(4, SMALL)
    walk.begin_here()
    for _ in range(6):
        walk.go()
        walk.look()
    walk.go()
    assert states_in(walk.focused.area) < 0.2 * states_in(walk.whole.area)


def test_a_small_grid_is_worked_on_as_a_whole() -> None:
    walk = Walk(1, FocusParams())
    walk.begin_here()
    walk.go()
    walk.look()
    walk.go()
    assert np.array_equal(walk.focused.area.runs, walk.whole.area.runs)
    assert walk.focused.rest_mass == 0.0


def test_the_papers_floor_wakes_everything_at_every_scan() -> None:
    walk = Walk(2, SMALL)
    walk.begin_here()
    for _ in range(3):
        walk.go()
        walk.look(1.0)
    assert walk.difference() < 1e-6


def test_corrections_without_scans_do_not_let_the_rest_grow() -> None:
    """A compass alone weighs no tile: so everything is worked on again."""
    walk = Walk(5, SMALL)
    walk.begin_here()
    for _ in range(3):
        walk.go()
        walk.look()
    walk.go()
    for _ in range(40):
        for grid in (walk.whole, walk.focused):
            grid.add_floor(1e-6, (float(walk.pose[2]), 0.05))
            grid.settle()
        walk.go()
    assert walk.focused.rest_mass < 2.0 * SMALL.most
    assert walk.difference() < 2.0 * SMALL.most


def test_scaled_states_count_in_a_focused_belief_too() -> None:
    walk = Walk(3, SMALL)
    walk.begin_here()
    walk.go()
    walk.look()
    states, weights = walk.focused.heaviest_states(5)
    total = walk.focused.total
    walk.focused.scale_states(states, np.full(len(states), 0.5, np.float32))
    assert walk.focused.total == pytest.approx(total * (1.0 - 0.5 * weights.sum()), rel=1e-5)


def test_a_map_without_a_wall_tells_no_place_from_another() -> None:
    """All beams end nowhere, everywhere alike: an even belief stays even."""
    world = OccupancyMap(GridGeometry(30, 40, CELL), np.zeros((30, 40), np.int8))
    states = pose_grid(world, PoseGridParams(CELL, HEADINGS))
    grid = MarkovGrid(states, MotionSpread(), SMALL)
    field = likelihood_field(world, states.geometry, states.heading_step, FIELD)
    ends = 2.0 * np.stack([np.cos(BEARINGS), np.sin(BEARINGS)], axis=1)
    for _ in range(3):
        grid.add_floor(1e-6)
        grid.weigh_scan(ends, field, 0.3)
        grid.settle()
        grid.predict([0.0, 0.0, 0.3])
    share = grid.belief / grid.total
    assert share == pytest.approx(1.0 / states.admissible_states, rel=1e-4)


def test_a_symmetric_hall_keeps_a_symmetric_belief() -> None:
    """A hall turned by half a turn is the same hall: so is the belief, heading by heading."""
    cells = np.zeros((40, 60), np.int8)
    cells[[0, -1]], cells[:, [0, -1]] = 100, 100
    cells[10:14, 20:25], cells[26:30, 35:40] = 100, 100
    world = OccupancyMap(GridGeometry(40, 60, CELL), cells)
    states = pose_grid(world, PoseGridParams(CELL, HEADINGS))
    grid = MarkovGrid(states, MotionSpread(), SMALL)
    field = likelihood_field(world, states.geometry, states.heading_step, FIELD)
    ranges = cast_scan(world, [3.1, 2.3, 0.4], BEARINGS, 12.0)
    ends = ranges[:, None] * np.stack([np.cos(BEARINGS), np.sin(BEARINGS)], axis=1)
    for _ in range(3):
        grid.add_floor(1e-6)
        grid.weigh_scan(ends, field, 0.3)
        grid.settle()
    turned = np.roll(grid.belief, HEADINGS // 2, axis=0)[:, ::-1, ::-1]
    half = grid.belief[:, : states.geometry.rows // 2].sum(dtype=np.float64)
    assert half == pytest.approx(0.5 * grid.belief.sum(dtype=np.float64), rel=0.02)
    assert np.corrcoef(grid.belief.ravel(), turned.ravel())[0, 1] > 0.98
