"""Laws of a belief that moves: nothing is lost, nothing blurs, and there and back is nowhere."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.localizer.markov_grid import MarkovGrid
from pilotage.localizer.motion_spread import MotionSpread
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid

STILL = MotionSpread(0.0, 0.0, 0.0, 0.0)
SIZE, CELL, HEADINGS = 40, 0.2, 24
MIDDLE = SIZE * CELL / 2.0
TIGHT = np.diag([0.01, 0.01, 0.01])

ANGLES = st.floats(-math.pi, math.pi, exclude_max=True)
STEPS = st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), ANGLES)
PATHS = st.lists(STEPS, min_size=1, max_size=5)
ORIGINS = st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0), ANGLES)
SPREADS = st.builds(MotionSpread, *[st.floats(0.0, 0.2)] * 4)

HALL = np.zeros((SIZE, SIZE), np.int8)
PARAMS = PoseGridParams(CELL, HEADINGS)


def belief_at(
    theta: float,
    spread: MotionSpread = STILL,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> MarkovGrid:
    """A belief about the middle of an empty hall, some way from all edges."""
    world = OccupancyMap(GridGeometry(SIZE, SIZE, CELL, origin), HALL)
    belief = MarkovGrid(pose_grid(world, PARAMS), spread)
    belief.set_gaussian(se2.compose(origin, [MIDDLE, MIDDLE, theta]), TIGHT)
    return belief


def settled(belief: MarkovGrid) -> tuple[np.ndarray, np.ndarray]:
    """All states that weigh anything, as poses and weights."""
    belief.settle()
    states = np.argwhere(belief.belief > 0.0)
    return belief.poses_of(states), belief.belief[tuple(states.T)].astype(np.float64)


def mean_of(poses: np.ndarray, weights: np.ndarray) -> np.ndarray:
    share = weights / weights.sum()
    turned = np.arctan2(share @ np.sin(poses[:, 2]), share @ np.cos(poses[:, 2]))
    return np.array([*(share @ poses[:, :2]), turned])


@given(ANGLES, PATHS, SPREADS)
@settings(max_examples=25)
def test_motion_conserves_mass_away_from_the_edges(
    theta: float, path: list[tuple[float, float, float]], spread: MotionSpread
) -> None:
    belief = belief_at(theta, spread)
    mass = belief.belief.sum(dtype=np.float64)
    for step in path:
        belief.predict(step)
    assert belief.belief.sum(dtype=np.float64) == pytest.approx(mass, rel=1e-5)


@given(ANGLES, PATHS)
def test_there_and_back_restores_the_belief_bit_for_bit(
    theta: float, path: list[tuple[float, float, float]]
) -> None:
    belief = belief_at(theta)
    before = belief.belief.copy()
    poses_before, _ = settled(belief)
    for step in path:
        belief.predict(step)
    for step in reversed(path):
        belief.predict(se2.inverse(step))
    poses, _ = settled(belief)
    assert np.array_equal(belief.belief, before)
    assert poses[:, :2] == pytest.approx(poses_before[:, :2], abs=1e-9)
    assert wrap(poses[:, 2] - poses_before[:, 2]) == pytest.approx(np.zeros(len(poses)), abs=1e-9)


@given(ANGLES, PATHS, ORIGINS)
def test_each_state_moves_exactly_as_the_robot_does(
    theta: float, path: list[tuple[float, float, float]], origin: tuple[float, float, float]
) -> None:
    """Without noise motion neither rounds nor blurs, on a turned map as on any other."""
    belief = belief_at(theta, STILL, origin)
    poses, weights = settled(belief)
    moved = poses
    for step in path:
        belief.predict(step)
        moved = se2.compose(moved, step)
    there, weights_there = settled(belief)
    by_weight = np.argsort(weights, kind="stable"), np.argsort(weights_there, kind="stable")
    assert np.array_equal(weights[by_weight[0]], weights_there[by_weight[1]])
    # Layers keep their order and cells theirs, whatever offset they carry.
    assert np.sort(there[:, 0]) == pytest.approx(np.sort(moved[:, 0]), abs=1e-6)
    assert np.sort(there[:, 1]) == pytest.approx(np.sort(moved[:, 1]), abs=1e-6)
    assert mean_of(there, weights_there) == pytest.approx(mean_of(moved, weights), abs=1e-6)


@given(ANGLES, PATHS, SPREADS)
@settings(max_examples=25)
def test_noise_moves_the_mean_by_less_than_a_cell(
    theta: float, path: list[tuple[float, float, float]], spread: MotionSpread
) -> None:
    """What changes its layer is put into the nearest cell there, so parts of a cell are lost."""
    noisy, exact = belief_at(theta, spread), belief_at(theta)
    for step in path:
        noisy.predict(step)
        exact.predict(step)
    drift = se2.between(mean_of(*settled(exact)), mean_of(*settled(noisy)))
    assert np.hypot(*drift[:2]) < CELL
    assert abs(drift[2]) < 0.02


@given(st.floats(0.02, 0.2), st.integers(1, 12))
def test_way_adds_its_stated_variance_of_translation(per_root_m: float, steps: int) -> None:
    """All of it but what waits until it is worth a pass; other headings go elsewhere."""
    belief = belief_at(0.0, MotionSpread(per_root_m, 0.0, 0.0, 0.0))
    belief.belief[1:] = 0.0
    variance = spatial_variance(belief)
    for _ in range(steps):
        belief.predict([0.1, 0.0, 0.0])
    waiting = belief._due.of_cells * CELL**2
    added = spatial_variance(belief) - variance + waiting
    assert added == pytest.approx(np.full(2, per_root_m**2 * 0.1 * steps), rel=2e-3, abs=1e-7)


@given(st.floats(0.1, 0.4), st.integers(1, 8))
def test_turning_adds_its_stated_variance_of_heading(per_root_rad: float, steps: int) -> None:
    belief = belief_at(0.0, MotionSpread(0.0, 0.0, per_root_rad, 0.0))
    variance = heading_variance(belief)
    for _ in range(steps):
        belief.predict([0.0, 0.0, 0.1])
    waiting = belief._due.of_headings * belief.grid.heading_step**2
    added = heading_variance(belief) - variance + waiting
    assert added == pytest.approx(per_root_rad**2 * 0.1 * steps, rel=2e-3, abs=1e-6)


def spatial_variance(belief: MarkovGrid) -> np.ndarray:
    poses, weights = settled(belief)
    share = weights / weights.sum()
    away = poses[:, :2] - share @ poses[:, :2]
    return np.asarray(share @ away**2)


def heading_variance(belief: MarkovGrid) -> float:
    poses, weights = settled(belief)
    turn = wrap(poses[:, 2] - mean_of(poses, weights)[2])
    return float(weights @ turn**2 / weights.sum())


@given(ANGLES, st.integers(-3, 3))
def test_headings_wrap(theta: float, turns: int) -> None:
    belief = belief_at(theta)
    again = belief_at(theta)
    belief.predict([0.0, 0.0, 1.0])
    again.predict([0.0, 0.0, 1.0 + 2.0 * math.pi * turns])
    assert (np.abs(belief.headings) <= math.pi).all()
    assert wrap(belief.headings - again.headings) == pytest.approx(np.zeros(HEADINGS), abs=1e-9)
    assert np.array_equal(belief.belief, again.belief)


def test_motion_without_noise_never_blurs_a_belief() -> None:
    belief = belief_at(0.3)
    entropy = belief.entropy()
    for _ in range(200):
        belief.predict([0.03, 0.0, 0.09])
    belief.settle()
    assert belief.entropy() == pytest.approx(entropy, abs=1e-6)


def test_mass_that_leaves_the_map_is_gone() -> None:
    belief = belief_at(0.0)
    for _ in range(SIZE):
        belief.predict([0.3, 0.0, 0.0])
    belief.add_floor(0.0)
    belief.settle()
    assert belief.total == 0.0
