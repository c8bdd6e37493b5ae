"""Sightings of landmarks against their plain twin, over particles and over the Markov grid."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import particles as naive
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.localizer.landmark_model import OUTLIER, landmark_likelihoods, weigh_landmarks
from pilotage.localizer.landmark_sightings import Sightings
from pilotage.localizer.markov_grid import MarkovGrid, MotionSpread
from pilotage.localizer.pose_grid import PoseGridParams, pose_grid

seeds = st.integers(0, 2**32 - 1)


def landmarks(rng: np.random.Generator, count: int) -> LandmarkMap:
    kinds = tuple(rng.choice(["post", "goal"], count))
    names = tuple(f"n{i}" if rng.random() < 0.5 else None for i in range(count))
    return LandmarkMap(rng.uniform(-4.0, 4.0, (count, 2)), kinds, names)


def sightings(rng: np.random.Generator, count: int) -> Sightings:
    return Sightings(
        ranges=rng.uniform(0.0, 6.0, count),
        bearings=rng.uniform(-4.0, 4.0, count),
        range_sigmas=rng.uniform(0.1, 0.9, count),
        bearing_sigmas=rng.uniform(0.05, 1.0, count),
        kinds=tuple(rng.choice(["post", "goal", "flag"], count)),
        identities=tuple(("n0", "n1", "n7", None)[i] for i in rng.integers(4, size=count)),
    )


@given(seeds, st.integers(0, 6), st.integers(0, 4))
def test_poses_are_as_likely_as_the_twin_says(seed: int, mapped: int, seen: int) -> None:
    rng = np.random.default_rng(seed)
    world, sighted = landmarks(rng, mapped), sightings(rng, seen)
    poses = rng.uniform(-4.0, 4.0, (15, 3))
    logs = landmark_likelihoods(poses, sighted, world)
    twin = [naive.sightings_log_likelihood(pose, sighted, world, OUTLIER) for pose in poses]
    # A fit of less than e^-12.5 counts as none.
    assert logs == pytest.approx(np.array(twin), abs=1e-3)
    assert (logs <= 1e-12).all()
    assert (logs >= seen * np.log(OUTLIER) - 1e-9).all()


@settings(max_examples=20)
@given(seeds, st.integers(1, 3), st.floats(-3.0, 3.0), st.floats(0.1, 1.0))
def test_the_grids_states_are_weighed_as_their_poses(
    seed: int, seen: int, turn: float, novelty: float
) -> None:
    rng = np.random.default_rng(seed)
    cells = np.where(rng.random((7, 9)) < 0.8, 0, 100).astype(np.int8)
    cells[3, 4] = 0
    world = OccupancyMap(GridGeometry(7, 9, 0.5, (-2.0, -1.0, turn)), cells)
    grid = MarkovGrid(pose_grid(world, PoseGridParams(0.5, 12)), MotionSpread())
    grid.predict([0.13, -0.07, 0.2])
    grid.add_floor(1.0)
    before = grid.belief.copy()
    mapped, sighted = landmarks(rng, 5), sightings(rng, seen)
    weigh_landmarks(grid, sighted, mapped, novelty)
    assert (grid.belief <= before * (1.0 + 1e-5)).all()
    states = np.argwhere(before > 0.0)[:: max(1, before.size // 60)]
    poses = grid.poses_of(states)
    blurred = widened(sighted, 0.5, 2.0 * np.pi / 12)
    for state, pose in zip(states, poses, strict=True):
        log_p = naive.sightings_log_likelihood(pose, blurred, mapped, OUTLIER)
        expected = before[tuple(state)] * np.exp(novelty * log_p)
        assert grid.belief[tuple(state)] == pytest.approx(expected, rel=2e-3)


def widened(seen: Sightings, cell: float, step: float) -> Sightings:
    """Sightings whose errors take in the width of a state."""
    around = cell**2 / 12.0 / np.maximum(seen.ranges, cell) ** 2 + step**2 / 12.0
    return Sightings(
        seen.ranges,
        seen.bearings,
        np.sqrt(seen.range_sigmas**2 + cell**2 / 12.0),
        np.sqrt(seen.bearing_sigmas**2 + around),
        seen.kinds,
        seen.identities,
    )


def exact(places: np.ndarray, kind: str, identity: str | None) -> Sightings:
    count = len(places)
    return Sightings(
        ranges=np.hypot(*places.T),
        bearings=np.arctan2(places[:, 1], places[:, 0]),
        range_sigmas=np.full(count, 0.1),
        bearing_sigmas=np.full(count, 0.05),
        kinds=(kind,) * count,
        identities=(identity,) * count,
    )


def test_a_landmark_that_is_not_mapped_says_nothing() -> None:
    world = LandmarkMap(np.array([[1.0, 0.0]]), ("post",), ("a",))
    seen = exact(np.array([[1.0, 0.0]]), "post", "b")
    assert landmark_likelihoods(np.zeros((1, 3)), seen, world) == pytest.approx([0.0])


def test_a_name_tells_alike_landmarks_apart_and_a_class_does_not() -> None:
    world = LandmarkMap(np.array([[2.0, 0.0], [-2.0, 0.0]]), ("post", "post"), ("a", "b"))
    poses = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, np.pi]])
    by_class = landmark_likelihoods(poses, exact(np.array([[2.0, 0.0]]), "post", None), world)
    assert by_class == pytest.approx([0.0, 0.0], abs=1e-6)
    by_name = landmark_likelihoods(poses, exact(np.array([[2.0, 0.0]]), "post", "a"), world)
    assert by_name == pytest.approx([0.0, np.log(OUTLIER)], abs=1e-3)


def test_sightings_from_a_mount_are_those_of_the_base() -> None:
    mount = np.array([0.3, -0.1, 2.9])
    from_base = np.array([[2.0, 1.0], [-1.0, 0.5]])
    from_sensor = se2.transform_points(se2.inverse(mount), from_base)
    seen = exact(from_sensor, "post", None).from_mount(mount)
    assert seen.ranges == pytest.approx(np.hypot(*from_base.T))
    assert seen.bearings == pytest.approx(np.arctan2(from_base[:, 1], from_base[:, 0]))
