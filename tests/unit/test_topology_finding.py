"""The robot on the topological map: at its nodes, and where nobody knew."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.topology.config import TopologySettings
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.topology import MatchedPairs, NodeArrival, Relocalization
from topology_bench import TopologyBench

INTO_ROOM = ((9.0, 7.0), (9.0, 2.5))
"""From the corridor through a door into a room."""


@pytest.fixture
def bench() -> TopologyBench:
    bench = TopologyBench()
    bench.describe()
    bench.put_map()
    return bench


def arrivals(bench: TopologyBench) -> list[NodeArrival]:
    return [one for one in bench.heard["node_arrival"] if isinstance(one, NodeArrival)]


def found(bench: TopologyBench) -> list[Relocalization]:
    return [one for one in bench.heard["relocalization"] if isinstance(one, Relocalization)]


def pairs(bench: TopologyBench) -> list[MatchedPairs]:
    return [one for one in bench.heard["matched_features"] if isinstance(one, MatchedPairs)]


def array(pose: Pose2) -> np.ndarray:
    return np.array([pose.x, pose.y, pose.theta])


def assert_near(pose: Pose2, truth: np.ndarray, metres: float, radians: float) -> None:
    off = se2.between(truth, array(pose))
    assert float(np.hypot(off[0], off[1])) < metres
    assert abs(float(off[2])) < radians


def test_each_node_on_the_way_is_told_once(bench: TopologyBench) -> None:
    bench.ride(*INTO_ROOM)
    names = [arrival.name.split()[0] for arrival in arrivals(bench)]
    assert names == ["corridor", "corridor", "door", "room"]
    assert all(arrival.matched <= arrival.bound for arrival in arrivals(bench))
    assert arrivals(bench)[2].matched >= 3


def test_at_a_node_its_features_are_shown_beside_those_seen(bench: TopologyBench) -> None:
    bench.ride(*INTO_ROOM)
    most = max(pairs(bench), key=lambda message: len(message.kinds))
    assert len(most.kinds) >= 4
    assert {"corner"} <= set(most.kinds)
    np.testing.assert_allclose(most.seen, most.expected, atol=0.35)
    corners = np.array([kind == "corner" for kind in most.kinds])
    np.testing.assert_array_equal(most.seen[corners, :2], most.seen[corners, 2:])


def test_between_nodes_there_are_no_pairs(bench: TopologyBench) -> None:
    bench.ride(*INTO_ROOM)
    at_none = [message for message in pairs(bench) if message.node is None]
    assert at_none
    assert all(message.kinds == () for message in at_none)
    # Told once: after that silence says the same.
    numbers = [message.seq for message in at_none]
    assert all(after - before > 1 for before, after in itertools.pairwise(numbers))


def test_a_right_pose_is_left_alone(bench: TopologyBench) -> None:
    bench.ride(*INTO_ROOM)
    assert found(bench) == []


@pytest.mark.parametrize("error", [(0.4, 0.3, 0.3), (0.2, -0.4, -0.3), (-0.4, 0.3, 0.1)])
def test_a_collision_is_made_good_at_the_next_node(
    bench: TopologyBench, error: tuple[float, float, float]
) -> None:
    bench.ride((9.0, 7.0), (9.0, 4.5))
    for _ in range(30):
        bench.move((0.1, 0.0, 0.0))
        bench.look(error=error)
        if found(bench):
            break
    (message,) = found(bench)
    assert message.cause == "recovered"
    assert message.matched >= 3
    assert_near(message.pose, bench.pose, 0.05, 0.03)
    assert message.stamp_ns == bench.clock.now_ns()
    assert message.map_id == bench.heard["topology"][-1].map_id


def test_who_is_lost_after_a_node_is_found_at_the_next(bench: TopologyBench) -> None:
    bench.ride((9.0, 7.0), (9.0, 5.8))
    bench.ride((9.0, 2.5), state="lost")
    (first, *_) = found(bench)
    assert first.cause == "recovered"
    assert_near(first.pose, np.array([9.0, first.pose.y, -np.pi / 2.0]), 0.05, 0.03)


def test_an_unknown_start_is_told_by_the_chain_of_places(bench: TopologyBench) -> None:
    bench.ride((10.0, 7.0), (9.0, 7.0), state="unknown")
    bench.ride((9.0, 2.0), (9.0, 7.0), (2.45, 7.0), (2.45, 11.0), state="unknown")
    (first, *_) = found(bench)
    assert first.cause == "chain"
    truth = dict(bench.way)[first.stamp_ns]
    assert_near(first.pose, truth, 0.3, 0.15)
    assert np.linalg.eigvalsh(first.covariance).min() > 0.0


def test_without_any_word_about_the_pose_the_chain_finds_it_too(bench: TopologyBench) -> None:
    bench.ride((10.0, 7.0), (9.0, 7.0), (9.0, 2.0), (9.0, 7.0), (2.45, 7.0), state=None)
    assert {message.cause for message in found(bench)} == {"chain"}


def test_a_chain_is_broken_where_odometry_begins_anew(bench: TopologyBench) -> None:
    bench.ride((10.0, 7.0), (9.0, 7.0), (9.0, 6.6), state="unknown")
    bench.odom = bench.odom + np.array([50.0, 0.0, 0.0])
    # Without the break it is found before here.
    bench.ride((9.0, 5.5), state="unknown")
    assert found(bench) == []


@pytest.mark.parametrize("place", [(2.7, 9.5, 1.57), (10.5, 7.0, 3.14), (7.5, 2.0, 0.5)])
def test_who_is_carried_away_is_not_found_where_he_is_not(
    bench: TopologyBench, place: tuple[float, float, float]
) -> None:
    bench.ride((9.0, 7.0), (9.0, 5.8))
    bench.carry(place)
    x, y, theta = place
    ahead = x + 1.2 * np.cos(theta), y + 1.2 * np.sin(theta)
    bench.ride(ahead, (x, y), state="lost")
    truth = dict(bench.way)
    for message in found(bench):
        assert_near(message.pose, truth[message.stamp_ns], 0.5, 0.26)


def test_poses_are_not_published_where_nobody_wants_them() -> None:
    bench = TopologyBench(settings=TopologySettings(relocalizes=False))
    bench.describe()
    bench.put_map()
    bench.ride((9.0, 7.0), (9.0, 4.5))
    for _ in range(20):
        bench.move((0.1, 0.0, 0.0))
        bench.look(error=(0.4, 0.3, 0.3))
    assert found(bench) == []
    assert arrivals(bench)


def test_while_a_map_is_made_nobody_is_found_on_it(bench: TopologyBench) -> None:
    bench.put_status("mapping")
    bench.put_growing_map()
    bench.ride(*INTO_ROOM, owner=bench.mapper)
    assert arrivals(bench) == []
    assert pairs(bench) == []


def test_without_the_lasers_mount_nothing_is_seen(tmp_path: Path) -> None:
    bench = TopologyBench(tmp_path)
    bench.put_map()
    bench.ride(*INTO_ROOM)
    assert arrivals(bench) == []


def test_scans_are_searched_as_seldom_as_is_wanted() -> None:
    bench = TopologyBench(settings=TopologySettings(scan_period=1.0))
    bench.describe()
    bench.put_map()
    bench.pose = np.array([9.0, 5.8, -1.57])
    for _ in range(20):
        bench.look()
    stamps = [message.stamp_ns for message in pairs(bench)]
    assert len(stamps) == 4
    assert min(np.diff(stamps)) >= 990_000_000
