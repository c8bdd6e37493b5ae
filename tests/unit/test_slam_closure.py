"""Places known again, and places that only look alike."""

from dataclasses import replace

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.mapper.keyframes import Keyframe, KeyframeGraph
from pilotage.mapper.loop_closure import Agreement, ClosureParams, find_closures
from pilotage.mapper.pose_edges import Edge
from pilotage.mapper.pose_graph import GraphParams
from pilotage.mapper.scan_tracker import TrackerParams
from pilotage.mapper.surfel_kernels import thin_points
from pilotage.mapper.surfels import SurfelParams, surfel_map
from pilotage.mapper.visibility_kernels import beams_through_walls
from slam_world import building, drawn_at, points_at

ROOMS = """
    ####################
    #......#...........#
    #......#...........#
    #..................#
    #......#.....##....#
    #......#.....##....#
    #......#...........#
    ####################
    """
NEAR_AND_FAR = """
    #####?####################
    #...#?#..................#
    #...#?#..................#
    #...#?#..................#
    #...#?#..................#
    #...#?#..................#
    #...#?#..................#
    #...#?#..................#
    #...#?#..................#
    #...#?#..................#
    #####?####################
    """
"""A small room, and a long one with the same end."""

ROOM = """
    ##############
    #............#
    #............#
    #............#
    #............#
    #............#
    #............#
    #............#
    ##############
    """
ROOM_WITH_BOX = """
    ##############
    #............#
    #....#####...#
    #....#####...#
    #....#####...#
    #....#####...#
    #....#####...#
    #............#
    ##############
    """

TRACKER = TrackerParams()
NOTHING = Agreement(explained=0.0, contradicted=1.0, through=1.0, cost=1.0)
PARAMS = ClosureParams(recent=3, company=2, around=3)
DEGREES = np.linspace(-np.pi, np.pi, 360, endpoint=False)
USUAL = np.diag([0.02, 0.02, 0.01]) ** 2


def graph_of(
    world: OccupancyMap, truth: np.ndarray, believed: np.ndarray | None = None
) -> KeyframeGraph:
    """Keyframes as seen at the true poses (n, 3), placed at the believed ones."""
    poses = truth if believed is None else believed
    graph, rng = KeyframeGraph(GraphParams()), np.random.default_rng(0)
    before = np.zeros(3)
    for k, (pose, place) in enumerate(zip(truth, poses, strict=True)):
        points = thin_points(points_at(world, pose, rng), 0.05)
        scan = drawn_at(world, pose, float(k), DEGREES)
        relative = place if k == 0 else se2.between(before, place)
        graph.append(Keyframe(float(k), points, (scan,)), relative, USUAL)
        before = place
    return graph


def to_and_fro() -> np.ndarray:
    """Into the right room and back to the beginning."""
    x = np.concatenate([np.linspace(1.6, 6.0, 14), np.linspace(5.7, 1.7, 13)])
    return np.column_stack([x, np.full(len(x), 2.6), np.zeros(len(x))])


@pytest.mark.parametrize("off", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.08), (-0.5, 0.4, -0.1)])
def test_a_place_is_known_again(off: tuple[float, float, float]) -> None:
    truth = to_and_fro()
    believed = truth.copy()
    believed[14:] = se2.compose(off, truth[14:])
    closures = find_closures(graph_of(building(ROOMS, 4), truth, believed), PARAMS, TRACKER)
    assert closures
    for edge in closures:
        assert edge.is_closure
        assert edge.second == 26
        assert edge.first < 24
        expected = se2.between(truth[edge.first], truth[26])
        assert edge.relative == pytest.approx(expected, abs=0.02)
        assert np.linalg.eigvalsh(edge.covariance)[0] > 0.0


def test_the_newest_keyframes_close_no_loop() -> None:
    graph = graph_of(building(ROOMS, 4), to_and_fro()[:8])
    assert find_closures(graph, replace(PARAMS, recent=8), TRACKER) == []
    assert all(e.first < 5 for e in find_closures(graph, PARAMS, TRACKER))


def test_far_places_are_not_tried() -> None:
    """What was seen fits well, but who is sure of the way needs not look 50 m off."""
    truth = to_and_fro()
    believed = truth.copy()
    believed[14:, 0] += 50.0
    graph = graph_of(building(ROOMS, 4), truth, believed)
    assert find_closures(graph, replace(PARAMS, recent=13, doubt=(0.0, 0.0)), TRACKER) == []


