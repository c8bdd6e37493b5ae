"""The places among the heaviest states."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pilotage.localizer.modes import (
    LEAST_MASS,
    MOST_MODES,
    apart,
    find_modes,
    find_modes_in_bins,
    is_within,
)

SEEDS = st.integers(0, 2**32 - 1)


Cloud = tuple[np.ndarray, np.ndarray]
"""Poses (n, 3) and weights (n,)."""


def cloud(centre: tuple[float, float, float], mass: float) -> Cloud:
    rng = np.random.default_rng(1)
    poses = np.array(centre) + rng.normal(0.0, [0.08, 0.05, 0.03], (400, 3))
    return poses, np.full(400, mass / 400)


def together(*clouds: Cloud) -> Cloud:
    return np.concatenate([poses for poses, _ in clouds]), np.concatenate([w for _, w in clouds])


def test_no_state_is_no_place() -> None:
    assert find_modes(np.empty((0, 3)), np.empty(0)) == []


def test_one_state_is_one_place() -> None:
    (mode,) = find_modes(np.array([[1.0, 2.0, 3.0]]), np.array([0.4]))
    assert mode.mass == pytest.approx(0.4)
    assert mode.pose == pytest.approx([1.0, 2.0, 3.0])
    assert mode.covariance == pytest.approx(np.zeros((3, 3)))


def test_each_cloud_is_a_place_with_its_mass_mean_and_covariance() -> None:
    places = find_modes(*together(cloud((1.0, 2.0, 0.5), 0.3), cloud((5.0, 2.0, 0.5), 0.6)))
    heavier, lighter = places
    assert heavier.mass == pytest.approx(0.6)
    assert lighter.mass == pytest.approx(0.3)
    assert heavier.pose == pytest.approx([5.0, 2.0, 0.5], abs=0.02)
    assert np.diag(heavier.covariance) == pytest.approx([0.08**2, 0.05**2, 0.03**2], rel=0.2)


def test_the_same_spot_seen_the_other_way_round_is_another_place() -> None:
    places = find_modes(*together(cloud((1.0, 2.0, 0.0), 0.5), cloud((1.0, 2.0, math.pi), 0.4)))
    assert [place.mass for place in places] == pytest.approx([0.5, 0.4])


def test_a_place_at_the_wrap_is_one_place() -> None:
    poses, weights = cloud((1.0, 2.0, math.pi), 1.0)
    poses[:, 2] = (poses[:, 2] + math.pi) % math.tau - math.pi
    (place,) = find_modes(poses, weights)
    assert abs(place.pose[2]) == pytest.approx(math.pi, abs=0.01)
    assert place.covariance[2, 2] == pytest.approx(0.03**2, rel=0.2)


def test_crumbs_are_no_places_unless_there_is_nothing_else() -> None:
    clouds = cloud((1.0, 0.0, 0.0), 0.9), cloud((9.0, 0.0, 0.0), 0.5 * LEAST_MASS)
    assert len(find_modes(*together(*clouds))) == 1
    assert len(find_modes(*clouds[1])) == 1


@given(SEEDS, st.integers(1, 60))
def test_places_share_no_state_and_come_by_falling_mass(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    poses = rng.uniform([-3.0, -3.0, -math.pi], [3.0, 3.0, math.pi], (count, 3))
    weights = rng.dirichlet(np.ones(count)) * rng.uniform(0.1, 1.0)
    modes = find_modes(poses, weights)
    masses = [mode.mass for mode in modes]
    assert 1 <= len(modes) <= MOST_MODES
    assert masses == sorted(masses, reverse=True)
    assert sum(masses) <= weights.sum() * (1.0 + 1e-9)
    for mode in modes:
        assert (np.linalg.eigvalsh(mode.covariance) >= -1e-12).all()


def test_a_place_is_known_no_better_than_its_bins_are_wide() -> None:
    poses, weights = np.tile([1.0, 2.0, 0.5], (4, 1)), np.full(4, 0.25)
    found = find_modes_in_bins(poses, weights, (0.6, 1.2))
    assert len(found) == 1
    assert np.diag(found[0].covariance) == pytest.approx([0.03, 0.03, 0.12])
    drawn = np.random.default_rng(5).uniform(-0.5, 0.5, (20_000, 3)) * (0.6, 0.6, 1.2)
    assert np.cov(drawn.T) == pytest.approx(found[0].covariance, abs=2e-3)


def test_within_means_half_a_metre_and_fifteen_degrees() -> None:
    centre = np.array([1.0, 1.0, math.pi - 0.05])
    poses = np.array(
        [[1.49, 1.0, math.pi - 0.05], [1.51, 1.0, math.pi - 0.05], [1.0, 1.0, -math.pi + 0.2]]
    )
    assert is_within(poses, centre).tolist() == [True, False, True]


def test_poses_are_apart_by_a_distance_and_the_shorter_turn() -> None:
    one, other = np.array([0.0, 0.0, 3.0]), np.array([3.0, 4.0, -3.0])
    assert apart(one, other) == pytest.approx((5.0, math.tau - 6.0))
