"""The twins shipped with the benchmark do what the product does."""

import numpy as np
import pytest
from numpy.typing import NDArray

from drawing import draw
from pilotage.bench.buildings import office_block
from pilotage.bench.reference import PlainField, PlainGrid
from pilotage.bench.reference_particles import PlainParticles
from pilotage.bench.reference_ranges import plain_range_layer
from pilotage.bench.walk import Sight, corridor_walk
from pilotage.core.grid import OccupancyMap
from pilotage.localizer.likelihood_field import LikelihoodFieldParams, likelihood_field
from pilotage.localizer.markov_grid import MarkovGrid, MotionSpread
from pilotage.localizer.particle_field import BeamModel, particle_field
from pilotage.localizer.particle_start import free_space
from pilotage.localizer.pose_grid import PoseGrid, PoseGridParams, pose_grid
from pilotage.localizer.range_model import (
    RangeModelParams,
    range_likelihoods,
    range_table,
    ranges_of_levels,
)

HEADINGS, RANGE_MAX = 24, 5.0
RANGERS = np.array([0.0, np.pi / 2.0, -np.pi / 2.0, np.pi])
EXACT = MotionSpread(0.0, 0.0, 0.0, 0.0)
COMPASS = (0.4, 0.2)
ROOM = draw(
    """
    ####################
    #..................#
    #..................#
    #......###.........#
    #......###.........#
    #..................#
    #.............#....#
    #.............#....#
    ####################
    """,
    resolution=0.2,
    origin=(-1.0, 2.0, 0.0),
)


@pytest.fixture
def states() -> PoseGrid:
    return pose_grid(ROOM, PoseGridParams(0.2, HEADINGS))


def shares(belief: NDArray[np.float32]) -> NDArray[np.float64]:
    held = belief.astype(np.float64)
    share: NDArray[np.float64] = held / held.sum()
    return share


def test_a_new_belief_is_even_in_both(states: PoseGrid) -> None:
    grid, plain = MarkovGrid(states, EXACT), PlainGrid(states, HEADINGS)
    assert shares(plain.belief) == pytest.approx(shares(grid.belief))


def test_ranges_and_compass_weigh_both_alike(states: PoseGrid) -> None:
    grid, plain = MarkovGrid(states, EXACT), PlainGrid(states, HEADINGS)
    table = range_table(ROOM, states.geometry, HEADINGS, RANGE_MAX)
    likelihoods = range_likelihoods(
        np.array([1.0, 0.6, 0.8, np.inf]), RANGE_MAX, RangeModelParams()
    )
    for one in (grid, plain):
        one.add_floor(1.0, COMPASS)
        one.weigh_ranges(RANGERS, likelihoods, table)
        one.settle()
    assert shares(plain.belief) == pytest.approx(shares(grid.belief), rel=1e-3, abs=1e-12)


def test_a_motion_moves_both_alike(states: PoseGrid) -> None:
    grid, plain = MarkovGrid(states, EXACT), PlainGrid(states, HEADINGS)
    table = range_table(ROOM, states.geometry, HEADINGS, RANGE_MAX)
    likelihoods = range_likelihoods(np.array([1.0, 0.6, 0.8, 1.2]), RANGE_MAX, RangeModelParams())
    for _ in range(4):
        grid.predict([0.17, 0.0, 0.2])
        plain.predict(np.array([0.17, 0.0, 0.2]), spreads=False)
        for one in (grid, plain):
            one.add_floor(0.5, None)
            one.weigh_ranges(RANGERS, likelihoods, table)
            one.settle()
    assert shares(plain.belief) == pytest.approx(shares(grid.belief), rel=1e-3, abs=1e-12)


def test_a_scan_weighs_both_alike_but_for_the_products_bytes(states: PoseGrid) -> None:
    params = LikelihoodFieldParams(class_limits=(1.0, 3.0))
    field = likelihood_field(ROOM, states.geometry, states.heading_step, params)
    grid, plain = MarkovGrid(states, EXACT), PlainGrid(states, HEADINGS)
    angles = np.linspace(-2.0, 2.0, 20)
    ends = np.stack([np.cos(angles), np.sin(angles)], axis=1) * np.linspace(0.4, 2.9, 20)[:, None]
    grid.add_floor(1.0)
    grid.weigh_scan(ends, field, 0.3)
    grid.settle()
    plain.add_floor(1.0, None)
    plain.weigh_scan(ends, PlainField(states, params), 0.3)
    plain.settle()
    assert shares(plain.belief) == pytest.approx(shares(grid.belief), rel=0.1, abs=1e-12)