def alike() -> KeyframeGraph:
    """Of the long room's end it is believed that it is the small room seen before."""
    world = building(NEAR_AND_FAR, 4)
    small = np.array([[x, 2.2, 0.0] for x in (1.1, 1.0, 0.9, 0.9, 0.9, 1.0)])
    long = np.array([[x, 2.2, 0.0] for x in (3.3, 3.3, 3.4, 3.5)])
    return graph_of(world, np.vstack([small, long]), np.vstack([small, small[[2, 3, 1, 0]]]))


def asking(agreement: Agreement) -> ClosureParams:
    """Ask for this everywhere, of all places that might be meant."""
    return replace(PARAMS, least_score=0.2, agreement=agreement, far_agreement=agreement)


def test_who_asks_for_nothing_takes_the_one_room_for_the_other() -> None:
    assert find_closures(alike(), asking(NOTHING), TRACKER) != []


def test_nobody_sees_through_the_wall_of_a_room_that_looks_alike() -> None:
    assert find_closures(alike(), asking(replace(NOTHING, through=0.25)), TRACKER) == []


@pytest.mark.parametrize(
    "agreement", [replace(NOTHING, explained=0.95), replace(NOTHING, cost=0.05)]
)
def test_a_bad_match_is_no_place_known_again(agreement: Agreement) -> None:
    assert find_closures(alike(), asking(agreement), TRACKER) == []


def test_a_place_that_was_seen_empty_and_has_a_box_now_is_another() -> None:
    """The same room, but for what stands where beams went through before."""
    room, with_box = building(ROOM, 4), building(ROOM_WITH_BOX, 4)
    before = graph_of(room, np.tile([1.0, 2.0, 0.0], (8, 1)))
    for k in range(4):
        seen = points_at(with_box, (1.0, 2.0, 0.0))
        frame = Keyframe(10.0 + k, seen, (drawn_at(with_box, (1.0, 2.0, 0.0)),))
        before.append(frame, np.zeros(3), USUAL)
    params = replace(asking(NOTHING), recent=4)
    strict = replace(asking(replace(NOTHING, contradicted=0.10)), recent=4)
    assert find_closures(before, params, TRACKER) != []
    assert find_closures(before, strict, TRACKER) == []


def test_a_match_that_scores_badly_is_not_even_looked_at() -> None:
    assert find_closures(alike(), replace(asking(NOTHING), least_score=0.99), TRACKER) == []


def test_who_sees_nothing_near_knows_no_place() -> None:
    graph = graph_of(building(ROOMS, 4), to_and_fro())
    assert find_closures(graph, replace(PARAMS, sight=0.1), TRACKER) == []


def test_a_closure_is_never_too_sure() -> None:
    graph = graph_of(building(ROOMS, 4), to_and_fro())
    params = replace(PARAMS, error=(0.2, 0.1))
    for edge in find_closures(graph, params, TRACKER):
        assert (np.diag(edge.covariance) >= [0.04, 0.04, 0.01]).all()


def wall() -> np.ndarray:
    """Points of a wall at x = 2 from y = -1 to 1."""
    y = np.arange(-1.0, 1.0, 0.02)
    return np.column_stack([np.full(len(y), 2.0), y])


def through(end: tuple[float, float], margin: float = 0.3) -> int:
    walls = surfel_map(np.vstack([wall(), [[-0.98, 0.0]]]), SurfelParams())
    return beams_through_walls(np.zeros(2), np.array([end]), walls, margin)


def test_a_beam_that_ends_behind_a_wall_went_through_it() -> None:
    assert through((4.0, 0.0)) == 1
    assert through((3.0, 1.0)) == 1


def test_a_beam_that_ends_on_a_wall_or_before_it_did_not() -> None:
    assert through((2.0, 0.0)) == 0
    assert through((2.2, 0.0)) == 0  # within the margin
    assert through((1.0, 0.0)) == 0


def test_a_beam_past_the_end_of_a_wall_did_not_either() -> None:
    assert through((4.0, 3.0)) == 0
    assert through((-4.0, 0.0)) == 0


def test_a_beam_without_length_goes_nowhere() -> None:
    assert through((0.0, 0.0)) == 0


def test_edges_of_closures_are_marked() -> None:
    graph = graph_of(building(ROOMS, 4), to_and_fro())
    found: list[Edge] = find_closures(graph, PARAMS, TRACKER)
    graph.close(found)
    graph.relax()
    assert graph.listed().is_closure.sum() == len(found) > 0
