"""Laws of what a look may be expected to tell, and that the kernels do what their twins say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from naive import active as naive
from pilotage.planner.expected_scans import SightParams, _compared
from pilotage.planner.information import drawn, entropy, expected_gain

seeds = st.integers(0, 2**32 - 1)


@st.composite
def beliefs(draw: st.DrawFn, most: int = 12) -> NDArray[np.float64]:
    """Weights (n,), some of them zero, some much larger than others."""
    parts = st.one_of(st.just(0.0), st.floats(0.01, 1.0), st.floats(50.0, 100.0))
    weights = np.array(draw(st.lists(parts, min_size=1, max_size=most)))
    weights[draw(st.integers(0, len(weights) - 1))] += 1.0
    shares: NDArray[np.float64] = weights / weights.sum()
    return shares


def counted(count: int, seed: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return how often each of some places is drawn, and the belief of which that is true."""
    times = np.random.default_rng(seed).integers(1, 5, count)
    return times, times / times.sum()


def likelihoods(looks: NDArray[np.float64], truths: NDArray[np.int64]) -> NDArray[np.float32]:
    """Return log likelihoods (m, n) of places that look like points (n, 2) of a plane."""
    off = looks[truths][:, None, :] - looks[None, :, :]
    logs: NDArray[np.float32] = (-0.5 * (off**2).sum(axis=2)).astype(np.float32)
    return logs


@given(beliefs())
def test_the_entropy_is_that_of_the_definition(weights: NDArray[np.float64]) -> None:
    assert entropy(weights) == pytest.approx(naive.entropy(weights))
    assert -1e-12 <= entropy(weights) <= np.log2(len(weights)) + 1e-9


@given(beliefs(), seeds)
def test_the_gain_is_that_of_bayes(weights: NDArray[np.float64], seed: int) -> None:
    rng = np.random.default_rng(seed)
    looks = rng.normal(0.0, rng.choice([0.1, 1.0, 20.0]), (len(weights), 2))
    logs = likelihoods(looks, drawn(weights, 7))
    expected = naive.expected_gain(logs, weights)
    assert expected_gain(logs, weights) == pytest.approx(expected, abs=1e-6)


@given(beliefs(), st.floats(-50.0, 0.0), st.integers(1, 9))
def test_nothing_is_told_where_every_place_would_show_the_same(
    weights: NDArray[np.float64], logs: float, count: int
) -> None:
    same = np.full((count, len(weights)), logs, np.float32)
    assert expected_gain(same, weights) == pytest.approx(0.0, abs=1e-9)


@given(st.integers(1, 9), seeds)
def test_everything_is_told_where_all_places_differ(count: int, seed: int) -> None:
    times, weights = counted(count, seed)
    truths = drawn(weights, int(times.sum()))
    logs = np.full((len(truths), count), -40.0, np.float32)
    logs[np.arange(len(truths)), truths] = 0.0
    assert expected_gain(logs, weights) == pytest.approx(entropy(weights), abs=1e-9)


@given(beliefs(), seeds)
def test_no_look_tells_more_than_there_is_to_know(weights: NDArray[np.float64], seed: int) -> None:
    rng = np.random.default_rng(seed)
    logs = rng.uniform(-rng.choice([1.0, 100.0]), 0.0, (5, len(weights))).astype(np.float32)
    assert expected_gain(logs, weights) <= entropy(weights) + 1e-6


@given(st.integers(1, 9), st.integers(2, 9), seeds)
def test_on_average_no_observation_makes_the_belief_less_sure(
    places: int, outcomes: int, seed: int
) -> None:
    """Of observations with likelihoods that sum to one, each coming as often as it is likely."""
    rng = np.random.default_rng(seed)
    _, weights = counted(places, seed)
    channel = rng.dirichlet(np.full(outcomes, 0.3), places) + 1e-6
    channel /= channel.sum(axis=1, keepdims=True)
    shares = weights @ channel
    logs = np.log(channel.T).astype(np.float32)
    gains = np.array([expected_gain(row[None], weights) for row in logs])
    assert shares @ gains >= -1e-6


@given(st.integers(2, 9), seeds)
def test_places_that_are_told_apart_or_not_at_all_never_cost_knowledge(
    count: int, seed: int
) -> None:
    """Every place drawn by its weight: as many bits as there are between the groups."""
    times, weights = counted(count, seed)
    groups = np.random.default_rng(seed).integers(0, 3, count)
    truths = drawn(weights, int(times.sum()))
    logs = np.where(groups[truths][:, None] == groups, 0.0, -40.0).astype(np.float32)
    between = entropy(np.bincount(groups, weights))
    assert expected_gain(logs, weights) == pytest.approx(between, abs=1e-9)


@given(st.integers(2, 12), seeds)
def test_looks_that_shade_into_each_other_cost_next_to_nothing(count: int, seed: int) -> None:
    """The likelihoods of a scan do not sum to one over all scans; that is felt only here."""
    rng = np.random.default_rng(seed)
    times, weights = counted(count, seed)
    looks = rng.normal(0.0, rng.choice([0.05, 0.3, 1.0, 5.0]), (count, 2))
    logs = likelihoods(looks, drawn(weights, int(times.sum())))
    assert expected_gain(logs, weights) > -0.02


@given(st.integers(2, 9), seeds)
def test_the_order_of_places_does_not_matter(count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    times, weights = counted(count, seed)
    looks, order = rng.normal(0.0, 1.0, (count, 2)), rng.permutation(count)
    many = int(times.sum())
    one = expected_gain(likelihoods(looks, drawn(weights, many)), weights)
    other = expected_gain(likelihoods(looks[order], drawn(weights[order], many)), weights[order])
    assert one == pytest.approx(other, abs=1e-5)


@given(beliefs(), st.integers(1, 40))
def test_each_place_is_drawn_as_often_as_it_weighs_give_or_take_one(
    weights: NDArray[np.float64], count: int
) -> None:
    indices = drawn(weights, count)
    assert len(indices) == count
    often = np.bincount(indices, minlength=len(weights))
    assert (np.abs(often - count * weights) <= 1.0 + 1e-9).all()
    assert (often[weights == 0.0] == 0).all()
    assert (np.diff(indices) >= 0).all()


@given(st.integers(1, 5), st.integers(1, 6), seeds)
def test_scans_are_compared_beam_by_beam(beams: int, places: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    params = SightParams(beams=beams)
    scans = rng.uniform(0.0, 12.0, (beams, places)).astype(np.float32)
    scans[:, rng.integers(places)] = scans[:, 0]
    truths = rng.integers(0, places, 4)
    spread = params.sigma, params.sigma_per_metre
    compared = _compared(scans, truths, spread, params.bound, params.tempering)
    assert compared == pytest.approx(naive.log_likelihoods(scans, truths, params), abs=1e-4)
    assert (compared[np.arange(4), truths] == 0.0).all()
    assert (compared >= -params.tempering * params.bound * beams - 1e-5).all()
