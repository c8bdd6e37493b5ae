"""What a camera would see of landmarks: its plain twin, and laws that hold for every field."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from naive import potential_field as naive
from pilotage.core import se2
from pilotage.core.landmark_map import LandmarkMap
from pilotage.planner.landmark_views import (
    Camera,
    Sharpness,
    expected_log_likelihoods,
    sighting_log_likelihoods,
    views_from,
)
from pilotage.planner.potential_field import Recognition, Sources, kinds_of, sources_of

RECOGNITIONS = {"post": Recognition(1.5, 0.3), "goal": Recognition(4.0, 0.6)}
CAMERA = Camera()
TURN = (0.0, float(np.pi))
seeds = st.integers(0, 2**32 - 1)


def landmarks(rng: np.random.Generator, count: int) -> LandmarkMap:
    kinds = tuple(str(kind) for kind in rng.choice(["post", "goal"], count))
    names = tuple(f"n{i}" if rng.random() < 0.4 else None for i in range(count))
    return LandmarkMap(rng.uniform(-3.0, 3.0, (count, 2)), kinds, names)


def poses(rng: np.random.Generator, count: int) -> np.ndarray:
    return rng.uniform(-3.0, 3.0, (count, 3))


def sharpness(blur: float, rim: float = 0.0) -> Sharpness:
    return CAMERA.sharpness._replace(blur=blur, rim=rim)


def expected(
    sources: Sources,
    places: np.ndarray,
    window: tuple[float, float],
    sharp: Sharpness = CAMERA.sharpness,
) -> np.ndarray:
    truths = np.arange(len(places))
    views = views_from(sources, places)
    return expected_log_likelihoods(sources, views, truths, window, sharp)


@given(seeds, st.integers(1, 8), st.floats(-4.0, 4.0), st.floats(0.2, 3.1), st.floats(0.0, 0.5))
def test_sightings_are_as_likely_as_the_twin_says(
    seed: int, count: int, gaze: float, half_view: float, blur: float
) -> None:
    rim = (0.0, 0.15)[seed % 2]
    rng = np.random.default_rng(seed)
    world, places = landmarks(rng, count), poses(rng, 8)
    kinds = kinds_of(world)
    seen = rng.integers(len(kinds), size=3)
    values = np.column_stack([rng.uniform(0.3, 5.0, 3), rng.uniform(-4.0, 4.0, 3)])
    window = gaze, half_view
    logs = sighting_log_likelihoods(
        sources_of(world, RECOGNITIONS), places, (seen, values), window, sharpness(blur, rim)
    )
    named = [((*kinds[kind], *value), 1.0) for kind, value in zip(seen, values, strict=True)]
    for pose, log_p in zip(places, logs, strict=True):
        look = gaze, half_view, sharpness(blur, rim)
        twin = naive.sighting_log_likelihood(world, RECOGNITIONS, pose, named, look)
        # What lies beyond four standard deviations counts as no fit at all.
        assert log_p == pytest.approx(twin, abs=0.06)


@given(seeds, st.integers(1, 8), st.floats(-4.0, 4.0), st.floats(0.0, 0.5))
def test_what_would_be_seen_is_weighed_as_the_twin_does(
    seed: int, count: int, gaze: float, blur: float
) -> None:
    rim = (0.0, 0.15)[seed % 2]
    rng = np.random.default_rng(seed)
    world, places = landmarks(rng, count), poses(rng, 6)
    window = gaze, CAMERA.half_view
    logs = expected(sources_of(world, RECOGNITIONS), places, window, sharpness(blur, rim))
    for i, truth in enumerate(places):
        seen = recognisable(world, truth, window, rim)
        for j, pose in enumerate(places):
            look = gaze, CAMERA.half_view, sharpness(blur, rim)
            twin = naive.sighting_log_likelihood(world, RECOGNITIONS, pose, seen, look)
            assert logs[i, j] == pytest.approx(twin, abs=0.06)


def recognisable(
    world: LandmarkMap, pose: np.ndarray, window: tuple[float, float], rim: float
) -> list[tuple[naive.Sighting, float]]:
    """Every landmark in the window, weighed by how surely it is recognised."""
    seen = []
    names = zip(world.classes, world.identities, strict=True)
    for (kind, identity), position in zip(names, world.positions, strict=True):
        x, y = se2.transform_points(se2.inverse(pose), position[None])[0]
        distance, bearing = float(np.hypot(x, y)), float(np.arctan2(y, x))
        share = naive.seen_share(distance, RECOGNITIONS[kind])
        weight = share * naive.in_view(bearing - window[0], window[1], rim)
        if weight > 0.0:
            seen.append(((kind, identity, distance, bearing), weight))
    return seen


@given(seeds, st.floats(-20.0, 20.0), st.floats(-20.0, 20.0), st.floats(-3.2, 3.2))
def test_a_rigid_motion_of_everything_changes_nothing(
    seed: int, x: float, y: float, turn: float
) -> None:
    rng = np.random.default_rng(seed)
    world, places, motion = landmarks(rng, 5), poses(rng, 6), np.array([x, y, turn])
    moved = LandmarkMap(
        se2.transform_points(motion, world.positions), world.classes, world.identities
    )
    before = expected(sources_of(world, RECOGNITIONS), places, TURN)
    after = expected(sources_of(moved, RECOGNITIONS), se2.compose(motion, places), TURN)
    assert after == pytest.approx(before, abs=0.05)


@given(seeds)
def test_a_full_turn_does_not_care_where_it_begins(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sources, places = sources_of(landmarks(rng, 5), RECOGNITIONS), poses(rng, 6)
    other = expected(sources, places, (2.1, np.pi + 1e-9))
    assert other == pytest.approx(expected(sources, places, (0.0, np.pi + 1e-9)), abs=1e-5)


@given(seeds, st.integers(1, 6))
def test_nothing_explains_what_is_seen_better_than_where_one_is(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    # Far apart, so that no landmark lends another of its likelihood.
    places = np.column_stack([np.arange(count) * 20.0, np.zeros((count, 1))])
    world = LandmarkMap(places, ("post",) * count, (None,) * count)
    around = np.column_stack([rng.uniform(-1.0, 1.0, (12, 2)), rng.uniform(-3.0, 3.0, 12)])
    logs = expected(sources_of(world, RECOGNITIONS), around, TURN)
    assert (logs.diagonal()[:, None] >= logs - 0.05).all()


def test_a_landmark_under_the_camera_is_not_seen() -> None:
    sources = sources_of(LandmarkMap(np.zeros((1, 2)), ("post",), (None,)), RECOGNITIONS)
    under, beside = views_from(sources, np.array([[0.05, 0.0, 0.0], [0.3, 0.0, 0.0]])).shares
    assert under == pytest.approx([0.0])
    assert beside[0] > 0.9
