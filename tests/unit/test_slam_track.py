"""The robot's way, told from its scans and the odometry between."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pilotage.core import se2
from pilotage.mapper.keyframes import Keyframe, KeyframeGraph
from pilotage.mapper.pose_graph import GraphParams
from pilotage.mapper.track import Track

SEEDS = st.integers(0, 10_000)
COVARIANCE = 1e-4 * np.eye(3)


def graph_at(*poses: tuple[float, float, float]) -> KeyframeGraph:
    graph = KeyframeGraph(GraphParams())
    before = np.zeros(3)
    for k, pose in enumerate(poses):
        relative = np.array(pose) if k == 0 else se2.between(before, pose)
        graph.append(Keyframe(float(k), np.empty((0, 2)), ()), relative, COVARIANCE)
        before = np.array(pose)
    return graph


def circle(stamp: float) -> np.ndarray:
    """Where odometry has the robot: round and round."""
    return np.array([np.cos(stamp), np.sin(stamp), stamp % 6.0 - 3.0])


def random_track(seed: int) -> tuple[Track, KeyframeGraph]:
    """Odometry every 0.1 s from 0 to 6 s, scans every 0.5 s from 1 to 5 s that contradict it."""
    rng = np.random.default_rng(seed)
    graph = graph_at(*(tuple(pose) for pose in rng.uniform(-2.0, 2.0, (4, 3)).tolist()))
    track = Track()
    for stamp in np.linspace(0.0, 6.0, 61):
        track.add_odometry(float(stamp), circle(stamp))
    for stamp in np.linspace(1.0, 5.0, 9):
        keyframe = int(rng.integers(4))
        track.add_scan(float(stamp), circle(stamp), keyframe, rng.uniform(-0.2, 0.2, 3))
    return track, graph


def scan_poses(track: Track, graph: KeyframeGraph) -> tuple[np.ndarray, np.ndarray]:
    scans = track.state()["scans"]
    poses = [se2.compose(graph.poses[int(row[4])], row[5:8]) for row in scans]
    return scans[:, 0], np.array(poses)


@given(SEEDS)
def test_way_leads_through_the_poses_of_the_scans(seed: int) -> None:
    track, graph = random_track(seed)
    stamps, poses = track.poses(graph)
    at, expected = scan_poses(track, graph)
    found = poses[np.searchsorted(stamps, at - 1e-9)]
    assert se2.between(expected, found) == pytest.approx(0.0, abs=1e-6)


@given(SEEDS)
def test_way_has_a_pose_for_all_odometry(seed: int) -> None:
    track, graph = random_track(seed)
    stamps, poses = track.poses(graph)
    assert stamps == pytest.approx(np.linspace(0.0, 6.0, 61))
    assert poses.shape == (61, 3)
    assert np.isfinite(poses).all()


def test_way_does_not_jump_where_scans_move_it() -> None:
    """Odometry says 1 m/s; scans move the robot 0.5 m aside in 1 s: no step is far from that."""
    track, graph = Track(), graph_at((0.0, 0.0, 0.0))
    for stamp in np.linspace(0.0, 4.0, 401):
        track.add_odometry(float(stamp), np.array([stamp, 0.0, 0.0]))
    for stamp, aside in ((1.0, 0.0), (2.0, 0.5), (3.0, -0.2)):
        track.add_scan(stamp, np.array([stamp, 0.0, 0.0]), 0, np.array([stamp, aside, 0.2 * aside]))
    _, poses = track.poses(graph)
    steps = np.diff(poses[:, :2], axis=0)
    assert np.hypot(*steps.T).max() < 0.0135
    assert np.abs(np.diff(poses[:, 2])).max() < 0.003


def test_before_the_first_scan_and_after_the_last_odometry_is_believed() -> None:
    track, graph = Track(), graph_at((5.0, 5.0, np.pi / 2.0))
    for stamp in range(5):
        track.add_odometry(float(stamp), np.array([float(stamp), 0.0, 0.0]))
    track.add_scan(1.0, np.array([1.0, 0.0, 0.0]), 0, np.zeros(3))
    track.add_scan(3.0, np.array([3.0, 0.0, 0.0]), 0, np.array([2.0, 0.0, 0.0]))
    _, poses = track.poses(graph)
    assert poses[:, 0] == pytest.approx(5.0)
    assert poses[:, 1] == pytest.approx([4.0, 5.0, 6.0, 7.0, 8.0])
    assert poses[:, 2] == pytest.approx(np.pi / 2.0)


def test_one_scan_places_the_whole_way() -> None:
    track, graph = Track(), graph_at((1.0, 2.0, np.pi))
    for stamp in range(3):
        track.add_odometry(float(stamp), np.array([float(stamp), 0.0, 0.0]))
    track.add_scan(1.0, np.array([1.0, 0.0, 0.0]), 0, np.zeros(3))
    _, poses = track.poses(graph)
    assert poses[:, :2] == pytest.approx(np.array([[2.0, 2.0], [1.0, 2.0], [0.0, 2.0]]))


def test_scans_at_the_same_time_do_no_harm() -> None:
    track, graph = Track(), graph_at((0.0, 0.0, 0.0))
    for stamp in range(3):
        track.add_odometry(float(stamp), np.zeros(3))
    for aside in (0.1, 0.2):
        track.add_scan(1.0, np.zeros(3), 0, np.array([0.0, aside, 0.0]))
    _, poses = track.poses(graph)
    assert np.isfinite(poses).all()
    assert ((poses[:, 1] > 0.09) & (poses[:, 1] < 0.21)).all()


def test_without_scans_the_way_is_odometrys() -> None:
    track = Track()
    track.add_odometry(1.0, np.array([1.0, 2.0, 0.3]))
    stamps, poses = track.poses(graph_at((9.0, 9.0, 0.0)))
    assert stamps.tolist() == [1.0]
    assert poses == pytest.approx(np.array([[1.0, 2.0, 0.3]]))


def test_an_empty_track_is_an_empty_way() -> None:
    stamps, poses = Track().poses(graph_at())
    assert (stamps.shape, poses.shape) == ((0,), (0, 3))


def test_way_moves_with_its_keyframes() -> None:
    track, graph = random_track(3)
    _, before = track.poses(graph)
    moved = np.array([4.0, -1.0, 0.7])
    graph.poses = {k: se2.compose(moved, pose) for k, pose in graph.poses.items()}
    _, after = track.poses(graph)
    assert se2.between(se2.compose(moved, before), after) == pytest.approx(0.0, abs=1e-9)


def test_way_stays_where_it_is_when_a_keyframe_is_left_out() -> None:
    track, graph = random_track(5)
    _, before = track.poses(graph)
    graph.leave_out(2)
    _, after = track.poses(graph)
    assert se2.between(before, after) == pytest.approx(0.0, abs=1e-9)


@given(SEEDS)
def test_a_track_goes_on_from_its_state(seed: int) -> None:
    track, graph = random_track(seed)
    again = Track()
    again.resume(track.state())
    for each in (track, again):
        each.add_odometry(7.0, circle(7.0))
        each.add_scan(7.0, circle(7.0), 1, np.zeros(3))
    assert (again.poses(graph)[1] == track.poses(graph)[1]).all()


def test_two_hours_are_a_few_megabytes() -> None:
    track = Track()
    for k in range(36_000):
        track.add_scan(float(k), np.zeros(3), 0, np.zeros(3))
        for _ in range(4):
            track.add_odometry(float(k), np.zeros(3))
    assert sum(array.nbytes for array in track.state().values()) < 10e6
