"""The kernels of sparse SLAM beside their twins, on random walls."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import sparse_scans as naive
from pilotage.mapper.particle_kernels import Cloud, Moved, Sight, note, propose, weigh
from pilotage.mapper.smoother_kernels import Pull, binned, pull_to_walls, solve_banded

SEEDS = st.integers(0, 10_000)
FEW = settings(max_examples=20)
SIGHT = Sight(sigma=0.05, reach=0.3, stray=0.1, unknown=-1.2)


def walls(rng: np.random.Generator, count: int) -> np.ndarray:
    """Points (count, 2) on two walls of a corner, a little off."""
    along = rng.uniform(0.0, 1.5, count)
    on_first = rng.random(count) < 0.5
    points = np.where(on_first[:, None], np.stack([along, 0 * along], 1), 0.0)
    points[~on_first, 1] = along[~on_first]
    return points + 0.02 * rng.standard_normal(points.shape)


def random_cloud(rng: np.random.Generator, particles: int, scans: int, beams: int) -> Cloud:
    seen = walls(rng, particles * scans * beams).reshape(particles, scans, beams, 2)
    return Cloud(
        0.2 * rng.standard_normal((particles, 3)),
        rng.choice([-1.0, 1.0], particles),
        rng.uniform(-2.0, 0.4, (particles, 2)),
        np.zeros((particles, scans, 4)),
        seen.astype(np.float32),
    )


def copied(cloud: Cloud) -> Cloud:
    poses, senses, scales, ways, seen = cloud
    return Cloud(poses.copy(), senses.copy(), scales.copy(), ways.copy(), seen.copy())


@given(SEEDS)
@FEW
def test_particles_move_as_the_formulas_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cloud = random_cloud(rng, 30, 2, 3)
    twin = copied(cloud)
    increment = np.array([0.1, 0.01, 0.05])
    moved = Moved(increment, 0.02, 0.03, 0.2, 0.5, 0.1, 0.3, 0.4, (-2.0, 0.4))
    dice = rng.standard_normal((30, 5)), rng.random((30, 4))
    propose(cloud, moved, *dice)
    naive.propose(twin, moved, *dice)
    for part, expected in zip(cloud, twin, strict=True):
        assert part == pytest.approx(expected)


@given(SEEDS)
@FEW
def test_particles_weigh_as_much_as_the_formulas_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cloud = random_cloud(rng, 5, 6, 4)
    counts = rng.integers(0, 5, 6)
    points = walls(rng, 8)
    found = weigh(cloud, counts, points, SIGHT)
    assert found == pytest.approx(naive.weigh(cloud, counts, points, SIGHT), abs=1e-3)


@given(SEEDS)
@FEW
def test_each_particle_notes_what_it_sees_from_where_it_is(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cloud = random_cloud(rng, 4, 3, 5)
    points = walls(rng, 4)
    before = cloud.seen.copy()
    note(cloud, 1, points)
    for pose, way, seen in zip(cloud.poses, cloud.ways, cloud.seen, strict=True):
        assert way[1, :3] == pytest.approx(pose)
        assert seen[1, :4] == pytest.approx(naive.placed(pose, points), abs=1e-6)
    assert np.array_equal(before[:, [0, 2]], cloud.seen[:, [0, 2]])


@given(SEEDS, st.integers(0, 2), st.integers(2, 6))
@FEW
def test_points_pull_as_the_formulas_say(seed: int, nearest: int, farthest: int) -> None:
    rng = np.random.default_rng(seed)
    poses, points = rng.standard_normal((6, 3)), walls(rng, 60)
    owners = np.sort(rng.integers(0, 6, 60))
    pull = Pull(0.03, 0.1, nearest, farthest)
    H, g = pull_to_walls(poses, points, owners, binned(points, 0.3), pull)
    twin_H, twin_g = naive.pull_to_walls(poses, points, owners, 0.3, pull)
    assert pytest.approx(twin_H, rel=1e-6, abs=1e-6) == H
    assert g == pytest.approx(twin_g, rel=1e-6, abs=1e-6)


@given(SEEDS, st.integers(1, 80), st.floats(0.05, 3.0))
@FEW
def test_every_point_is_in_the_square_where_it_lies(seed: int, count: int, size: float) -> None:
    points = np.random.default_rng(seed).uniform(-4.0, 4.0, (count, 2))
    bins = binned(points, size)
    assert sorted(bins.order.tolist()) == list(range(count))
    for square in range(bins.rows * bins.cols):
        row, col = divmod(square, bins.cols)
        for number in bins.order[bins.start[square] : bins.start[square + 1]]:
            cell = np.floor((points[number] - bins.corner) / size)
            assert cell.tolist() == [col, row]
            assert 0 < row < bins.rows - 1
            assert 0 < col < bins.cols - 1


@given(SEEDS, st.integers(1, 30), st.integers(1, 6))
@FEW
def test_banded_systems_are_solved(seed: int, size: int, width: int) -> None:
    rng = np.random.default_rng(seed)
    near = np.abs(np.subtract.outer(np.arange(size), np.arange(size))) < width
    lower = np.tril(np.where(near, rng.standard_normal((size, size)), 0.0)) + 3.0 * np.eye(size)
    matrix, right = lower @ lower.T, rng.standard_normal(size)
    # Row i holds the diagonal, then what lies left of it.
    band = np.zeros((size, width))
    for d in range(min(width, size)):
        band[d:, d] = np.diagonal(matrix, -d)
    assert solve_banded(band, right) == pytest.approx(np.linalg.solve(matrix, right), rel=1e-6)
