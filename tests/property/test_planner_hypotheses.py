"""Laws of a belief reduced to places."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from naive import active as naive
from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.planner.hypotheses import ALIKE, NEAR, likely, merged
from pilotage.planner.information import entropy
from pilotage.planner.situation import Hypotheses

seeds = st.integers(0, 2**32 - 1)


@st.composite
def clouds(draw: st.DrawFn) -> Hypotheses:
    """Samples about a few places, at any heading, some of them weighing nothing."""
    rng = np.random.default_rng(draw(seeds))
    centres = rng.uniform(-3.0, 3.0, (draw(st.integers(1, 5)), 3))
    spread = rng.choice([0.0, 0.1, 1.0])
    poses = rng.choice(centres, draw(st.integers(1, 40)))
    poses = poses + rng.normal(0.0, spread, poses.shape)
    poses[:, 2] = wrap(poses[:, 2])
    weights = rng.choice([0.0, 1.0, 5.0], len(poses)) * rng.random(len(poses))
    weights[0] += 0.1
    return Hypotheses(poses, weights / weights.sum())


@given(clouds(), st.integers(1, 10))
def test_places_are_those_of_the_twin(cloud: Hypotheses, most: int) -> None:
    ours, theirs = merged(cloud, most), naive.merged(cloud, NEAR, ALIKE, most)
    assert ours.weights == pytest.approx(theirs.weights)
    assert ours.poses[:, :2] == pytest.approx(theirs.poses[:, :2])
    assert wrap(ours.poses[:, 2] - theirs.poses[:, 2]) == pytest.approx(0.0, abs=1e-9)


@given(clouds())
def test_places_hold_the_whole_belief_the_heaviest_first(cloud: Hypotheses) -> None:
    places = merged(cloud)
    assert places.weights.sum() == pytest.approx(1.0)
    assert (places.weights > 0.0).all()
    assert (np.diff(places.weights) <= 0.0).all()
    assert np.isfinite(places.poses).all()
    assert (np.abs(places.poses[:, 2]) <= np.pi).all()


@given(clouds())
def test_every_sample_lies_near_a_place(cloud: Hypotheses) -> None:
    places = merged(cloud)
    for pose in cloud.poses[cloud.weights > 0.0]:
        off = places.poses - pose
        # Both within reach of the sample that the place began with.
        is_near = np.hypot(off[:, 0], off[:, 1]) <= 2.0 * NEAR + 1e-9
        assert (is_near & (np.abs(wrap(off[:, 2])) <= 2.0 * ALIKE + 1e-9)).any()


@given(clouds())
def test_no_place_is_made_up_of_samples_that_each_lie_near_another_place(
    cloud: Hypotheses,
) -> None:
    """The samples that places begin with lie out of each other's reach; their means may not."""
    again = merged(merged(cloud))
    assert len(again.weights) <= len(merged(cloud).weights)
    assert entropy(again.weights) <= entropy(merged(cloud).weights) + 1e-9
    assert entropy(merged(cloud).weights) <= entropy(cloud.weights) + 1e-9


@given(seeds, st.integers(1, 9))
def test_places_out_of_each_others_reach_stay_what_they_are(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    poses = np.column_stack([2.0 * NEAR * np.arange(count), np.zeros((count, 2))])
    weights = np.sort(rng.dirichlet(np.ones(count)))[::-1] + 1e-9
    places = merged(Hypotheses(rng.permutation(poses), weights / weights.sum()))
    assert len(places.weights) == count
    again = merged(places)
    assert again.poses == pytest.approx(places.poses)
    assert again.weights == pytest.approx(places.weights)


@given(seeds)
def test_a_turn_through_the_wrap_is_one_place(seed: int) -> None:
    rng = np.random.default_rng(seed)
    headings = wrap(np.pi + rng.uniform(-0.5 * ALIKE, 0.5 * ALIKE, 20))
    poses = np.column_stack([np.zeros((20, 2)), headings])
    places = merged(Hypotheses(poses, np.full(20, 0.05)))
    assert len(places.weights) == 1
    assert abs(wrap(float(places.poses[0, 2]) - np.pi)) <= 0.5 * ALIKE


@given(clouds(), st.floats(0.05, 1.0))
def test_the_likely_places_are_the_fewest_that_hold_the_share(
    cloud: Hypotheses, share: float
) -> None:
    places = merged(cloud)
    few = likely(places, share)
    count = len(few.weights)
    assert few.weights.sum() == pytest.approx(1.0)
    assert places.weights[:count].sum() >= share * (1.0 - 1e-8)
    assert places.weights[: count - 1].sum() < share
    assert (few.poses == places.poses[:count]).all()


@given(clouds(), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_moving_all_places_there_and_back_changes_none(
    cloud: Hypotheses, x: float, y: float, turn: float
) -> None:
    there = np.array([x, y, turn])
    back = cloud.moved(there).moved(se2.inverse(there))
    assert back.poses[:, :2] == pytest.approx(cloud.poses[:, :2], abs=1e-9)
    assert wrap(back.poses[:, 2] - cloud.poses[:, 2]) == pytest.approx(0.0, abs=1e-9)
    assert (back.best == back.poses[np.argmax(cloud.weights)]).all()
