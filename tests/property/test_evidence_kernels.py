"""Evidence between the cells: kernels against their plain twins, and the laws that they keep."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from naive import evidence as naive
from pilotage.core.distance_field import distance_to_walls
from pilotage.localizer import evidence_kernels as kernels
from pilotage.localizer.peaks import find_peaks, summits

Array = NDArray[np.float64]
seeds = st.integers(0, 2**32 - 1)

SCALES = kernels.Scales(np.array([0.5, 1.0, 2.0, 4.0]), 3.0, 1.0, 3.0, 2.5, 3.5, 0.2)
"""Those of cells of 0.10 m."""


def distances(rng: np.random.Generator, rows: int = 23, cols: int = 31) -> NDArray[np.float32]:
    """Distances [cells] in a world of random boxes and unknown parts, walled all around."""
    blocked, unknown = np.zeros((rows, cols), bool), np.zeros((rows, cols), bool)
    for mask, count in ((blocked, 5), (unknown, 2)):
        for _ in range(rng.integers(count + 1)):
            row, col = rng.integers(rows), rng.integers(cols)
            height, width = rng.integers(1, 8, 2)
            mask[row : row + height, col : col + width] = True
    blocked[[0, -1]] = True
    blocked[:, [0, -1]] = True
    behind = np.where(blocked | unknown, -1.0, 1.0)
    return (behind * distance_to_walls(blocked, 1.0)).astype(np.float32)


def anywhere(rng: np.random.Generator, shape: tuple[int, ...], count: int) -> Array:
    """Poses (count, 3) on the grid and a little beyond its edges."""
    poses: Array = rng.uniform(-0.1, 1.1, (count, 3)) * np.array([shape[1], shape[0], 0.0])
    poses[:, 2] = rng.uniform(-math.pi, math.pi, count)
    return poses


def scan_of(rng: np.random.Generator, beams: int) -> kernels.Scan:
    bearings, lengths = rng.uniform(-3.0, 3.0, beams), rng.uniform(0.5, 25.0, beams)
    silent = (rng.random(beams) < 0.2).astype(float)
    ends = (lengths * np.array([np.cos(bearings), np.sin(bearings)])).T[silent == 0.0]
    rays = np.column_stack([bearings, lengths, silent, rng.random(beams)])
    mount = rng.uniform(-1.0, 1.0, 3) * np.array([2.0, 2.0, 0.5])
    return kernels.Scan(np.ascontiguousarray(ends), rays, mount)


@given(seeds)
def test_distances_between_cells_are_bilinear_and_off_beyond_the_map(seed: int) -> None:
    rng = np.random.default_rng(seed)
    distance = distances(rng)
    for x, y, _ in anywhere(rng, distance.shape, 40):
        twin = naive.distance_at(distance, x, y)
        told = kernels.distance_at(distance, x, y)
        assert told == pytest.approx(kernels.OFF if twin is None else twin, abs=1e-5)


@given(seeds)
def test_a_ray_travels_as_far_as_its_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    distance = distances(rng)
    for origin in anywhere(rng, distance.shape, 30):
        twin = naive.first_obstacle(distance, origin, 25.0)
        assert kernels.first_obstacle(distance, origin, 25.0) == pytest.approx(twin, abs=1e-3)


@given(seeds, st.integers(0, 20))
def test_the_normal_equations_are_those_of_the_ends_distances(seed: int, ends: int) -> None:
    rng = np.random.default_rng(seed)
    distance = distances(rng)
    points = rng.uniform(-12.0, 12.0, (ends, 2))
    for pose in anywhere(rng, distance.shape, 5):
        told = kernels.normal_equations(distance, pose, points, 2.5)
        twin = naive.normal_equations(distance, pose, points, 2.5)
        assert told == pytest.approx(twin, abs=1e-3)
        assert (told[:, :3] == told[:, :3].T).all()
        assert (np.linalg.eigvalsh(told[:, :3]) >= -1e-9).all()


@given(seeds, st.integers(0, 20))
def test_a_pose_is_refined_like_its_twin(seed: int, ends: int) -> None:
    rng = np.random.default_rng(seed)
    distance = distances(rng)
    points = rng.uniform(-12.0, 12.0, (ends, 2))
    for pose in anywhere(rng, distance.shape, 3):
        told = kernels.refined_pose(distance, pose, points, 2.5)
        assert told == pytest.approx(naive.refined_pose(distance, pose, points, 2.5), abs=1e-3)


@settings(max_examples=30)
@given(seeds, st.integers(0, 12))
def test_poses_are_weighed_like_their_twins(seed: int, beams: int) -> None:
    rng = np.random.default_rng(seed)
    distance, scan = distances(rng), scan_of(rng, beams)
    poses = anywhere(rng, distance.shape, 6)
    weights = kernels.Weights(rng.normal(0.0, 1.0, (3, 5)), rng.normal(0.0, 1.0, 2))
    refined, sums = kernels.weigh_poses(distance, poses, scan, SCALES, weights)
    twin_refined, twin_sums = naive.weigh_poses(distance, poses, scan, SCALES, weights)
    assert refined == pytest.approx(twin_refined, abs=1e-3)
    assert sums == pytest.approx(twin_sums, abs=1e-3)


@given(seeds, st.integers(1, 40), st.integers(1, 10))
def test_summits_are_the_heaviest_with_nothing_heavier_beside_them(
    seed: int, count: int, most: int
) -> None:
    rng = np.random.default_rng(seed)
    poses = rng.uniform([0.0, 0.0, -4.0], [2.0, 2.0, 4.0], (count, 3))
    assert summits(poses, most, 0.4, 0.2).tolist() == naive.summits(poses, most, 0.4, 0.2)
    weights = rng.random(count)
    peaks = find_peaks(poses, weights, most)
    assert (peaks[0] == poses[np.argmax(weights)]).all()
    assert len(peaks) <= most
