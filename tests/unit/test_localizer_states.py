"""Which states exist, and beliefs that are begun on them."""

import math

import numpy as np
import pytest

from drawing import draw
from naive import markov as naive
from pilotage.core import se2
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.localizer import kernels
from pilotage.localizer.gaussian_start import gaussian_start
from pilotage.localizer.markov_grid import MarkovGrid
from pilotage.localizer.motion_spread import MotionSpread
from pilotage.localizer.pose_grid import MERGED, PoseGrid, PoseGridParams, pose_grid

STILL = MotionSpread(0.0, 0.0, 0.0, 0.0)
SMALL = np.diag([0.04, 0.04, 0.03])

ROOM = """
    ??????????
    ?########?
    ?#......#?
    ?#......#?
    ?########?
    """


def states_of(picture: str, **params: float) -> PoseGrid:
    origin = params.pop("turn", 0.0)
    world = draw(picture, 0.5, (1.0, -2.0, origin))
    return pose_grid(world, PoseGridParams(resolution=0.5, headings=16))


def belief_on(picture: str, turn: float = 0.0) -> MarkovGrid:
    return MarkovGrid(states_of(picture, turn=turn), STILL)


def test_states_are_free_cells_times_headings() -> None:
    grid = states_of(ROOM)
    assert grid.shape == (16, 2, 6)
    assert grid.admissible_states == 16 * 12
    assert grid.heading_step == pytest.approx(math.tau / 16)


def test_states_lie_where_the_free_cells_lie() -> None:
    grid = states_of(ROOM, turn=0.7)
    free = grid.world.geometry.centres_of(np.argwhere(grid.world.is_free))
    centres = grid.geometry.centres_of(np.argwhere(grid.admissible.mask > 0))
    assert centres == pytest.approx(free)


def test_a_map_without_a_free_cell_is_refused() -> None:
    with pytest.raises(ValueError, match="no free cell"):
        states_of("##?\n#?#")


def test_a_map_that_is_all_free_has_all_states() -> None:
    grid = states_of("....\n....")
    assert grid.admissible_states == 16 * 8
    assert grid.admissible.runs.tolist() == [[0, 0, 4], [1, 0, 4]]


def test_unknown_cells_hold_nobody() -> None:
    assert states_of("..??\n?...").admissible.mask.tolist() == [[0, 1, 1, 1], [1, 1, 0, 0]]


def test_stretches_of_free_cells_far_apart_are_runs_of_their_own() -> None:
    cells = np.full((1, 2 * MERGED + 5), 100, np.int8)
    cells[0, [0, 1, MERGED + 1, 2 * MERGED + 2, 2 * MERGED + 3]] = 0
    world = OccupancyMap(GridGeometry(1, cells.shape[1], 0.1), cells)
    runs = pose_grid(world, PoseGridParams(0.1, 8)).admissible.runs
    first = [0, 0, MERGED + 2]
    assert runs.tolist() == [first, [0, 2 * MERGED + 2, 2 * MERGED + 4]]


def test_a_finer_map_is_resampled_and_a_coarser_one_used_as_it_is() -> None:
    world = draw("......\n......", 0.25)
    coarse, fine = (pose_grid(world, PoseGridParams(size)).geometry for size in (0.5, 0.1))
    assert (coarse.resolution, coarse.shape) == (0.5, (1, 3))
    assert (fine.resolution, fine.shape) == (0.25, (2, 6))


def test_a_building_beyond_the_memory_gets_coarser_cells() -> None:
    world = OccupancyMap(GridGeometry(60, 60, 0.1), np.zeros((60, 60), np.int8))
    grid = pose_grid(world, PoseGridParams(0.1, 72, most_states=20_000))
    assert np.prod(grid.shape) <= 1.2 * 20_000
    assert grid.geometry.resolution > 0.3


def test_coarser_cells_than_asked_for_are_told() -> None:
    world = OccupancyMap(GridGeometry(60, 60, 0.1), np.zeros((60, 60), np.int8))
    fine = pose_grid(world, PoseGridParams(0.1, 72))
    coarse = pose_grid(world, PoseGridParams(0.1, 72, most_states=20_000))
    assert (fine.asked_resolution, fine.is_coarsened) == (0.1, False)
    assert (coarse.asked_resolution, coarse.is_coarsened) == (0.1, True)
    assert not pose_grid(draw("..\n..", 0.25), PoseGridParams(0.1)).is_coarsened


def test_only_the_floor_counts_for_the_memory_not_the_paper_around_it() -> None:
    cells = np.full((300, 300), -1, np.int8)
    cells[100:110, 100:120] = 0
    grid = pose_grid(
        OccupancyMap(GridGeometry(300, 300, 0.1), cells), PoseGridParams(0.1, 72, 20_000)
    )
    assert grid.geometry.resolution == pytest.approx(0.1)
    assert grid.shape == (72, 10, 20)


