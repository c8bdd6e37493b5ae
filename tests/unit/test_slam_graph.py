"""The graph of keyframes: it closes squares, drops what is wrong, forgets what it does not need."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from naive.scan_matching import shortest_ways
from pilotage.core import se2
from pilotage.mapper.keyframes import Keyframe, KeyframeGraph
from pilotage.mapper.laser_grid_scans import DrawnScan
from pilotage.mapper.pose_edges import CLOSURE_LENGTH, TURN_LENGTH, Edge, mismatch
from pilotage.mapper.pose_graph import GraphParams, Poses, optimise
from pilotage.mapper.slam_memory import packed_graph, unpack_graph
from slam_world import apart

SIGMAS = np.array([0.02, 0.02, 0.01])
USUAL = np.diag(SIGMAS**2)
FORWARD = np.array([1.0, 0.0, 0.0])
LEFT = np.array([1.0, 0.0, np.pi / 2.0])


def square(side: int = 10) -> np.ndarray:
    """Poses (n, 3) every metre round a square, back at the beginning."""
    poses = [np.zeros(3)]
    for k in range(4 * side):
        poses.append(se2.compose(poses[-1], LEFT if k % side == side - 1 else FORWARD))
    return np.array(poses)


def keyframe(stamp: float = 0.0) -> Keyframe:
    points = np.array([[1.0, 0.0], [0.0, 1.0]])
    return Keyframe(stamp, points, (DrawnScan(stamp, np.zeros(2), points, np.ones(2, bool)),))


def graph_along(
    truth: np.ndarray, rng: np.random.Generator | None = None, sigmas: np.ndarray = SIGMAS
) -> KeyframeGraph:
    """A graph of keyframes at poses (n, 3), with noise from one to the next if random."""
    graph = KeyframeGraph(GraphParams())
    graph.append(keyframe(), truth[0], USUAL)
    for k, relative in enumerate(se2.between(truth[:-1], truth[1:]), 1):
        noise = np.zeros(3) if rng is None else sigmas * rng.standard_normal(3)
        graph.append(keyframe(float(k)), se2.compose(relative, noise), np.diag(sigmas**2))
    return graph


def closure(first: int, second: int, relative: np.ndarray, sigma: float = 0.01) -> Edge:
    return Edge(first, second, relative, np.diag([sigma**2, sigma**2, sigma**2]), is_closure=True)


def true_closure(truth: np.ndarray, first: int, second: int) -> Edge:
    return closure(first, second, se2.between(truth[first], truth[second]))


def all_poses(graph: KeyframeGraph) -> np.ndarray:
    return np.array(list(graph.poses.values()))


@pytest.mark.parametrize("seed", range(4))
def test_a_square_closes(seed: int) -> None:
    truth = square()
    graph = graph_along(truth, np.random.default_rng(seed))
    before = apart(all_poses(graph), truth)
    graph.close([true_closure(truth, 0, 40)])
    graph.relax()
    after = apart(all_poses(graph), truth)
    assert after[-1] < 0.02
    assert after.mean() < 0.6 * before.mean() + 0.02
    assert len(graph.edges) == 41


def test_a_square_closes_over_a_long_way_off() -> None:
    """Ten times the usual noise: the end is metres from the beginning."""
    truth = square()
    graph = graph_along(truth, np.random.default_rng(4), 10.0 * SIGMAS)
    assert apart(all_poses(graph), truth)[-1] > 1.0
    graph.close([true_closure(truth, 0, 40)])
    graph.relax()
    assert apart(all_poses(graph), truth)[-1] < 0.02


def test_a_wrong_closure_is_dropped_and_has_no_hold() -> None:
    truth = square()
    rng = np.random.default_rng(2)
    right = [true_closure(truth, 0, 40), true_closure(truth, 1, 39), true_closure(truth, 2, 38)]
    wrong = closure(5, 25, np.array([0.1, 0.2, 0.0]))  # 10 m apart in truth
    graph = graph_along(truth, rng)
    graph.close([*right, wrong])
    graph.relax()
    alone = graph_along(truth, np.random.default_rng(2))
    alone.close(right)
    alone.relax()
    assert wrong not in graph.edges
    assert all(edge in graph.edges for edge in right)
    assert all_poses(graph) == pytest.approx(all_poses(alone), abs=0.02)


def test_a_wrong_closure_alone_is_dropped_too() -> None:
    truth = square()
    graph = graph_along(truth, np.random.default_rng(5))
    before = all_poses(graph)
    graph.close([closure(5, 25, np.array([0.1, 0.2, 0.0]))])
    graph.relax()
    assert not any(edge.is_closure for edge in graph.edges)
    assert all_poses(graph) == pytest.approx(before, abs=0.1)


def test_the_first_pose_is_held() -> None:
    truth = se2.compose((3.0, -2.0, 0.7), square())
    graph = graph_along(truth, np.random.default_rng(1))
    graph.close([true_closure(truth, 0, 40)])
    graph.relax()
    assert graph.poses[0] == pytest.approx(truth[0], abs=1e-9)
    assert apart(all_poses(graph), truth)[-1] < 0.02


def test_without_closures_nothing_moves() -> None:
    graph = graph_along(square(), np.random.default_rng(1))
    before = all_poses(graph)
    graph.relax()
    assert se2.between(before, all_poses(graph)) == pytest.approx(0.0, abs=1e-6)


def test_one_keyframe_is_a_graph() -> None:
    poses, wrong = optimise({0: np.array([1.0, 2.0, 0.5])}, [], GraphParams())
    assert poses[0] == pytest.approx([1.0, 2.0, 0.5])
    assert wrong == set()


def test_poses_are_the_most_probable_ones() -> None:
    """Two edges that contradict each other meet where their certainties say."""
    poses: Poses = {0: np.zeros(3), 1: np.zeros(3)}
    sure, unsure = np.diag([0.01] * 3), np.diag([0.03] * 3)
    edges = [Edge(0, 1, np.array([1.0, 0.0, 0.0]), sure), Edge(0, 1, np.zeros(3), unsure)]
    solved, _ = optimise(poses, edges, GraphParams())
    assert solved[1] == pytest.approx([0.75, 0.0, 0.0], abs=1e-4)


def test_a_closure_says_how_far_it_would_move_the_keyframe() -> None:
    graph = graph_along(square())
    assert graph.moves(closure(0, 40, np.zeros(3))) == pytest.approx(0.0, abs=1e-9)
    assert graph.moves(closure(0, 40, np.array([0.3, 0.4, 0.0]))) == pytest.approx(0.5)


def test_ways_are_as_long_as_their_steps_and_turns() -> None:
    graph = graph_along(square(3))
    lengths = graph.lengths_from(0)
    turn = TURN_LENGTH * np.pi / 2.0
    assert lengths[2] == pytest.approx(2.0)
    assert lengths[12] == pytest.approx(12.0 + 4.0 * turn)
    graph.close([closure(0, 12, np.zeros(3))])
    lengths = graph.lengths_from(0)
    assert lengths[12] == pytest.approx(CLOSURE_LENGTH)
    assert lengths[11] == pytest.approx(CLOSURE_LENGTH + 1.0 + turn)


@given(st.integers(0, 10_000), st.integers(2, 14), st.integers(0, 12))
def test_ways_are_the_shortest(seed: int, count: int, more: int) -> None:
    rng = np.random.default_rng(seed)
    graph = KeyframeGraph(GraphParams())
    graph.append(keyframe(), np.zeros(3), USUAL)
    for _ in range(1, count):
        graph.append(keyframe(), rng.uniform(-2.0, 2.0, 3), USUAL)
    for one, other in rng.integers(0, count, (more, 2)).tolist():
        relative = rng.uniform(-2.0, 2.0, 3)
        graph.edges.append(Edge(one, other, relative, USUAL, is_closure=bool(rng.random() < 0.5)))
    costs = [
        CLOSURE_LENGTH
        if edge.is_closure
        else float(np.hypot(*edge.relative[:2]) + TURN_LENGTH * abs(edge.relative[2]))
        for edge in graph.edges
    ]
    told = [(*edge.ends, cost) for edge, cost in zip(graph.edges, costs, strict=True)]
    start = int(rng.integers(count))
    expected = shortest_ways(count, told, start)
    lengths = graph.lengths_from(start)
    assert [lengths[k] for k in range(count)] == pytest.approx(expected)


def test_what_is_left_out_moves_nobody() -> None:
    truth = square()
    graph = graph_along(truth, np.random.default_rng(3))
    graph.close([true_closure(truth, 0, 40), true_closure(truth, 3, 37)])
    graph.relax()
    before = dict(graph.poses)
    for number in (20, 21, 22, 35):
        graph.leave_out(number)
    assert set(before) - set(graph.poses) == {20, 21, 22, 35}
    assert all((graph.poses[k] == before[k]).all() for k in graph.poses)
    graph.relax()
    moved = [np.abs(se2.between(before[k], graph.poses[k])).max() for k in graph.poses]
    assert max(moved) < 1e-3


def test_what_is_left_out_is_still_known_of_by_its_neighbours() -> None:
    """The end is as sure, seen from the beginning, as with all that lay between."""
    truth = square(3)
    graph = graph_along(truth)
    graph.leave_out(4)
    graph.leave_out(5)
    edge = next(edge for edge in graph.edges if edge.ends == (3, 6))
    assert mismatch(edge, graph.poses[3], graph.poses[6]) == pytest.approx(0.0, abs=1e-6)
    rng = np.random.default_rng(0)
    ends = np.tile(truth[3], (20_000, 1))
    for relative in se2.between(truth[3:6], truth[4:7]):
        ends = se2.compose(ends, se2.compose(relative, SIGMAS * rng.standard_normal((20_000, 3))))
    off = se2.between(se2.compose(truth[3], edge.relative), ends)
    assert np.cov(off.T) == pytest.approx(edge.covariance, rel=0.05, abs=5e-5)


def test_closures_of_what_is_left_out_go_to_a_neighbour() -> None:
    truth = square()
    graph = graph_along(truth)
    graph.close([true_closure(truth, 0, 38)])
    graph.leave_out(38)
    closures = [edge for edge in graph.edges if edge.is_closure]
    assert len(closures) == 1
    (kept,) = closures
    assert 38 not in kept.ends
    assert 0 in kept.ends
    assert mismatch(kept, graph.poses[kept.first], graph.poses[kept.second]) < 1e-6


def test_left_out_keyframes_are_found_from_others() -> None:
    truth = square()
    graph = graph_along(truth)
    for number in (12, 13, 11):
        graph.leave_out(number)
    for number in (11, 12, 13, 14):
        anchor, pose = graph.anchored(number)
        assert anchor in graph.keyframes
        found = se2.compose(graph.poses[anchor], pose)
        assert se2.between(truth[number], found) == pytest.approx(0.0, abs=1e-9)


def test_a_place_is_crowded_with_enough_older_keyframes() -> None:
    poses = [(0, 0, 0), (0.2, 0, 0), (0, 0.2, 0.1), (0.1, 0.1, 0), (5, 0, 0), (0, 0, 2.0)]
    graph = graph_along(np.array(poses, float))
    assert graph.is_crowded(3, 0.5, 0.35, 3)
    assert not graph.is_crowded(3, 0.5, 0.35, 4)
    assert not graph.is_crowded(2, 0.5, 0.35, 3)  # younger ones do not count
    assert not graph.is_crowded(4, 0.5, 0.35, 1)
    assert not graph.is_crowded(5, 0.5, 0.35, 1)  # looks elsewhere


def test_points_are_told_as_seen_from_another_pose() -> None:
    graph = graph_along(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, np.pi / 2.0]]))
    seen = graph.points_of([1], 0)
    assert seen == pytest.approx(np.array([[2.0, 1.0], [1.0, 0.0]]), abs=1e-9)
    assert len(graph.points_of([0, 1], 1)) == 4
    assert graph.latest(1) == [1]
    assert graph.newest == 1


def test_a_list_of_the_graph_has_no_gaps() -> None:
    truth = square(3)
    graph = graph_along(truth)
    graph.close([true_closure(truth, 0, 12)])
    graph.leave_out(5)
    listed = graph.listed()
    assert listed.poses.shape == (12, 3)
    assert listed.stamps.tolist() == [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11, 12]
    assert listed.edges.max() == 11
    assert listed.is_closure.tolist().count(True) == 1
    seen = se2.between(listed.poses[listed.edges[:, 0]], listed.poses[listed.edges[:, 1]])
    assert se2.between(seen, listed.relative) == pytest.approx(0.0, abs=1e-9)
    assert listed.information.shape == (12, 3, 3)
    assert (np.linalg.eigvalsh(listed.information)[:, 0] > 0.0).all()


def test_a_graph_comes_back_from_its_arrays() -> None:
    truth = square(4)
    graph = graph_along(truth, np.random.default_rng(1))
    graph.close([true_closure(truth, 0, 16)])
    graph.leave_out(7)
    again = KeyframeGraph(GraphParams())
    unpack_graph(packed_graph(graph), again)
    assert list(again.keyframes) == list(graph.keyframes)
    assert all((again.poses[k] == graph.poses[k]).all() for k in graph.poses)
    assert [e.ends for e in again.edges] == [e.ends for e in graph.edges]
    assert [e.is_closure for e in again.edges] == [e.is_closure for e in graph.edges]
    assert all(
        (a.covariance == b.covariance).all() and (a.relative == b.relative).all()
        for a, b in zip(again.edges, graph.edges, strict=True)
    )
    assert again.anchored(7)[0] == graph.anchored(7)[0]
    assert again.keyframes[3].stamp == 3.0
    assert again.keyframes[3].points == pytest.approx(graph.keyframes[3].points)
    assert (again.keyframes[3].scans[0].is_hit == graph.keyframes[3].scans[0].is_hit).all()


def test_an_empty_graph_comes_back_empty() -> None:
    again = KeyframeGraph(GraphParams())
    unpack_graph(packed_graph(KeyframeGraph(GraphParams())), again)
    assert not again.keyframes
    assert not again.edges
    assert again.listed().poses.shape == (0, 3)


def test_a_graph_driven_over_again_and_again_keeps_few_closures() -> None:
    graph = KeyframeGraph(GraphParams())
    seen = Keyframe(0.0, np.zeros((1, 2)), ())
    graph.append(seen, np.zeros(3), USUAL)
    for _ in range(4):
        graph.append(seen, FORWARD, USUAL)
    for _ in range(60):
        graph.append(seen, np.array([0.01, 0.0, 0.0]), USUAL)
        here = graph.newest
        at = se2.between(graph.poses[0], graph.poses[here])
        graph.close([Edge(0, here, at, USUAL, is_closure=True)])
        if here > 6:
            graph.leave_out(list(graph.keyframes)[-2])
    assert sum(edge.is_closure for edge in graph.edges) <= 2 * len(graph.keyframes)