def test_beams_beyond_the_last_class_weigh_nothing(states: PoseGrid) -> None:
    params = LikelihoodFieldParams(class_limits=(1.0,))
    plain = PlainGrid(states, 2)
    before = plain.belief.copy()
    plain.weigh_scan(np.array([[1.5, 0.0]]), PlainField(states, params), 1.0)
    assert plain.belief == pytest.approx(before)


def test_spreading_keeps_what_lies_inside(states: PoseGrid) -> None:
    plain = PlainGrid(states, HEADINGS)
    plain.belief[:] = 0.0
    plain.belief[3, 3, 9] = 1.0
    plain.predict(np.zeros(3))
    assert plain.belief.sum() == pytest.approx(1.0)
    assert plain.belief[2, 3, 9] == pytest.approx(plain.belief[4, 3, 9])
    assert plain.belief[3, 3, 10] == pytest.approx(plain.belief[3, 2, 9])


@pytest.mark.parametrize(
    ("increment", "cell"),
    [((0.4, 0.0, 0.0), (3, 7)), ((-0.2, 0.0, 0.0), (3, 4)), ((0.0, 0.4, 0.0), (5, 5))],
)
def test_the_twin_moves_by_whole_cells(
    states: PoseGrid, increment: tuple[float, float, float], cell: tuple[int, int]
) -> None:
    plain = PlainGrid(states, 1)
    plain.belief[:] = 0.0
    plain.belief[0, 3, 5] = 1.0
    plain.predict(np.array(increment), spreads=False)
    assert plain.belief[(0, *cell)] == 1.0


@pytest.mark.parametrize("resolution", [0.2, 0.4])
@pytest.mark.parametrize("direction", range(0, HEADINGS, 5))
def test_expected_ranges_are_those_of_the_table(resolution: float, direction: int) -> None:
    states = pose_grid(ROOM, PoseGridParams(resolution, HEADINGS))
    table = range_table(ROOM, states.geometry, HEADINGS, RANGE_MAX)
    plain = plain_range_layer(ROOM, states, direction * states.heading_step, RANGE_MAX)
    levels, ranges = table.levels[direction], ranges_of_levels(RANGE_MAX)
    steps = np.abs(plain - ranges[levels]) / np.gradient(ranges)[levels]
    is_free = states.admissible.mask > 0
    # A ray through a corner may take either cell.
    assert np.mean(steps[is_free] > 0.6) < 0.03


@pytest.fixture(scope="module")
def office() -> tuple[OccupancyMap, list[Sight]]:
    world = office_block(12.0)
    return world, corridor_walk(world, (1.5, 10.5, 5.0), 4)


def test_beams_weigh_particles_alike(office: tuple[OccupancyMap, list[Sight]]) -> None:
    world, walk = office
    ends = walk[0].scan.ends
    assert ends is not None
    poses = free_space(world).draw(200, np.random.default_rng(0))
    plain = PlainParticles(world, BeamModel(), poses, 0.15)
    product = particle_field(world, BeamModel()).log_likelihoods(poses, ends)
    assert plain.log_likelihoods(ends) == pytest.approx(product, rel=0.02, abs=1.5)


def test_plain_particles_follow_the_robot(office: tuple[OccupancyMap, list[Sight]]) -> None:
    world, walk = office
    rng = np.random.default_rng(0)
    poses = free_space(world).draw_around(walk[0].pose, np.diag([0.05, 0.05, 0.02]), 2000, rng)
    plain = PlainParticles(world, BeamModel(), poses, 0.3)
    for sight in [walk[0]] * 3:
        assert sight.scan.ends is not None
        plain.update(np.zeros(3), sight.scan.ends, rng)
    assert plain.poses.mean(axis=0)[:2] == pytest.approx(walk[0].pose[:2], abs=0.1)
    assert len(plain.poses) == 2000


def test_headings_of_plain_particles_are_wrapped(
    office: tuple[OccupancyMap, list[Sight]],
) -> None:
    world, walk = office
    assert walk[0].scan.ends is not None
    plain = PlainParticles(world, BeamModel(), np.array([[5.0, 5.0, 3.1]] * 50), 0.15)
    plain.update(np.array([0.0, 0.0, 0.2]), walk[0].scan.ends, np.random.default_rng(0))
    assert np.abs(plain.poses[:, 2]).max() <= np.pi
