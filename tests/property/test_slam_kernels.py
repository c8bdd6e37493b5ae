"""The kernels of scan matching beside their twins, on random walls."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from naive import scan_matching as naive
from pilotage.mapper import correlative_kernels as search
from pilotage.mapper import surfel_kernels as surfels
from pilotage.mapper.matching_kernels import normal_equations
from pilotage.mapper.surfel_kernels import SurfelMap
from pilotage.mapper.surfels import SurfelParams, surfel_map
from pilotage.mapper.visibility_kernels import beams_through_walls

SEEDS = st.integers(0, 10_000)
FEW = settings(max_examples=20)
SIGMAS = 0.03, 3.0, 0.08
SIZE = 0.05


def walls_of(seed: int, count: int = 60, noise: float = 0.01) -> np.ndarray:
    """Points (n, 2) on three short walls, and some that lie about."""
    rng = np.random.default_rng(seed)
    starts, ends = rng.uniform(-1.0, 1.0, (2, 3, 1, 2))
    share = rng.random((3, count // 4, 1))
    on_walls = (starts + share * (ends - starts)).reshape(-1, 2)
    about = rng.uniform(-1.0, 1.0, (count - len(on_walls), 2))
    return np.vstack([on_walls + rng.normal(0.0, noise, on_walls.shape), about])


def small_map(seed: int) -> SurfelMap:
    return surfel_map(walls_of(seed), SurfelParams(cell=SIZE, reach=0.15, wall=0.2))


def raster_of(points: np.ndarray, margin: float = 0.12) -> tuple[np.ndarray, np.ndarray]:
    """The corner (2,) and an empty index around points."""
    corner = points.min(axis=0) - margin
    cols, rows = np.ceil((points.max(axis=0) + margin - corner) / SIZE).astype(int)
    return corner, np.full((rows, cols), -1, np.int32)


def random_task(seed: int, *, depth: int, half: int, price: float) -> search.Task:
    """A raster of few bright cells, some scans of points, and what offsets and turns cost."""
    rng = np.random.default_rng(seed)
    base = rng.integers(0, 256, (24, 30)).astype(np.uint8)
    base[rng.random(base.shape) < 0.6] = 0
    pad = 1 << (depth - 1)
    layers = [np.pad(base, ((pad, 0), (pad, 0)))]
    for level in range(1, depth):
        layers.append(search.pooled(layers[-1], 1 << (level - 1)))
    cells = rng.integers(-4, 40, (5, 7, 2)).astype(np.int32) + np.int32(pad)
    per_turn = price * rng.uniform(0.0, 200.0, 5)
    return search.Task(
        np.array(layers), cells, half, per_turn, price * float(rng.uniform(0.0, 9.0))
    )


@given(SEEDS, st.integers(0, 80), st.sampled_from([0.02, 0.05, 0.3]))
@FEW
def test_thinned_points_are_the_means_of_squares(seed: int, count: int, size: float) -> None:
    points = walls_of(seed, count)
    assert surfels.thin_points(points, size) == pytest.approx(naive.thin_points(points, size))


@given(SEEDS)
@FEW
def test_thinned_points_lie_one_to_a_square(seed: int) -> None:
    points = walls_of(seed, 200)
    thin = surfels.thin_points(points, 0.1)
    squares = {tuple(cell) for cell in np.floor((thin - points.min(axis=0)) / 0.1 + 1e-9)}
    assert len(squares) == len(thin) <= len(points)


@given(SEEDS)
@FEW
def test_points_of_a_cell_are_pooled_into_their_mean(seed: int) -> None:
    points = walls_of(seed)
    corner, index = raster_of(points)
    expected_index = index.copy()
    means = surfels.pool_points(points, corner, index, SIZE)
    assert means == pytest.approx(naive.pool_points(points, corner, expected_index, SIZE))
    assert (index == expected_index).all()


@given(SEEDS, st.integers(1, 5))
@FEW
def test_walls_have_the_direction_of_their_scatter(seed: int, reach: int) -> None:
    points = walls_of(seed)
    corner, index = raster_of(points)
    means = naive.pool_points(points, corner, index, SIZE)
    normals, flatness = surfels.wall_directions(means, corner, index, SIZE, reach)
    expected, flat = naive.wall_directions(means, corner, index, SIZE, reach)
    assert flatness == pytest.approx(flat, abs=1e-4)  # a root: rounding of 1e-9 shows as 3e-5
    clear = flat > 0.01  # what is round has no direction
    assert np.abs(np.sum(normals * expected, axis=1))[clear] == pytest.approx(1.0, abs=1e-6)
    assert (normals[flat == 0.0] == 0.0).all() or (flat > 0.0).all()


@given(SEEDS, st.integers(0, 4))
@FEW
def test_every_cell_knows_its_nearest_surfel(seed: int, reach: int) -> None:
    points = walls_of(seed, 30)
    corner, index = raster_of(points)
    means = naive.pool_points(points, corner, index, SIZE)
    nearest, distance = surfels.spread_nearest(means, corner, index.shape, SIZE, reach)
    expected, apart = naive.spread_nearest(means, corner, index.shape, SIZE, reach)
    assert distance == pytest.approx(apart, abs=1e-6)
    assert ((nearest < 0) == (expected < 0)).all()
    # Two that are as near as each other to six digits may stand for each other.
    rows, cols = np.nonzero(nearest != expected)
    centres = corner + SIZE * (np.column_stack([cols, rows]) + 0.5)
    gaps = np.linalg.norm(means[nearest[rows, cols]] - centres, axis=1)
    assert gaps == pytest.approx(apart[rows, cols], abs=1e-6)


@given(SEEDS, st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(-3.1, 3.1))
@FEW
def test_normal_equations_are_the_sums_of_the_points(
    seed: int, x: float, y: float, theta: float
) -> None:
    walls, points = small_map(seed), walls_of(seed + 1, 40)
    pose = np.array([x, y, theta])
    H, g, cost, seen = normal_equations(pose, points, walls, SIGMAS)
    twin_H, twin_g, twin_cost, twin_seen = naive.normal_equations(pose, points, walls, SIGMAS)
    assert twin_H == pytest.approx(H, rel=1e-9, abs=1e-6)
    assert twin_g == pytest.approx(g, rel=1e-9, abs=1e-6)
    assert (cost, seen) == pytest.approx((twin_cost, twin_seen))


@given(SEEDS)
@FEW
def test_gradient_is_the_slope_of_the_cost(seed: int) -> None:
    walls = small_map(seed)
    pose = np.random.default_rng(seed).uniform(-0.05, 0.05, 3)
    points = walls_of(seed, 40)
    held = [naive.surfel_of(pose, point, walls) for point in points]
    _, g, cost, _ = normal_equations(pose, points, walls, SIGMAS)
    assert cost == pytest.approx(naive.robust_cost(pose, points, walls, SIGMAS, held))
    slope = np.array(
        [
            naive.robust_cost(pose + step, points, walls, SIGMAS, held)
            - naive.robust_cost(pose - step, points, walls, SIGMAS, held)
            for step in 1e-6 * np.eye(3)
        ]
    )
    scale = 2.0 * (SIGMAS[0] / SIGMAS[2]) ** 2 / len(points)
    assert scale * g == pytest.approx(slope / 2e-6, rel=1e-4, abs=1e-5)


@given(SEEDS)
@FEW
def test_information_has_no_negative_direction(seed: int) -> None:
    pose = np.random.default_rng(seed).uniform(-0.3, 0.3, 3)
    H, _, cost, seen = normal_equations(pose, walls_of(seed + 1), small_map(seed), SIGMAS)
    assert np.linalg.eigvalsh(H)[0] > -1e-6
    assert pytest.approx(H) == H.T
    assert 0.0 <= cost <= 1.0
    assert 0 <= seen <= 60


@given(SEEDS, st.sampled_from([1, 2, 4, 8, 64]))
@FEW
def test_a_pooled_cell_holds_the_best_of_its_four(seed: int, step: int) -> None:
    layer = np.random.default_rng(seed).integers(0, 256, (9, 13)).astype(np.uint8)
    assert (search.pooled(layer, step) == naive.pooled(layer, step)).all()


@given(SEEDS, st.integers(1, 5), st.integers(0, 9), st.sampled_from([0.0, 1.0]))
@FEW
def test_search_finds_the_best_of_all_offsets(
    seed: int, depth: int, half: int, price: float
) -> None:
    task = random_task(seed, depth=depth, half=half, price=price)
    turn, row, col, best = search.branch_and_bound(task, 0.0)
    *_, expected = naive.branch_and_bound(task, 0.0)
    assert best == pytest.approx(expected)
    if turn >= 0:  # of equals any
        assert max(abs(row), abs(col)) <= half
        assert naive.score(task, turn, row, col) == pytest.approx(best)


@given(SEEDS, st.integers(1, 5), st.integers(1, 9))
@FEW
def test_search_finds_what_lies_at_the_edge_of_the_window(seed: int, depth: int, half: int) -> None:
    rng = np.random.default_rng(seed)
    task = random_task(seed, depth=depth, half=half, price=0.0)
    pad = 1 << (depth - 1)
    layers = np.zeros_like(task.layers)
    cells = np.full((1, 1, 2), pad + 12, np.int32)
    row, col = half * int(rng.choice([-1, 1])), int(rng.integers(-half, half + 1))
    layers[0, pad + 12 + row, pad + 12 + col] = 200
    for level in range(1, depth):
        layers[level] = search.pooled(layers[level - 1], 1 << (level - 1))
    one = search.Task(layers, cells, half, np.zeros(1), 0.0)
    assert search.branch_and_bound(one, 0.0) == (0, row, col, 200.0)
    assert search.branch_and_bound(one, 200.0)[0] == -1
    if half > 1:
        assert search.branch_and_bound(one._replace(half=half - 1), 0.0)[0] == -1


@given(SEEDS, st.sampled_from([0.0, 1.0]))
@FEW
def test_search_returns_nothing_if_nothing_is_better(seed: int, price: float) -> None:
    task = random_task(seed, depth=3, half=4, price=price)
    *_, best = naive.branch_and_bound(task, 0.0)
    assert search.branch_and_bound(task, best + 1.0) == (-1, 0, 0, best + 1.0)


@given(SEEDS, st.floats(0.05, 0.5))
@FEW
def test_beams_stop_at_surfels(seed: int, margin: float) -> None:
    walls, rng = small_map(seed), np.random.default_rng(seed)
    origin, ends = rng.uniform(-1.2, 1.2, 2), rng.uniform(-2.0, 2.0, (30, 2))
    through = beams_through_walls(origin, ends, walls, margin)
    assert through == naive.beams_through_walls(origin, ends, walls, margin)
