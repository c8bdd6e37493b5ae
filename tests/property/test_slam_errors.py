"""Covariances of poses: moved, turned round and joined as random errors would be."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pilotage.core import se2
from pilotage.mapper.odometry_drift import (
    DriftParams,
    drift_covariance,
    moved_covariance,
    turned_covariance,
)
from pilotage.mapper.pose_edges import Edge, adjoint, inverted, joined, mismatch, reversed_edge

SEEDS = st.integers(0, 10_000)
POSES = st.builds(
    lambda x, y, theta: np.array([x, y, theta]),
    st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0),
    st.floats(-3.1, 3.1),
)
SAMPLES = 40_000


def covariance(seed: int, size: float = 0.01) -> np.ndarray:
    """Any covariance (3, 3) with standard deviations of about `size`."""
    root = size * np.random.default_rng(seed).normal(size=(3, 3))
    spread: np.ndarray = root @ root.T + (0.1 * size) ** 2 * np.eye(3)
    return spread


def edge(seed: int, relative: np.ndarray, ends: tuple[int, int] = (0, 1)) -> Edge:
    return Edge(*ends, relative, covariance(seed))


def errors(seed: int, spread: np.ndarray) -> np.ndarray:
    return np.random.default_rng(seed).multivariate_normal(np.zeros(3), spread, SAMPLES)


def is_spread_as(samples: np.ndarray, expected: np.ndarray) -> bool:
    """Whether samples have this covariance, each direction to 5 %."""
    whitener = np.linalg.inv(np.linalg.cholesky(expected))
    found = whitener @ np.cov(samples.T) @ whitener.T
    return bool(np.abs(found - np.eye(3)).max() < 0.05)


@given(POSES, SEEDS)
def test_a_motion_in_the_frame_of_a_pose_is_the_adjoint_one_outside(
    pose: np.ndarray, seed: int
) -> None:
    motion = 1e-5 * np.random.default_rng(seed).normal(size=3)
    inside = se2.compose(pose, motion)
    outside = se2.compose(adjoint(pose) @ motion, pose)
    assert inside == pytest.approx(outside, abs=1e-8)


@given(POSES, POSES)
def test_adjoints_compose_as_poses_do(one: np.ndarray, two: np.ndarray) -> None:
    together = adjoint(one) @ adjoint(two)
    assert together == pytest.approx(adjoint(se2.compose(one, two)), abs=1e-9)


@given(POSES, SEEDS)
def test_an_edge_reversed_twice_is_the_edge(relative: np.ndarray, seed: int) -> None:
    there = edge(seed, relative)
    again = reversed_edge(reversed_edge(there))
    assert again.ends == there.ends
    assert again.relative == pytest.approx(there.relative)
    assert again.covariance == pytest.approx(there.covariance, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_a_reversed_edge_errs_as_the_way_back_does(seed: int) -> None:
    there = edge(seed, np.array([1.5, -0.8, 2.0]))
    back = reversed_edge(there)
    seen = se2.inverse(se2.compose(there.relative, errors(seed, there.covariance)))
    assert back.ends == (1, 0)
    assert is_spread_as(se2.between(back.relative, seen), back.covariance)


@pytest.mark.parametrize("seed", range(3))
def test_joined_edges_err_as_one_way_after_the_other(seed: int) -> None:
    one = edge(seed, np.array([1.5, -0.8, 2.0]))
    two = edge(seed + 10, np.array([-0.4, 0.9, -1.0]), (1, 7))
    both = joined(one, two)
    way = se2.compose(
        se2.compose(one.relative, errors(seed, one.covariance)),
        se2.compose(two.relative, errors(seed + 10, two.covariance)),
    )
    assert both.ends == (0, 7)
    assert is_spread_as(se2.between(both.relative, way), both.covariance)


@given(POSES, POSES, POSES, SEEDS)
def test_it_does_not_matter_which_edges_are_joined_first(
    a: np.ndarray, b: np.ndarray, c: np.ndarray, seed: int
) -> None:
    one, two, three = edge(seed, a), edge(seed + 1, b, (1, 2)), edge(seed + 2, c, (2, 3))
    left, right = joined(joined(one, two), three), joined(one, joined(two, three))
    assert se2.between(left.relative, right.relative) == pytest.approx(0.0, abs=1e-9)
    assert left.covariance == pytest.approx(right.covariance, rel=1e-6, abs=1e-12)
    assert left.ends == right.ends == (0, 3)


@given(POSES, POSES, SEEDS)
def test_reversing_joined_edges_joins_the_reversed(a: np.ndarray, b: np.ndarray, seed: int) -> None:
    one, two = edge(seed, a), edge(seed + 1, b, (1, 2))
    whole = reversed_edge(joined(one, two))
    parts = joined(reversed_edge(two), reversed_edge(one))
    assert se2.between(whole.relative, parts.relative) == pytest.approx(0.0, abs=1e-9)
    assert whole.covariance == pytest.approx(parts.covariance, rel=1e-6, abs=1e-12)


def test_an_edge_that_has_a_closure_in_it_is_one() -> None:
    way = edge(1, np.array([1.0, 0.0, 0.0]))
    closure = Edge(1, 2, np.zeros(3), covariance(2), is_closure=True)
    assert joined(way, closure).is_closure
    assert reversed_edge(closure).is_closure
    assert not joined(way, edge(2, np.zeros(3), (1, 2))).is_closure


@given(POSES, POSES, SEEDS)
def test_poses_that_an_edge_says_do_not_contradict_it(
    first: np.ndarray, relative: np.ndarray, seed: int
) -> None:
    second = se2.compose(first, relative)
    assert mismatch(edge(seed, relative), first, second) == pytest.approx(0.0, abs=1e-5)


def test_a_mismatch_is_counted_in_standard_deviations() -> None:
    told = Edge(0, 1, np.array([2.0, 0.0, 0.0]), np.diag([0.1, 0.2, 0.3]) ** 2)
    assert mismatch(told, np.zeros(3), np.array([2.3, 0.0, 0.0])) == pytest.approx(3.0)
    assert mismatch(told, np.zeros(3), np.array([2.0, 0.4, 0.0])) == pytest.approx(2.0)
    assert mismatch(told, np.zeros(3), np.array([2.0, 0.0, -0.3])) == pytest.approx(1.0)


@given(POSES, POSES, POSES, SEEDS)
def test_a_mismatch_is_the_same_from_either_end(
    first: np.ndarray, relative: np.ndarray, off: np.ndarray, seed: int
) -> None:
    told = edge(seed, relative)
    second = se2.compose(se2.compose(first, relative), 1e-6 * off)
    there = mismatch(told, first, second)
    assert mismatch(reversed_edge(told), second, first) == pytest.approx(there, rel=1e-3, abs=1e-6)


@given(SEEDS)
def test_information_inverted_is_covariance(seed: int) -> None:
    spread = covariance(seed)
    assert inverted(inverted(spread)) == pytest.approx(spread, rel=1e-6, abs=1e-12)
    assert inverted(spread) @ spread == pytest.approx(np.eye(3), abs=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_a_moved_pose_errs_as_poses_and_increments_do(seed: int) -> None:
    """Along the axes of the frame that the pose is in; the increment's along the pose's."""
    pose, increment = np.array([0.7, -1.1, 2.2]), np.array([0.9, 0.3, -0.4])
    spread, drift = covariance(seed), covariance(seed + 10)
    poses = pose + errors(seed, spread)
    moved = se2.compose(poses, increment + errors(seed + 10, drift))
    off = moved - se2.compose(pose, increment)
    expected = moved_covariance(pose, spread, increment, drift)
    assert is_spread_as(off, expected)


@given(POSES, SEEDS)
def test_a_pose_that_does_not_move_gains_only_the_drift(pose: np.ndarray, seed: int) -> None:
    spread, drift = covariance(seed), covariance(seed + 1)
    stayed = moved_covariance(pose, spread, np.zeros(3), drift)
    turned = turned_covariance(float(pose[2]), drift)
    assert stayed == pytest.approx(spread + turned, abs=1e-12)


@given(st.floats(-math.pi, math.pi), SEEDS)
def test_turning_axes_there_and_back_changes_nothing(angle: float, seed: int) -> None:
    spread = covariance(seed)
    turned = turned_covariance(angle, spread)
    assert turned_covariance(-angle, turned) == pytest.approx(spread, abs=1e-12)
    assert np.trace(turned) == pytest.approx(np.trace(spread))
    assert turned[2, 2] == pytest.approx(spread[2, 2])


@given(st.floats(-math.pi, math.pi), SEEDS)
def test_a_keyframes_error_in_its_own_axes_is_that_of_an_edge(angle: float, seed: int) -> None:
    """The front end turns what is known of a pose along the map's axes into an edge's."""
    pose = np.array([0.3, 0.1, angle])
    spread = covariance(seed, 1e-6)
    root = np.linalg.cholesky(spread)
    moved = np.array([se2.between(pose, pose + column) for column in root.T])
    expected = turned_covariance(-angle, spread)
    assert moved.T @ moved == pytest.approx(expected, rel=1e-4, abs=1e-18)


@given(POSES)
def test_drift_is_a_covariance_and_grows_with_the_way(increment: np.ndarray) -> None:
    near = drift_covariance(0.5 * increment, DriftParams())
    far = drift_covariance(increment, DriftParams())
    assert near == pytest.approx(near.T)
    assert np.linalg.eigvalsh(near)[0] > 0.0
    assert np.diag(far)[2] >= np.diag(near)[2]
    assert np.trace(far) >= np.trace(near)


def test_who_stands_drifts_by_next_to_nothing() -> None:
    params = DriftParams(standing=(0.004, 0.002))
    expected = np.diag([0.004**2, 0.004**2, 0.002**2])
    assert drift_covariance(np.zeros(3), params) == pytest.approx(expected)


def test_drift_ahead_moves_sideways_with_the_heading() -> None:
    """Half of the turn that is wrong at the end was wrong on the way."""
    drift = drift_covariance(np.array([2.0, 0.0, 0.0]), DriftParams())
    assert drift[1, 2] == pytest.approx(1.0 * drift[2, 2])
    assert drift[0, 2] == 0.0
    assert drift[1, 1] == pytest.approx(drift[0, 0] + drift[2, 2])
