"""The tables that weigh a state, each entry against what the naive twin says of it."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from naive import markov as naive
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.range_table import expected_ranges
from pilotage.localizer.compass import compass_likelihood
from pilotage.localizer.likelihood_field import STEPS, LikelihoodFieldParams, likelihood_field
from pilotage.localizer.range_model import (
    LEVELS,
    RangeModelParams,
    levels_of,
    range_likelihoods,
    range_table,
    ranges_of_levels,
)
from pilotage.localizer.visibility import (
    VisibilityParams,
    even_levels,
    levels_allowed,
    optimistic_ranges,
)

SEEDS = st.integers(0, 2**32 - 1)
ANGLES = st.floats(-math.pi, math.pi, exclude_max=True)
ORIGINS = st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0), ANGLES)
HEADINGS = 5


def random_world(seed: int, origin: tuple[float, float, float]) -> OccupancyMap:
    rng = np.random.default_rng(seed)
    rows, cols = rng.integers(2, 8, 2)
    cells = np.where(rng.random((rows, cols)) < 0.2, 100, 0).astype(np.int8)
    return OccupancyMap(GridGeometry(int(rows), int(cols), 0.5, origin), cells)


def meets_corners(turn: float) -> bool:
    """Rays from cell centres along a diagonal run through corners: rounding decides."""
    eighth = turn % (math.pi / 4.0)
    return min(eighth, math.pi / 4.0 - eighth) < 1e-6


@settings(max_examples=25)
@given(SEEDS, ORIGINS, st.floats(0.5, 6.0))
def test_range_table_holds_each_expected_range_in_one_byte(
    seed: int, origin: tuple[float, float, float], range_max: float
) -> None:
    world = random_world(seed, origin)
    table = range_table(world, world.geometry, HEADINGS, range_max)
    kept = ranges_of_levels(range_max)
    for k, row, col in np.ndindex(table.levels.shape):
        direction = 2.0 * math.pi * k / HEADINGS
        assume(not meets_corners(direction - origin[2]))
        centre = naive.cell_centre(world.geometry, row, col)
        expected = naive.expected_range(world, centre, direction, range_max)
        level = int(table.levels[k, row, col])
        nearest = np.abs(kept - expected).min()
        assert abs(kept[level] - expected) <= nearest + 0.02 * range_max / LEVELS


@given(st.floats(0.5, 80.0))
def test_levels_stand_for_rising_ranges_the_finer_the_nearer(range_max: float) -> None:
    ranges = ranges_of_levels(range_max)
    steps = np.diff(ranges)
    assert (ranges[0], ranges[-1]) == (0.0, pytest.approx(range_max))
    assert np.all(np.diff(steps) > 0.0)
    assert steps[0] < 0.3 * range_max / LEVELS
    assert np.array_equal(levels_of(ranges, range_max), np.arange(LEVELS + 1))
    assert levels_of(np.array([2.0 * range_max, np.inf]), range_max).tolist() == [LEVELS] * 2


@given(st.floats(0.0, 6.0), st.floats(0.02, 1.0), st.floats(0.001, 0.5), st.floats(0.01, 1.0))
def test_ranges_are_as_likely_as_equation_5_says(
    measured: float, delta: float, outlier: float, no_echo: float
) -> None:
    params = RangeModelParams(delta, outlier, no_echo)
    likelihood = range_likelihoods(np.array([measured, np.inf]), 4.0, params)
    for level in range(LEVELS + 1):
        expected = float(ranges_of_levels(4.0)[level])
        for row, value in ((0, measured), (1, math.inf)):
            model = (delta, outlier, no_echo)
            twin = naive.range_likelihood(value, expected, 4.0, model)
            assert likelihood[row, level] == pytest.approx(twin, rel=1e-5)


def test_the_likeliest_expected_range_is_the_measured_one() -> None:
    measured = np.array([0.4, 1.7, 3.3])
    likelihood = range_likelihoods(measured, 4.0, RangeModelParams())
    best = ranges_of_levels(4.0)[likelihood.argmax(axis=1)]
    assert best == pytest.approx(measured, abs=3.5 / LEVELS)
    assert (likelihood > 0.0).all()


def test_an_echo_from_beyond_the_reach_of_the_table_tells_of_a_far_wall() -> None:
    """A sensor ahead of the robot's centre hears walls that the table no longer holds."""
    far = range_likelihoods(np.array([4.1]), 4.0, RangeModelParams(outlier=0.05))[0]
    assert far.argmax() == LEVELS
    assert far[LEVELS // 2] == pytest.approx(0.05, rel=1e-4)


def test_no_echo_is_likeliest_where_nothing_is_within_reach() -> None:
    silence = range_likelihoods(np.array([np.inf]), 4.0, RangeModelParams(no_echo=0.2))[0]
    assert silence.argmax() == LEVELS
    assert silence[:LEVELS] == pytest.approx(0.2)


@settings(max_examples=25)
@given(SEEDS, ORIGINS, st.floats(0.05, 0.5), st.floats(0.005, 0.3))
def test_field_holds_the_cost_of_each_end_by_class_of_range(
    seed: int, origin: tuple[float, float, float], sigma: float, outlier: float
) -> None:
    world = random_world(seed, origin)
    params = LikelihoodFieldParams(sigma, outlier, (1.0, 2.0))
    step = 2.0 * math.pi / 36
    field = likelihood_field(world, world.geometry, step, params)
    for index, middle in enumerate((0.5, 1.5)):
        spread = math.sqrt(sigma**2 + (0.5**2 + (middle * step) ** 2) / 12.0)
        for row, col in np.ndindex(world.geometry.shape):
            centre = naive.cell_centre(world.geometry, row, col)
            distance = naive.distance_at(world, centre)
            expected = -math.log(naive.end_likelihood(distance, spread, outlier))
            kept = field.costs[index, row + field.margin, col + field.margin] * field.step
            assert kept == pytest.approx(expected, abs=0.51 * field.step)


def test_ends_beyond_the_map_cost_the_most_however_far_a_beam_reaches() -> None:
    world = random_world(1, (0.0, 0.0, 0.0))
    field = likelihood_field(world, world.geometry, 0.1, LikelihoodFieldParams(class_limits=(3.0,)))
    assert field.margin * world.geometry.resolution >= 3.0
    edge = np.ones(field.costs.shape[1:], bool)
    edge[field.margin : -field.margin, field.margin : -field.margin] = False
    assert (field.costs[0][edge] == STEPS).all()


@given(st.lists(st.floats(0.0, 20.0), min_size=1, max_size=9))
def test_each_beam_belongs_to_the_class_of_its_range(ranges: list[float]) -> None:
    world = random_world(2, (0.0, 0.0, 0.0))
    limits = (2.0, 4.0, 8.0)
    field = likelihood_field(world, world.geometry, 0.1, LikelihoodFieldParams(class_limits=limits))
    classes = field.classes_of(np.array(ranges))
    expected = [sum(reading > limit for limit in limits) for reading in ranges]
    assert classes.tolist() == expected


@settings(max_examples=25)
@given(SEEDS, ORIGINS)
def test_optimistic_range_is_the_largest_of_a_states_neighbours(
    seed: int, origin: tuple[float, float, float]
) -> None:
    world = random_world(seed, origin)
    params = VisibilityParams(reach=3.0)
    ranges = expected_ranges(world, world.geometry, HEADINGS, params.reach)
    plain = even_levels(ranges, params.reach)
    optimistic = optimistic_ranges(world, world.geometry, HEADINGS, params).levels
    for state in np.ndindex(plain.shape):
        assert optimistic[state] == naive.largest_neighbour(plain, state)


@given(st.floats(0.0, 40.0), st.floats(0.0, 20.0))
def test_a_beam_goes_through_a_wall_only_beyond_the_margin(
    measured: float, expected: float
) -> None:
    params = VisibilityParams(reach=16.0, margin=0.3)
    level = round(min(expected, 16.0) * LEVELS / 16.0)
    goes_through = level < levels_allowed(np.array([measured]), params)[0]
    excess = min(measured, 16.0) - min(expected, 16.0)
    level_width = 16.0 / LEVELS
    if goes_through:
        assert excess > params.margin - level_width
    else:
        assert excess <= params.margin + 2.0 * level_width


@given(ANGLES, ANGLES, st.floats(0.05, 2.0))
def test_compass_follows_equation_12(yaw: float, heading: float, sigma: float) -> None:
    likelihood = compass_likelihood(np.array([heading]), yaw, sigma, outlier=0.0)[0]
    assert likelihood == pytest.approx(
        naive.compass_likelihood(yaw, heading, sigma**2 / 2.0), rel=1e-9, abs=1e-300
    )


@given(ANGLES, ANGLES, st.floats(0.05, 2.0), st.integers(-3, 3))
def test_compass_is_periodic_and_best_at_the_heading_itself(
    yaw: float, heading: float, sigma: float, turns: int
) -> None:
    turned = heading + 2.0 * math.pi * turns
    here, there, best = compass_likelihood(np.array([heading, turned, yaw]), yaw, sigma)
    assert there == pytest.approx(here, rel=1e-6)
    assert best == 1.0
    assert here <= best


@given(st.floats(0.01, 0.1), st.floats(-4.0, 4.0))
def test_a_good_compass_is_a_gaussian_of_its_own_variance(sigma: float, away: float) -> None:
    likelihood = compass_likelihood(np.array([away * sigma]), 0.0, sigma, outlier=0.0)[0]
    assert likelihood == pytest.approx(
        math.exp(-0.5 * away**2), rel=2.0 * sigma**2 * away**4 + 1e-9
    )


@given(st.floats(0.02, 0.3))
def test_variance_of_the_compass_tends_to_sigma_squared(sigma: float) -> None:
    headings = np.linspace(-math.pi, math.pi, 20001)
    likelihood = compass_likelihood(headings, 0.0, sigma, outlier=0.0)
    variance = float(likelihood @ headings**2) / likelihood.sum()
    assert variance == pytest.approx(sigma**2, rel=sigma**2)


def test_iron_nearby_can_turn_a_compass_by_any_angle() -> None:
    assert compass_likelihood(np.array([math.pi]), 0.0, 0.1)[0] == pytest.approx(0.01)