@pytest.mark.parametrize("size", [0.02, 0.05, 0.1, 0.2])
def test_cells_of_any_usual_size_hold_the_same_room(size: float) -> None:
    count = round(4.0 / size)
    cells = np.zeros((count, count), np.int8)
    cells[[0, -1]], cells[:, [0, -1]] = 100, 100
    world = OccupancyMap(GridGeometry(count, count, size), cells)
    grid = pose_grid(world, PoseGridParams(size, 8))
    assert grid.geometry.resolution == pytest.approx(size)
    area = grid.admissible_states / 8 * size**2
    assert area == pytest.approx((4.0 - 2.0 * size) ** 2, rel=1e-6)
    belief = MarkovGrid(grid, STILL)
    belief.set_gaussian([2.0, 2.0, 0.0], SMALL)
    belief.predict([0.5, 0.1, 0.2])
    poses, weights = belief_of(belief)
    assert weights @ poses[:, :2] / weights.sum() == pytest.approx([2.5, 2.1], abs=0.05)


def belief_of(belief: MarkovGrid) -> tuple[np.ndarray, np.ndarray]:
    belief.settle()
    return belief.heaviest(200_000)


def test_an_even_belief_has_the_entropy_of_the_number_of_states() -> None:
    belief = belief_on(ROOM)
    assert belief.total == pytest.approx(1.0)
    assert belief.entropy() == pytest.approx(math.log2(16 * 12), abs=2e-3)
    assert belief.marginal() == pytest.approx(np.full((2, 6), 1.0 / 12.0))


