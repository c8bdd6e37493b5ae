"""A smoothed way: points lie on one wall, and odometry rules where they are silent."""

from dataclasses import replace

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.mapper.graph_refinement import refine_graph
from pilotage.mapper.keyframes import Keyframe, KeyframeGraph
from pilotage.mapper.pose_graph import GraphParams
from pilotage.mapper.smoother import Chain, SmootherParams, smoothed, views_of

PARAMS = SmootherParams()
BEARINGS = np.deg2rad([-60.0, -30.0, 30.0, 60.0, 90.0, -90.0])
WIDTH = 1.2
"""m from the middle of a corridor along x to its walls."""


def corridor_scan(pose: np.ndarray) -> np.ndarray:
    """What few beams see of the two walls of a corridor, in the frame of a pose."""
    directions = pose[2] + BEARINGS
    walls = np.where(np.sin(directions) > 0.0, WIDTH, -WIDTH)
    lengths = (walls - pose[1]) / np.sin(directions)
    directed = np.stack([np.cos(BEARINGS), np.sin(BEARINGS)], axis=1)
    points: np.ndarray = directed * lengths[:, None]
    return points


def straight(count: int = 40, step: float = 0.1) -> np.ndarray:
    return np.stack([step * np.arange(count), np.zeros(count), np.zeros(count)], axis=1)


def chain_of(poses: np.ndarray, sigmas: tuple[float, float, float]) -> Chain:
    information = np.tile(np.diag(1.0 / np.square(sigmas)), (len(poses) - 1, 1, 1))
    return Chain(poses, se2.between(poses[:-1], poses[1:]), information)


def dead_reckoning(truth: np.ndarray, turn: float, seed: int = 0) -> np.ndarray:
    """Poses by odometry whose heading errs by `turn` rad a step."""
    steps = se2.between(truth[:-1], truth[1:])
    steps[:, 2] += turn * np.random.default_rng(seed).standard_normal(len(steps))
    poses = [truth[0]]
    for step in steps:
        poses.append(se2.compose(poses[-1], step))
    return np.array(poses)


def off_line(poses: np.ndarray) -> np.ndarray:
    """How far (n,) in m poses lie from the straight line that fits them best."""
    line = np.polynomial.Polynomial.fit(poses[:, 0], poses[:, 1], 1)
    distances: np.ndarray = poses[:, 1] - line(poses[:, 0])
    return distances


def test_a_bent_way_along_a_corridor_is_straightened() -> None:
    truth = straight()
    bent = dead_reckoning(truth, 0.03)
    views = views_of([corridor_scan(pose) for pose in truth])
    found, _ = smoothed(chain_of(bent, (0.01, 0.01, 0.03)), views, PARAMS)
    # What is left is a gentle curve, on which neighbours agree.
    assert np.diff(bent[:, 2]).std() > 0.02
    assert np.diff(found[1:, 2]).std() < 0.005
    assert np.abs(off_line(found)).max() < np.abs(off_line(bent)).max()


def test_a_way_that_is_right_stays_as_it_is() -> None:
    truth = straight()
    views = views_of([corridor_scan(pose) for pose in truth])
    found, _ = smoothed(chain_of(truth, (0.01, 0.01, 0.03)), views, PARAMS)
    assert found == pytest.approx(truth, abs=1e-3)


def test_odometry_alone_is_left_alone() -> None:
    bent = dead_reckoning(straight(), 0.03)
    views = views_of([np.empty((0, 2)) for _ in bent])
    found, known = smoothed(chain_of(bent, (0.01, 0.01, 0.03)), views, PARAMS)
    assert np.array_equal(found, bent)
    assert not known.any()


def test_one_broken_step_does_not_bend_the_others() -> None:
    """Odometry is torn at step 20; points say where both halves belong."""
    truth = straight()
    torn = truth.copy()
    torn[20:] = se2.compose((0.0, 0.15, 0.0), torn[20:])
    chain = chain_of(torn, (0.01, 0.01, 0.01))
    views = views_of([corridor_scan(pose) for pose in truth])
    found, _ = smoothed(chain, views, PARAMS)
    assert np.abs(off_line(torn)).max() > 0.05
    assert np.abs(off_line(found)).max() < 0.02


def test_points_know_nothing_along_a_corridor() -> None:
    truth = straight()
    views = views_of([corridor_scan(pose) for pose in truth])
    _, known = smoothed(chain_of(truth, (0.01, 0.01, 0.03)), views, PARAMS)
    middle = known[20]
    assert middle[1, 1] > 1000.0 * middle[0, 0]


def two_passes(shift: float) -> KeyframeGraph:
    """A corridor seen there and back again, the way back laid `shift` m aside."""
    there = straight(20, 0.5)
    back = se2.compose(there[::-1], (0.0, 0.0, np.pi))
    truth = np.vstack([there, back])
    graph = KeyframeGraph(GraphParams())
    sure, turning = np.diag([1e-4, 1e-4, 1e-4]), np.diag([1.0, 1.0, 1e-2])
    before = np.zeros(3)
    for number, pose in enumerate(truth):
        points = np.vstack([corridor_scan(pose), corridor_scan(pose) + np.array([0.01, 0.0])])
        laid = pose + np.array([0.0, shift if number >= 20 else 0.0, 0.0])
        edge = turning if number == 20 else sure
        graph.append(Keyframe(float(number), points, ()), se2.between(before, laid), edge)
        before = laid
    return graph


def test_what_two_passes_saw_is_laid_on_one_another() -> None:
    graph = two_passes(0.12)
    refine_graph(graph, replace(PARAMS, share=0.5, iterations=10), recent=10)
    found = np.array(list(graph.poses.values()))
    assert np.abs(found[:20, 1] - found[:19:-1, 1]).max() < 0.02


def test_a_graph_of_one_keyframe_needs_no_refinement() -> None:
    graph = KeyframeGraph(GraphParams())
    graph.append(Keyframe(0.0, np.ones((3, 2)), ()), np.zeros(3), np.eye(3))
    refine_graph(graph, PARAMS, recent=10)
    assert not graph.poses[0].any()
