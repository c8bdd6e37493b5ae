"""Laws of the sonar grids, and their kernels beside their twins."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from naive import sonar as naive
from pilotage.core import se2
from pilotage.mapper import arc_median, sonar_arcs, sonar_kernels, temporal_filter
from pilotage.mapper.sonar_grid import SonarGrid, SonarGridParams
from pilotage.mapper.sonar_models import ARC_POINT, KERNEL_OF, BeamShape, SonarModel
from pilotage.mapper.sonar_news import SonarNewsParams
from pilotage.mapper.sonar_ring import SonarRing

MODEL = st.integers(0, ARC_POINT)
NAMES: st.SearchStrategy[SonarModel] = st.sampled_from(sorted(KERNEL_OF))
ANGLE = st.floats(-math.pi, math.pi)
HALF_CONE = 0.22
BEAM = BeamShape(HALF_CONE, 0.05, 1.2, 0.6, 0.84, 0.05)
SEEDS = st.integers(0, 10_000)
ENDLESS = SonarGridParams(limit=1e6, news=SonarNewsParams(least_travel=0.0))


def random_echoes(seed: int, count: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    low = [-1.0, -1.0, -math.pi, 0.1, -0.2]
    return rng.uniform(low, [1.0, 1.0, math.pi, 1.5, 0.2], (count, 5))


def random_arcs(seed: int, count: int) -> np.ndarray:
    """Arcs of sonars around a place, so that many of them cross there."""
    rng = np.random.default_rng(seed)
    arcs = rng.uniform([-1.5, -1.5, 0, 0], [1.5, 1.5, 0, 0], (count, 4))
    arcs[:, 2] = np.arctan2(-arcs[:, 1], -arcs[:, 0]) + rng.uniform(-0.15, 0.15, count)
    arcs[:, 3] = np.hypot(arcs[:, 0], arcs[:, 1]) + rng.uniform(-0.02, 0.02, count)
    return arcs[arcs[:, 3] > 0.05]


@given(MODEL, SEEDS)
@settings(max_examples=25)
def test_cells_get_what_the_formulas_say(model: int, seed: int) -> None:
    echoes = random_echoes(seed, 4)
    cells = np.zeros((24, 30), np.float32)
    corner = -1.31, -1.17
    sonar_kernels.add_readings(cells, corner, 0.1, echoes, model, BEAM)
    expected = naive.add_readings(np.zeros_like(cells), corner, 0.1, echoes, (model, BEAM))
    assert cells == pytest.approx(expected, abs=1e-3)  # the Gaussian's tail is cut


@given(MODEL, st.floats(0.0, 2.0), st.floats(0.0, 1.5), st.floats(0.1, 1.5))
def test_left_of_the_axis_is_as_right_of_it(
    model: int, distance: float, offset: float, reading: float
) -> None:
    heard = np.array([0.0, 0.0, 0.0, reading, 0.0])
    left = sonar_kernels.certainty_at(model, distance, offset, heard, BEAM)
    assert left == sonar_kernels.certainty_at(model, distance, -offset, heard, BEAM)


@given(MODEL, st.floats(0.0, 2.0), st.floats(-1.5, 1.5), st.floats(0.1, 1.5))
def test_certainty_is_less_than_one_and_none_behind_the_echo(
    model: int, distance: float, offset: float, reading: float
) -> None:
    heard = np.array([0.0, 0.0, 0.0, reading, 0.0])
    sure = sonar_kernels.certainty_at(model, distance, offset, heard, BEAM)
    assert abs(sure) <= BEAM.point_certainty
    if distance > reading + 2.0 * BEAM.depth:
        assert abs(sure) < 1e-3


@given(st.floats(0.1, 1.0), st.floats(0.3, 2.0))
def test_bayes_has_no_jump(offset_share: float, reading: float) -> None:
    heard = np.array([0.0, 0.0, 0.0, reading, 0.0])
    way = np.linspace(0.0, reading + 0.2, 4000)
    offset = offset_share * HALF_CONE
    sure = [sonar_kernels.certainty_at(KERNEL_OF["bayes"], d, offset, heard, BEAM) for d in way]
    assert np.abs(np.diff(sure)).max() < 0.05


@given(NAMES, SEEDS)
@settings(max_examples=30)
def test_known_cells_lie_in_the_cones(model: SonarModel, seed: int) -> None:
    rng = np.random.default_rng(seed)
    ring = SonarRing(rng.uniform(-0.1, 0.1, (3, 3)) * [1, 1, 30], 2.0 * HALF_CONE, 2.0)
    grid, poses = SonarGrid(ENDLESS, ring, model), rng.uniform(-1, 1, (4, 3))
    ranges = rng.uniform(0.1, 1.0, (4, 3))
    for pose, heard in zip(poses, ranges, strict=True):
        grid.insert(pose, heard)
    world = grid.map()
    known = world.geometry.centres_of(np.argwhere(world.cells >= 0))
    seen = np.zeros(len(known), bool)
    for pose, heard in zip(poses, ranges, strict=True):
        for x, y, theta, reading in ring.readings(pose, heard):
            local = se2.transform_points(se2.inverse([x, y, theta]), known)
            distance, aside = np.hypot(*local.T), np.abs(np.arctan2(local[:, 1], local[:, 0]))
            near_axis = np.abs(local[:, 1]) <= 0.026
            point_beside = distance * (aside - HALF_CONE) <= 0.06
            seen |= (distance <= reading + 0.3) & (near_axis | point_beside)
    assert seen.all()


@given(SEEDS)
def test_order_of_rounds_does_not_matter_to_bayes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ring = SonarRing(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.5]]), 0.4, 4.0)
    rounds = [(rng.uniform(-1, 1, 3), rng.uniform(0.1, 1.9, 2)) for _ in range(7)]
    forward, backward = SonarGrid(ENDLESS, ring, "bayes"), SonarGrid(ENDLESS, ring, "bayes")
    for pose, heard in rounds:
        forward.insert(pose, heard)
    for pose, heard in reversed(rounds):
        backward.insert(pose, heard)
    first, second = forward.map(), backward.map()
    assert first.geometry == second.geometry
    assert np.abs(first.cells.astype(int) - second.cells).max() <= 1


@given(SEEDS)
def test_crossings_are_those_of_plane_geometry(seed: int) -> None:
    arcs = random_arcs(seed, 9)
    found = sonar_arcs.all_crossings(arcs, HALF_CONE, math.radians(30.0))
    expected = naive.crossings(arcs, HALF_CONE, math.radians(30.0))
    assert len(found) == len(expected)
    if expected:
        by_place = np.lexsort(found.T[[1, 0, 4, 3]])
        paper = np.array(expected)
        assert found[by_place] == pytest.approx(paper[np.lexsort(paper.T[[1, 0, 4, 3]])], abs=1e-6)


@given(SEEDS)
def test_a_crossing_lies_on_both_arcs(seed: int) -> None:
    arcs = random_arcs(seed, 12)
    for x, y, angle, first, second in sonar_arcs.all_crossings(arcs, HALF_CONE, 0.1):
        assert 0.1 <= angle <= math.pi / 2.0 + 1e-9
        for index in (int(first), int(second)):
            local = se2.transform_points(se2.inverse(arcs[index, :3]), [[x, y]])[0]
            assert math.hypot(*local) == pytest.approx(arcs[index, 3])
            assert abs(math.atan2(local[1], local[0])) <= HALF_CONE + 1e-9


@given(SEEDS, st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), ANGLE)
def test_who_turns_the_world_turns_its_crossings(
    seed: int, x: float, y: float, theta: float
) -> None:
    arcs, motion = random_arcs(seed, 10), np.array([x, y, theta])
    turned = arcs.copy()
    turned[:, :3] = se2.compose(motion, arcs[:, :3])
    before = sonar_arcs.all_crossings(arcs, HALF_CONE, 0.5)
    after = sonar_arcs.all_crossings(turned, HALF_CONE, 0.5)
    assume(len(before) == len(after))  # one at the very end of an arc may be rounded away
    assert after[:, :2] == pytest.approx(se2.transform_points(motion, before[:, :2]), abs=1e-6)
    assert after[:, 2:] == pytest.approx(before[:, 2:], abs=1e-6)


@given(SEEDS, st.sampled_from(["atm", "improved_atm"]), st.floats(0.0, 0.06))
def test_echoes_are_placed_as_on_paper(seed: int, model: str, least_score: float) -> None:
    arcs = random_arcs(seed, 9)
    weights = np.random.default_rng(seed).uniform(0.1, 1.0, 12)
    rule = model == "improved_atm", math.radians(30.0), weights, least_score
    placed = arc_median.place_echoes(arcs, 0, len(arcs), 2.0 * HALF_CONE, rule)
    expected = [naive.place_on_arc(arcs, i, 2.0 * HALF_CONE, rule) for i in range(len(arcs))]
    assert placed == pytest.approx(np.array(expected).reshape(-1, 2), abs=1e-6)


@given(SEEDS)
def test_an_echo_stays_on_its_arc(seed: int) -> None:
    arcs = random_arcs(seed, 12)
    for improved in (False, True):
        rule = improved, 0.5, np.ones(12), 0.0
        placed = arc_median.place_echoes(arcs, 0, len(arcs), 2.0 * HALF_CONE, rule)
        assert (np.abs(placed[:, 0]) <= HALF_CONE).all()


@given(SEEDS)
def test_slices_close_as_whole_arrays_do(seed: int) -> None:
    rng = np.random.default_rng(seed)
    log_odds, window = rng.normal(0.0, 2.0, (2, 5, 6)).astype(np.float32)
    window[rng.random((5, 6)) < 0.3] = 0.0
    votes, counts = rng.integers(0, 256, (5, 6)), rng.integers(0, 9, (5, 6))
    layers = log_odds, window, votes.astype(np.uint8), counts.astype(np.uint8)
    expected = naive.close_slice(layers, 3.0, temporal_filter.LEAST_SAID)
    temporal_filter.close_slice(*layers, 3.0)
    for changed, wanted in zip(layers, expected, strict=True):
        assert changed == pytest.approx(wanted, abs=1e-6)