@pytest.mark.parametrize("turn", [0.0, 0.9, -2.5])
def test_a_belief_begun_at_a_pose_has_its_mean_and_covariance(turn: float) -> None:
    """On a turned map too, with a covariance longer one way than the other."""
    cells = np.zeros((60, 60), np.int8)
    origin = (3.0, -1.0, turn)
    world = OccupancyMap(GridGeometry(60, 60, 0.1, origin), cells)
    belief = MarkovGrid(pose_grid(world, PoseGridParams(0.1, 72)), STILL)
    pose = se2.compose(origin, [3.02, 2.96, 0.4])
    covariance = np.array([[0.16, 0.03, 0.0], [0.03, 0.04, 0.01], [0.0, 0.01, 0.02]])
    belief.set_gaussian(pose, covariance)
    poses, weights = belief.heaviest(200_000)
    share = weights / weights.sum()
    away = poses - pose
    away[:, 2] = (away[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    assert share @ away == pytest.approx(np.zeros(3), abs=0.01)
    assert (away * share[:, None]).T @ away == pytest.approx(covariance, abs=0.012)


def test_a_belief_may_begin_beside_the_free_space_but_not_far_from_it() -> None:
    grid = states_of(ROOM)
    gaussian_start(grid, [1.6, -0.9, 0.0], SMALL)
    with pytest.raises(ValueError, match="free space"):
        gaussian_start(grid, [30.0, 0.0, 0.0], SMALL)


@pytest.mark.parametrize(
    "covariance",
    [
        np.diag([-1.0, 1.0, 1.0]),
        np.array([[1.0, 2.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        np.array([[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    ],
    ids=["negative", "not symmetric", "indefinite"],
)
def test_what_is_no_covariance_is_refused(covariance: np.ndarray) -> None:
    with pytest.raises(ValueError, match="covariance"):
        gaussian_start(states_of(ROOM), [3.0, -1.0, 0.0], covariance)


def test_a_pose_known_exactly_begins_in_one_state_and_its_neighbours() -> None:
    belief = belief_on(ROOM)
    belief.set_gaussian([3.25, -0.75, 0.0], np.zeros((3, 3)))
    poses, weights = belief.heaviest(1)
    assert poses[0] == pytest.approx([3.25, -0.75, 0.0])
    assert weights[0] > 0.2


def test_a_refused_pose_leaves_the_belief_as_it_was() -> None:
    belief = belief_on(ROOM)
    belief.set_gaussian([2.0, -1.0, 1.0], SMALL)
    before = belief.belief.copy()
    with pytest.raises(ValueError, match="free space"):
        belief.set_gaussian([99.0, 0.0, 0.0], SMALL)
    assert np.array_equal(belief.belief, before)


def test_states_that_were_kept_come_back_with_what_they_left_out() -> None:
    belief = belief_on(ROOM, turn=0.4)
    states = np.array([[3, 1, 2], [9, 0, 5]])
    poses = belief.poses_of(states)
    belief.set_states(poses, np.array([0.6, 0.3]))
    kept, weights = belief.heaviest(1000)
    order = np.argsort(-weights)
    assert kept[order[:2]] == pytest.approx(poses)
    rest = 0.1 / (16 * 12)
    expected = [0.6 + rest, 0.3 + rest, *[rest] * (16 * 12 - 2)]
    assert weights[order] == pytest.approx(expected, rel=1e-4)
    assert belief.total == pytest.approx(1.0, rel=1e-6)


def test_states_kept_from_a_moved_belief_come_back_within_half_a_state() -> None:
    belief = belief_on(ROOM)
    belief.set_gaussian([3.3, -0.8, 0.3], SMALL)
    belief.predict([0.17, 0.05, 0.1])
    belief.add_floor(0.0)
    belief.settle()
    poses, weights = belief.heaviest(1000)
    again = belief_on(ROOM)
    again.set_states(poses, weights)
    moved_mean, again_mean = (
        w @ p[:, :2] / w.sum() for p, w in ((poses, weights), again.heaviest(1000))
    )
    assert again_mean == pytest.approx(moved_mean, abs=0.25)


def test_states_outside_the_map_or_in_walls_come_back_as_nothing() -> None:
    belief = belief_on(ROOM)
    belief.set_states(np.array([[99.0, 0.0, 0.0], [3.25, -0.75, 0.0]]), np.array([0.5, 0.5]))
    assert belief.total == pytest.approx(0.5)
    assert len(belief.heaviest(10)[1]) == 1


def test_heaviest_states_are_the_heaviest_and_their_weights_shares_of_all() -> None:
    belief = belief_on(ROOM)
    rng = np.random.default_rng(3)
    belief.belief[:] = rng.random(belief.belief.shape) ** 9
    belief.settle()
    poses, weights = belief.heaviest(80)
    flat = np.sort(belief.belief.ravel())[::-1]
    assert np.sort(weights)[::-1] == pytest.approx(flat[: len(weights)] / flat.sum(), rel=1e-5)
    assert 10 <= len(poses) <= 80
    assert weights.sum() < 1.0


def test_states_are_scaled_one_by_one_and_the_belief_summed_up_anew() -> None:
    belief = belief_on(ROOM)
    belief.belief[:] = np.random.default_rng(7).random(belief.belief.shape)
    belief.settle()
    before, total = belief.belief.copy(), belief.total
    states, weights = belief.heaviest_states(20)
    factors = np.linspace(0.1, 0.9, len(states)).astype(np.float32)
    belief.scale_states(states, factors)
    assert belief.belief[tuple(states.T)] == pytest.approx(before[tuple(states.T)] * factors)
    assert belief.total == pytest.approx(total * (1.0 - weights @ (1.0 - factors)), rel=1e-5)
    assert np.count_nonzero(belief.belief != before) == len(states)


def test_no_states_are_scaled_where_there_are_none() -> None:
    belief = belief_on(ROOM)
    belief.scale_states(np.empty((0, 3), np.int64), np.empty(0, np.float32))
    assert belief.total == pytest.approx(1.0)


def test_an_even_belief_of_a_large_hall_is_not_gathered_as_a_whole(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world = OccupancyMap(GridGeometry(300, 300, 0.1), np.zeros((300, 300), np.int8))
    belief = MarkovGrid(pose_grid(world, PoseGridParams(0.1, 36)), STILL)
    gathered: list[int] = []
    states_above = kernels.states_above

    def count(
        belief: np.ndarray, area: kernels.Area, chosen: np.ndarray, threshold: float
    ) -> tuple[np.ndarray, np.ndarray]:
        states, weights = states_above(belief, area, chosen, threshold)
        gathered.append(len(weights))
        return states, weights

    monkeypatch.setattr(kernels, "states_above", count)
    poses, weights = belief.heaviest(50)
    assert len(poses) == 50
    assert weights == pytest.approx(1.0 / (36 * 90_000), rel=1e-4)
    assert gathered[0] <= 50 * 300


def test_measurements_that_exclude_everything_leave_an_empty_belief_that_m2_refills() -> None:
    belief = belief_on(ROOM)
    belief.belief[:] = 1e-44
    belief.settle()
    assert belief.total == 0.0
    assert belief.entropy() == 0.0
    assert not belief.marginal().any()
    assert belief.heaviest(5)[0].shape == (0, 3)
    belief.add_floor(1.0)
    belief.settle()
    assert np.isfinite(belief.belief).all()
    assert belief.entropy() == pytest.approx(math.log2(16 * 12), abs=2e-3)


def test_entropy_is_that_of_the_naive_twin() -> None:
    belief = belief_on(ROOM)
    belief.belief[:] = np.random.default_rng(5).random(belief.belief.shape) ** 6
    belief.belief[:] *= 1e-6
    belief.settle()
    exact = naive.entropy_bits(belief.belief.astype(float))
    assert belief.entropy() == pytest.approx(exact, abs=2e-3)
