"""Laws of matching features: its kernels do what their twins do, and frames do not matter."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from feature_scenes import SIGMA_PLACE, SIGMA_TURN, long_corridor, seen_from, uneven_corridor
from naive import node_matching as naive
from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.topology.at_nodes.matching import MatchParams, NodeMatch, match_features
from pilotage.topology.at_nodes.matching_hypotheses import FeaturePairs, possible_pairs
from pilotage.topology.at_nodes.matching_kernels import (
    choose_pairs,
    count_votes,
    normal_equations,
    pair_residuals,
    solve_three,
)
from pilotage.topology.features import Features

SEEDS = st.integers(0, 2**32 - 1)
WINDOW = (0.7, 0.45)
VARIANCE = 0.07**2


def random_pairs(rng: np.random.Generator) -> tuple[FeaturePairs, tuple[int, int]]:
    """Return pairs of things seen in a corridor, right and wrong ones."""
    world = uneven_corridor()
    truth = np.array([rng.uniform(0.5, 3.0), rng.uniform(-0.5, 0.5), rng.uniform(-3.0, 3.0)])
    seen = seen_from(truth, world, rng)
    return possible_pairs(seen, world, truth, (1.5, 0.8), 0.5), (len(seen), len(world))


def random_poses(rng: np.random.Generator, count: int) -> np.ndarray:
    poses: np.ndarray = rng.uniform([-1.0, -1.0, -np.pi], [4.0, 1.0, np.pi], (count, 3))
    return poses


@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_votes_are_those_of_the_plain_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pairs, counts = random_pairs(rng)
    poses = random_poses(rng, 5)
    spreads = rng.uniform(0.1, 4.0, (len(pairs), 2))
    votes = count_votes(poses, pairs.places, spreads, pairs.members, counts)
    np.testing.assert_allclose(
        votes, naive.count_votes(poses, pairs.places, spreads, pairs.members, counts), atol=1e-9
    )


@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_distances_are_those_of_the_plain_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pairs, _ = random_pairs(rng)
    spread = rng.uniform(-0.1, 0.1, (len(pairs), 2, 2, 2))
    covariances = spread @ spread.transpose(0, 1, 3, 2) + 1e-3 * np.eye(2)
    pose = random_poses(rng, 1)[0]
    distances = pair_residuals(pose, pairs.places, covariances, VARIANCE)[2]
    plain = naive.pair_distances(pose, pairs.places, covariances, VARIANCE)
    np.testing.assert_allclose(distances, plain, rtol=1e-7)


@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_a_step_is_that_of_the_plain_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pairs, _ = random_pairs(rng)
    if len(pairs) == 0:
        return
    covariances = pairs.covariances + 1e-3 * np.eye(2)
    pose = random_poses(rng, 1)[0]
    residuals, weights, _ = pair_residuals(pose, pairs.places, covariances, VARIANCE)
    information, pull = normal_equations(pose, pairs.places, residuals, weights, VARIANCE)
    stepped = pose + solve_three(information, pull)
    plain = naive.step(pose, pairs.places, covariances, VARIANCE)
    np.testing.assert_allclose(stepped, plain, atol=1e-5)


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_three_equations_are_solved(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3, 3))
    matrix, right = root @ root.T + 0.1 * np.eye(3), rng.normal(size=3)
    np.testing.assert_allclose(matrix @ solve_three(matrix, right), right, atol=1e-8)


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_no_feature_is_in_two_pairs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    members = rng.integers(0, 6, (30, 2))
    distances = rng.uniform(0.0, 20.0, 30)
    chosen = choose_pairs(distances, members, (6, 6), 11.0)
    assert (distances[chosen] <= 11.0).all()
    for side in (0, 1):
        kept = members[chosen, side]
        assert len(np.unique(kept)) == len(kept)
    # None that could have been taken was left out.
    for i, j in members[(distances <= 11.0) & ~chosen]:
        assert i in members[chosen, 0] or j in members[chosen, 1]


@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_where_the_map_lies_does_not_matter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world, truth = uneven_corridor(), np.array([0.8, 0.1, 0.2])
    seen = seen_from(truth, world, rng)
    prior = truth + rng.uniform(-0.3, 0.3, 3)
    moved = rng.uniform([-50.0, -50.0, -np.pi], [50.0, 50.0, np.pi])
    here = found(seen, world, prior)
    there = found(seen, world.moved(moved), se2.compose(moved, prior))
    off = se2.compose(moved, here.pose) - there.pose
    off[2] = wrap(float(off[2]))
    np.testing.assert_allclose(off, 0.0, atol=1e-5)
    np.testing.assert_array_equal(here.pairs, there.pairs)


@settings(max_examples=25, deadline=None)
@given(SEEDS)
def test_the_order_of_features_does_not_matter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world, truth = uneven_corridor(), np.array([0.8, 0.1, 0.2])
    seen = seen_from(truth, world, rng)
    prior = truth + rng.uniform(-0.3, 0.3, 3)
    order, turned = rng.permutation(len(seen)), rng.permutation(len(world))
    here = found(seen, world, prior)
    there = found(seen.chosen(order), world.chosen(turned), prior)
    np.testing.assert_allclose(here.pose, there.pose, atol=1e-6)
    back = np.stack([order[there.pairs[:, 0]], turned[there.pairs[:, 1]]], axis=1)
    assert {tuple(pair) for pair in here.pairs} == {tuple(pair) for pair in back}


def found(seen: Features, world: Features, prior: np.ndarray) -> NodeMatch:
    match = match_features(seen, world, prior, WINDOW)
    assert match is not None
    return match


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_a_prior_wrong_by_half_a_metre_and_20_degrees_is_made_good(seed: int) -> None:
    rng = np.random.default_rng(seed)
    world = long_corridor()
    truth = np.array([rng.uniform(1.0, 24.0), rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4)])
    seen = seen_from(truth, world, rng, missed=0.2, reach=6.0)
    near = world.chosen(np.abs(world.poses[:, 0] - truth[0] - 2.0) < 5.0)
    bearing = rng.uniform(-np.pi, np.pi)
    wrong = [0.5 * np.cos(bearing), 0.5 * np.sin(bearing), rng.choice([-1.0, 1.0]) * 0.349]
    match = match_features(seen, near, truth + wrong, WINDOW)
    if match is None or not match.is_clear or len(match.pairs) < 3:
        return
    off = match.pose - truth
    assert np.hypot(off[0], off[1]) < 0.3
    assert abs(wrap(float(off[2]))) < 0.15


def test_the_covariance_of_a_match_is_honest() -> None:
    """The mean squared Mahalanobis distance of the truth is that of three degrees of freedom."""
    rng = np.random.default_rng(11)
    world = uneven_corridor()
    params = MatchParams(direction_sigma=SIGMA_TURN, place_sigma=1e-6, shared=(0.0, 0.0))
    distances = []
    for _ in range(1500):
        truth = np.array([rng.uniform(0.4, 1.5), rng.uniform(-0.4, 0.4), rng.uniform(-0.4, 0.4)])
        seen = seen_from(truth, world, rng)
        mapped = world.poses.copy()
        mapped[:, :2] += rng.normal(0.0, SIGMA_PLACE, (len(world), 2))
        bound = Features(world.kinds, mapped, world.widths, world.covariances)
        match = match_features(seen, bound, truth + rng.uniform(-0.3, 0.3, 3), WINDOW, params)
        if match is not None and match.is_clear and len(match.pairs) >= 3:
            off = match.pose - truth
            off[2] = wrap(float(off[2]))
            distances.append(off @ np.linalg.solve(match.covariance, off))
    assert len(distances) > 1000
    assert 2.6 < np.mean(distances) < 3.4
    assert 0.02 < np.mean(np.array(distances) > 7.81) < 0.09
