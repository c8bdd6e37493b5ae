"""A drive along a corridor of the shipped office, its doors all alike, and a collision in it."""

from functools import cache
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.core.map_files import load_map
from pilotage.topology.at_nodes.arrival import Arrival, NodeWatch, Now
from pilotage.topology.features import Features
from pilotage.topology.from_drive.building import LiveBuilder
from pilotage.topology.seeing.seen_features import seen_features
from pilotage.topology.topological_map import TopologicalMap
from topology_world import drive, look, way_along

WORLDS = Path(__file__).resolve().parents[2] / "deploy" / "worlds"
CORRIDOR = [(1.5, 7.1), (33.0, 7.1)]
SPREAD = np.diag([0.03, 0.03, 0.01]) ** 2


@cache
def office() -> OccupancyMap:
    return load_map(WORLDS / "office_map.yaml")


@cache
def ridden() -> LiveBuilder:
    builder = LiveBuilder()
    for glimpse in drive(office(), CORRIDOR):
        builder.add(glimpse.stamp, glimpse.pose, glimpse.seen)
    builder.finish()
    return builder


@cache
def world() -> TopologicalMap:
    return ridden().topology("office")


def true_doors() -> NDArray[np.float64]:
    """Return the middles (n, 2) of the doors of the corridor that the robot passes, m."""
    listed = yaml.safe_load((WORLDS / "office_doors.yaml").read_text("utf-8"))["doors"]
    ends = np.array([door["ends"] for door in listed], float).reshape(-1, 2, 2)
    middles: NDArray[np.float64] = ends.mean(axis=1)
    beside = (np.abs(middles[:, 1] - 7.1) < 1.6) & (middles[:, 0] > 3.0) & (middles[:, 0] < 31.0)
    return middles[beside]


def test_most_doors_of_the_corridor_are_found_and_few_that_are_none() -> None:
    features = ridden().features
    seen = features.poses[features.kinds == 1, :2]
    seen = seen[(np.abs(seen[:, 1] - 7.1) < 1.6) & (seen[:, 0] > 3.0) & (seen[:, 0] < 31.0)]
    doors = true_doors()
    assert len(doors) >= 8
    apart = np.hypot(*np.moveaxis(doors[:, None] - seen[None], 2, 0))
    assert np.mean(apart.min(axis=1) < 0.3) >= 0.8
    assert np.mean(apart.min(axis=0) < 0.5) >= 0.7


def test_nodes_of_the_corridor_bind_several_features() -> None:
    assert 6 <= len(world().nodes) <= 16
    assert np.median([len(node.features) for node in world().nodes]) >= 4


class Patrol:
    """A robot that drives the corridor again, on the map that was built, with odometry alone."""

    def __init__(self) -> None:
        self.watch, self.rng = NodeWatch(world()), np.random.default_rng(4)
        self.map_from_odom = np.zeros(3)
        self.arrivals: list[Arrival] = []
        self.wrong: list[float] = []

    def drive(self, shift: NDArray[np.float64], at: float, *, corrects: bool) -> None:
        """Drive from end to end; at x = `at` m the robot is moved, unnoticed by odometry."""
        truth_from_odom = np.zeros(3)
        is_hit = False
        for odom in way_along([(2.0, 7.1), (30.0, 7.1)]):
            if not is_hit and odom[0] > at:
                truth_from_odom = se2.compose(odom, se2.compose(shift, se2.inverse(odom)))
                is_hit = True
            # Whoever drives keeps to the corridor: the truth is where the way is.
            truth, wheels = odom, se2.compose(se2.inverse(truth_from_odom), odom)
            seen = seen_features(look(office(), truth, self.rng))
            self._see(wheels, seen, corrects=corrects)
            off = se2.between(truth, se2.compose(self.map_from_odom, wheels))
            self.wrong.append(float(np.hypot(off[0], off[1])))

    def _see(self, wheels: NDArray[np.float64], seen: Features, *, corrects: bool) -> None:
        estimate = se2.compose(self.map_from_odom, wheels)
        arrival = self.watch.update(Now(estimate, SPREAD, wheels, seen))
        if arrival is None:
            return
        self.arrivals.append(arrival)
        if corrects and arrival.relocalizes and arrival.match is not None:
            self.map_from_odom = se2.compose(arrival.match.pose, se2.inverse(wheels))


COLLISION = np.array([0.4, -0.3, np.deg2rad(20.0)])


def test_a_collision_is_made_good_at_a_node_though_all_doors_are_alike() -> None:
    patrol = Patrol()
    patrol.drive(COLLISION, 12.0, corrects=True)
    assert max(patrol.wrong) > 0.4
    assert patrol.wrong[-1] < 0.2
    # Within the next six metres.
    hit = int(np.argmax(np.array(patrol.wrong) > 0.4))
    assert min(patrol.wrong[hit : hit + 60]) < 0.2


def test_without_correction_the_pose_stays_wrong() -> None:
    patrol = Patrol()
    patrol.drive(COLLISION, 12.0, corrects=False)
    assert patrol.wrong[-1] > 1.0


def test_on_an_undisturbed_drive_nothing_is_made_worse() -> None:
    patrol = Patrol()
    patrol.drive(np.zeros(3), 12.0, corrects=True)
    assert max(patrol.wrong) < 0.2
    reached = [arrival.node for arrival in patrol.arrivals if arrival.is_new]
    assert len(set(reached)) >= 0.7 * len(world().nodes)
