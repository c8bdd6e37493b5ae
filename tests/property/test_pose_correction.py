"""Laws of displacements, their fusion and the corrected pose, whatever the numbers."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import difference, wrap
from pilotage.core.motion import arc
from pilotage.mapper.displacement import (
    Displacement,
    DisplacementNoise,
    apart,
    displacement_covariance,
    fuse_increments,
    measured,
    polar,
    polar_jacobian,
    share_directions,
)
from pilotage.mapper.pose_correction import PoseCorrection, compound_jacobians

Array = NDArray[np.float64]
LENGTHS = st.floats(-5.0, 5.0) | st.sampled_from([0.0, -0.0, 1e-9, -1e-6])
ANGLES = st.floats(-3.1, 3.1) | st.sampled_from([0.0, 1e-9, -1e-9, -math.pi, 3.14159])
POSES = st.tuples(LENGTHS, LENGTHS, ANGLES).map(np.array)
SHARES = st.floats(0.0, 0.2)
WALKS = st.floats(0.0, 0.1)
FLOORS = st.floats(1e-4, 0.01)
NOISES = st.builds(DisplacementNoise, SHARES, SHARES, WALKS, WALKS, WALKS, FLOORS, FLOORS)
DISPLACEMENTS = st.builds(measured, POSES, NOISES, st.sampled_from([0.0, 1.0]))


def derivative(function: Callable[[Array], Array], at: Array) -> Array:
    """The Jacobian by central differences, angles of the result the shorter way round."""
    step = 1e-6
    columns = [
        apart(function(at + step * unit), function(at - step * unit)) / (2.0 * step)
        for unit in np.eye(len(at))
    ]
    return np.stack(columns, axis=1)


def is_positive(covariance: Array) -> bool:
    return bool(np.all(np.linalg.eigvalsh(covariance) > 0.0))


def from_polar(parts: Array) -> Array:
    phi, way, eta = parts
    return np.array([way * np.cos(phi), way * np.sin(phi), wrap(phi + eta)])


@given(ANGLES, LENGTHS, ANGLES)
def test_the_polar_jacobian_is_the_derivative_of_eq_2_10(
    phi: float, way: float, eta: float
) -> None:
    numeric = derivative(from_polar, np.array([phi, way, eta]))
    assert polar_jacobian(phi, way) == pytest.approx(numeric, abs=1e-5)


@given(POSES)
def test_polar_parts_give_the_increment_again(increment: Array) -> None:
    parts = polar(increment)
    assert apart(from_polar(np.array(parts)), increment) == pytest.approx(np.zeros(3), abs=1e-8)
    assert abs(parts[0]) <= math.pi / 2.0 + 1e-12 or increment[0] == increment[1] == 0.0


@given(POSES, POSES)
def test_compound_jacobians_are_the_derivatives_of_a_composition(
    before: Array, displacement: Array
) -> None:
    h, k = compound_jacobians(before, se2.compose(before, displacement))
    by_before = derivative(lambda pose: se2.compose(pose, displacement), before)
    by_displacement = derivative(lambda step: se2.compose(before, step), displacement)
    assert h == pytest.approx(by_before, abs=1e-5)
    assert k == pytest.approx(by_displacement, abs=1e-5)


@given(st.floats(-2.0, 2.0), st.floats(-1.5, 1.5), st.floats(0.01, 0.2), st.floats(0.01, 0.2))
def test_shares_err_as_a_longer_arc_would(
    way: float, turn: float, way_share: float, turn_share: float
) -> None:
    noise = DisplacementNoise(way_share, turn_share)
    increment = arc(np.zeros(3), way, turn, 1.0)
    tiny = 1e-6
    longer = arc(np.zeros(3), way * (1.0 + tiny * way_share), turn, 1.0)
    directions = share_directions(increment, noise)
    assert directions[:, 0] == pytest.approx((longer - increment) / tiny, abs=1e-4)
    # A turn that errs lets the chord be: its length differs in second order only.
    assert directions[2, 1] == pytest.approx(turn * turn_share, abs=1e-9)


@given(LENGTHS, st.sampled_from([1e-3, 1e-6, 1e-9, 0.0]))
def test_an_arc_that_hardly_turns_is_a_straight_way(way: float, turn: float) -> None:
    noise = DisplacementNoise(0.05, 0.03)
    bent, straight = arc(np.zeros(3), way, turn, 1.0), np.array([way, 0.0, 0.0])
    assert bent == pytest.approx(straight, abs=5.0 * turn + 1e-12)
    covariances = [displacement_covariance(one, noise) for one in (bent, straight)]
    assert covariances[0] == pytest.approx(covariances[1], abs=0.1 * turn + 1e-12)


@given(DISPLACEMENTS)
def test_covariances_are_symmetric_and_positive(one: Displacement) -> None:
    assert np.array_equal(one.covariance, one.covariance.T)
    assert is_positive(one.covariance)


@given(DISPLACEMENTS, DISPLACEMENTS)
def test_fused_is_surer_than_either(one: Displacement, other: Displacement) -> None:
    fused = fuse_increments(one, other)
    assert np.array_equal(fused.covariance, fused.covariance.T)
    for single in (one, other):
        gained = np.linalg.eigvalsh(single.covariance - fused.covariance)
        assert gained.min() >= -1e-9 * np.trace(single.covariance)


@given(DISPLACEMENTS, DISPLACEMENTS)
def test_it_does_not_matter_which_measurement_comes_first(
    one: Displacement, other: Displacement
) -> None:
    if abs(abs(difference(float(one.increment[2]), float(other.increment[2]))) - math.pi) < 1e-6:
        return  # Opposite directions have two ways round.
    ab, ba = fuse_increments(one, other), fuse_increments(other, one)
    assert apart(ab.increment, ba.increment) == pytest.approx(np.zeros(3), abs=1e-6)
    assert ab.covariance == pytest.approx(ba.covariance, abs=1e-8)


@given(DISPLACEMENTS, DISPLACEMENTS)
def test_fusion_is_the_weighted_mean_by_inverse_covariances(
    one: Displacement, other: Displacement
) -> None:
    weights = [np.linalg.inv(single.covariance) for single in (one, other)]
    covariance = np.linalg.inv(weights[0] + weights[1])
    off = apart(other.increment, one.increment)
    increment = one.increment + covariance @ weights[1] @ off
    fused = fuse_increments(one, other)
    assert apart(fused.increment, increment) == pytest.approx(np.zeros(3), abs=1e-5)
    assert fused.covariance == pytest.approx(covariance, abs=1e-6)


@given(
    st.lists(
        st.tuples(
            POSES,
            st.none() | st.tuples(st.floats(-1.0, 1.0), st.floats(-2.0, 2.0)),
            st.none() | st.tuples(st.floats(-10.0, 10.0), st.floats(0.01, 1.0)),
        ),
        max_size=20,
    )
)
def test_whatever_comes_the_pose_stays_finite_and_its_covariance_positive(
    steps: list[tuple[Array, tuple[float, float] | None, tuple[float, float] | None]],
) -> None:
    correction = PoseCorrection()
    for increment, command, heading in steps:
        pose, covariance = correction.step(increment, 0.1, command, heading)
        assert np.isfinite(pose).all()
        assert -math.pi <= pose[2] < math.pi
        assert covariance == pytest.approx(covariance.T, abs=1e-9)
        assert is_positive(covariance)
