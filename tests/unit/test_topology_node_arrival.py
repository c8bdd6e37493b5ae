"""Nodes reached by the estimate and by their features; poses found anew after a collision."""

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from feature_scenes import corridor_map, door, even_corridor, long_corridor, seen_from
from pilotage.core import se2
from pilotage.topology.at_nodes.arrival import Arrival, NodeWatch, Now
from pilotage.topology.features import Features

NODES = [1.0, 4.0, 8.0, 12.0, 16.0, 20.0, 24.0, 28.0]
SPREAD = np.diag([0.03, 0.03, 0.01]) ** 2


class Walk:
    """A robot in the corridor: where it is, where odometry and the estimate put it."""

    def __init__(self, world: Features, x: float = 0.5, missed: float = 0.1) -> None:
        self.world, self.missed = world, missed
        self.rng = np.random.default_rng(3)
        self.truth = np.array([x, 0.0, 0.0])
        self.odom = np.zeros(3)
        self.map_from_odom = self.truth.copy()
        self.watch = NodeWatch(corridor_map(world, NODES))
        self.arrivals: list[Arrival] = []

    def drive(self, metres: float, *, has_failed: bool = False, corrects: bool = True) -> None:
        """Drive on; the estimate takes over what it is told, if it `corrects`."""
        for _ in range(round(metres / 0.1)):
            step = np.array([0.1, 0.0, 0.0])
            self.truth, self.odom = se2.compose(self.truth, step), se2.compose(self.odom, step)
            arrival = self.watch.update(self.now(has_failed=has_failed))
            if arrival is None:
                continue
            self.arrivals.append(arrival)
            if arrival.relocalizes and corrects:
                assert arrival.match is not None
                self.map_from_odom = se2.compose(arrival.match.pose, se2.inverse(self.odom))
                return

    def now(self, *, has_failed: bool = False) -> Now:
        seen = seen_from(self.truth, self.world, self.rng, self.missed, reach=6.0)
        estimate = se2.compose(self.map_from_odom, self.odom)
        return Now(estimate, SPREAD, self.odom, seen, has_failed)

    def collide(self, shift: ArrayLike) -> None:
        """Push the robot, which neither odometry nor the estimate notices."""
        self.truth = se2.compose(self.truth, shift)

    @property
    def error(self) -> NDArray[np.float64]:
        off = se2.between(self.truth, se2.compose(self.map_from_odom, self.odom))
        return np.array([np.hypot(off[0], off[1]), abs(off[2])])


def reached(walk: Walk) -> list[int]:
    return [arrival.node for arrival in walk.arrivals if arrival.is_new]


def test_each_node_on_the_way_is_reached_once() -> None:
    walk = Walk(long_corridor())
    walk.drive(20.0)
    assert reached(walk) == [0, 1, 2, 3, 4, 5]


def test_a_right_estimate_is_left_alone() -> None:
    walk = Walk(long_corridor())
    walk.drive(20.0)
    assert not any(arrival.relocalizes for arrival in walk.arrivals)


def test_a_robot_that_sways_at_the_border_of_a_node_reaches_it_once() -> None:
    walk = Walk(long_corridor())
    for x in [0.35, 0.45, 0.35, 0.45, 0.35, 0.45]:
        walk.truth = np.array([x, 0.0, 0.0])
        walk.odom = se2.between(walk.map_from_odom, walk.truth)
        arrival = walk.watch.update(walk.now())
        walk.arrivals += [arrival] if arrival else []
    assert reached(walk) == [0]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_collision_is_noticed_at_the_next_node(side: float) -> None:
    walk = Walk(long_corridor())
    walk.drive(5.0)
    walk.collide([0.4, 0.3 * side, np.deg2rad(20.0) * side])
    # The robot turns back along the corridor, as whoever drives it would.
    back = np.array([0.0, 0.0, -np.deg2rad(20.0) * side])
    walk.truth, walk.odom = se2.compose(walk.truth, back), se2.compose(walk.odom, back)
    assert walk.error[0] > 0.4
    walk.drive(4.0)
    assert walk.arrivals[-1].relocalizes
    assert walk.error[0] < 0.15
    assert walk.error[1] < 0.08


def test_a_lost_robot_is_found_at_a_node_that_its_estimate_is_far_from() -> None:
    walk = Walk(long_corridor())
    walk.drive(4.0)
    # The estimate has run away; odometry has not.
    walk.map_from_odom = se2.compose([8.0, 3.0, 2.0], walk.map_from_odom)
    walk.drive(5.0, has_failed=True)
    assert walk.arrivals[-1].relocalizes
    assert walk.error[0] < 0.15


def test_an_estimate_that_nobody_knows_is_a_lost_one() -> None:
    walk = Walk(long_corridor())
    walk.drive(4.0)
    walk.map_from_odom = np.full(3, np.nan)
    walk.drive(5.0)
    assert walk.arrivals[-1].relocalizes
    assert walk.error[0] < 0.15


def test_a_robot_that_has_never_been_at_a_node_is_not_found() -> None:
    walk = Walk(long_corridor())
    walk.drive(8.0, has_failed=True)
    assert not walk.arrivals


def test_odometry_that_began_anew_tells_nothing_of_where_the_robot_is() -> None:
    walk = Walk(long_corridor())
    walk.drive(4.0)
    walk.watch.forget_odometry()
    walk.arrivals.clear()
    walk.drive(3.0, has_failed=True)
    assert not walk.arrivals


def test_doors_that_are_all_alike_move_no_lost_robot() -> None:
    walk = Walk(even_corridor(30), missed=0.0)
    walk.drive(6.0)
    before = walk.map_from_odom.copy()
    walk.drive(6.0, has_failed=True)
    # Whatever it takes over must be right; a door farther along would be wrong.
    assert walk.error[0] < 0.3 or np.array_equal(walk.map_from_odom, before)


def test_nodes_without_features_are_reached_all_the_same() -> None:
    walk = Walk(Features.none())
    walk.drive(8.0)
    assert reached(walk) == [0, 1, 2]
    assert all(arrival.match is None for arrival in walk.arrivals)


def test_two_features_alone_move_nobody() -> None:
    walk = Walk(Features.joined([door(5.0, 1.0), door(5.9, -1.0)]), missed=0.0)
    walk.drive(1.0)
    walk.map_from_odom = se2.compose([0.4, 0.0, 0.0], walk.map_from_odom)
    walk.drive(4.0)
    assert not any(arrival.relocalizes for arrival in walk.arrivals)
