"""Laws of the environment potential field (Liu et al. 2008, eq. 1 to 3), and its plain twin."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from naive import potential_field as naive
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.landmark_map import LandmarkMap
from pilotage.planner.potential_field import (
    Recognition,
    environment_potential,
    sources_of,
    window_potential,
)

RECOGNITIONS = {"post": Recognition(1.5, 0.3), "goal": Recognition(4.0, 0.6)}
seeds = st.integers(0, 2**32 - 1)


def landmarks(rng: np.random.Generator, count: int) -> LandmarkMap:
    kinds = tuple(str(kind) for kind in rng.choice(["post", "goal"], count))
    names = tuple(f"n{i}" if rng.random() < 0.4 else None for i in range(count))
    return LandmarkMap(rng.uniform(-4.0, 4.0, (count, 2)), kinds, names)


def unlike(rng: np.random.Generator, count: int, tag: str) -> LandmarkMap:
    """Landmarks of which each is told from all others."""
    names = tuple(f"{tag}{i}" for i in range(count))
    return LandmarkMap(rng.uniform(-4.0, 4.0, (count, 2)), ("post",) * count, names)


@given(seeds, st.integers(1, 8), st.floats(0.0, 3.2))
def test_the_potentials_are_those_of_the_twin(seed: int, count: int, half_view: float) -> None:
    rng = np.random.default_rng(seed)
    world, poses = landmarks(rng, count), rng.uniform(-5.0, 5.0, (6, 3))
    sources = sources_of(world, RECOGNITIONS)
    window = window_potential(sources, poses[:, :2], poses[:, 2], half_view)
    whole = environment_potential(sources, poses[:, :2])
    for i, pose in enumerate(poses):
        twin = naive.window_potential(world, RECOGNITIONS, pose, half_view)
        assert window[i, i] == pytest.approx(twin, abs=1e-4)
        full = naive.window_potential(world, RECOGNITIONS, pose, np.pi)
        assert whole[i] == pytest.approx(full, abs=1e-4)


@given(seeds, st.integers(1, 6), st.floats(-3.0, 3.0))
def test_walls_hide_what_they_hide_from_the_twin(seed: int, count: int, turn: float) -> None:
    rng = np.random.default_rng(seed)
    cells = np.where(rng.random((12, 12)) < 0.15, 100, 0).astype(np.int8)
    walls = OccupancyMap(GridGeometry(12, 12, 0.5, (-1.0, -2.0, turn)), cells)
    world, places = landmarks(rng, count), rng.uniform(-4.0, 4.0, (6, 2))
    whole = environment_potential(sources_of(world, RECOGNITIONS, walls), places)
    for place, potential in zip(places, whole, strict=True):
        pose = np.array([*place, 0.0])
        twin = naive.window_potential(world, RECOGNITIONS, pose, np.pi, walls)
        assert potential == pytest.approx(twin, abs=1e-4)


@given(seeds, st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(-3.2, 3.2))
def test_a_rigid_motion_takes_the_field_along(seed: int, x: float, y: float, turn: float) -> None:
    rng = np.random.default_rng(seed)
    world, motion = landmarks(rng, 5), np.array([x, y, turn])
    moved = LandmarkMap(
        se2.transform_points(motion, world.positions), world.classes, world.identities
    )
    places, headings = rng.uniform(-4.0, 4.0, (6, 2)), rng.uniform(-3.0, 3.0, 4)
    before = window_potential(sources_of(world, RECOGNITIONS), places, headings, 0.5)
    after = window_potential(
        sources_of(moved, RECOGNITIONS), se2.transform_points(motion, places), headings + turn, 0.5
    )
    assert after == pytest.approx(before, abs=1e-6)


@given(seeds, st.floats(-10.0, 10.0))
def test_a_window_of_a_full_turn_is_the_environment(seed: int, heading: float) -> None:
    rng = np.random.default_rng(seed)
    sources = sources_of(landmarks(rng, 6), RECOGNITIONS)
    places = rng.uniform(-4.0, 4.0, (6, 2))
    window = window_potential(sources, places, [heading], np.pi + 1e-9)
    assert window[:, 0] == pytest.approx(environment_potential(sources, places))


@given(seeds, st.floats(0.0, 3.0), st.floats(0.0, 3.0))
def test_the_wider_the_window_the_higher_the_potential(seed: int, one: float, more: float) -> None:
    rng = np.random.default_rng(seed)
    sources = sources_of(landmarks(rng, 6), RECOGNITIONS)
    places = rng.uniform(-4.0, 4.0, (6, 2))
    narrow = window_potential(sources, places, [0.7], one)
    wide = window_potential(sources, places, [0.7], one + more)
    assert (wide >= narrow - 1e-12).all()


@given(st.floats(0.1, 10.0), st.floats(0.01, 2.0), st.floats(0.0, 20.0), st.floats(0.0, 5.0))
def test_the_potential_falls_with_distance(
    reach: float, fall: float, near: float, farther: float
) -> None:
    world = LandmarkMap(np.zeros((1, 2)), ("post",), (None,))
    sources = sources_of(world, {"post": Recognition(reach, fall)})
    first, second = environment_potential(sources, [[near, 0.0], [0.0, near + farther]])
    assert 0.0 <= second <= first + 1e-12
    assert first <= 1.0


@given(seeds, st.integers(1, 5), st.integers(1, 5))
def test_the_fields_of_disjoint_landmarks_add_up(seed: int, one: int, other: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = unlike(rng, one, "a"), unlike(rng, other, "b")
    both = LandmarkMap(
        np.concatenate([a.positions, b.positions]),
        a.classes + b.classes,
        a.identities + b.identities,
    )
    places = rng.uniform(-4.0, 4.0, (8, 2))
    parts = [environment_potential(sources_of(part, RECOGNITIONS), places) for part in (a, b)]
    whole = environment_potential(sources_of(both, RECOGNITIONS), places)
    assert whole == pytest.approx(parts[0] + parts[1])
