"""The corridor of Zhuang et al. 2005, and what localizes a robot in it when it is pushed aside."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.core.map_lines import map_lines
from pilotage.experiments import hybrid_dynamic, hybrid_static, hybrid_trial
from pilotage.experiments.catalogue import CATALOGUE
from pilotage.experiments.corridor_doors import (
    HALF_WIDTH,
    RECESS,
    Corridor,
    CorridorDoor,
    Spacing,
    corridor_of,
    features_of,
    floor_of,
    topology_of,
    walkable,
)
from pilotage.experiments.corridor_ride import CorridorRide
from pilotage.experiments.hybrid_localization import HybridLocalizer, fused
from pilotage.experiments.hybrid_plots import dynamic_figure, error_figure, static_figure
from pilotage.experiments.hybrid_report import (
    collision_figures,
    is_found,
    recovered_at_next_node,
    ride_figures,
)
from pilotage.experiments.hybrid_trial import (
    PEOPLE,
    START,
    Conditions,
    Place,
    Ride,
    ride_along,
    usual_place,
)
from pilotage.experiments.outcome import Request
from pilotage.experiments.report import write_report
from pilotage.localizer.line_ekf import GaussianPose
from pilotage.topology.features import KINDS

DOORS = (
    CorridorDoor(3.0, 1, is_open=False),
    CorridorDoor(3.6, -1, is_open=True),
    CorridorDoor(8.0, 1, is_open=True),
)
SHORT = Corridor(10.0, DOORS)
PUSHED = Conditions(collides=True)


@pytest.fixture(scope="module")
def place() -> Place:
    return usual_place()


@pytest.fixture(scope="module")
def quiet(place: Place) -> Ride:
    return ride_along(place, Conditions(), np.random.default_rng(1))


@pytest.fixture(scope="module")
def pushed(place: Place) -> Ride:
    return ride_along(place, PUSHED, np.random.default_rng(1))


@pytest.fixture(scope="module")
def unaided(place: Place) -> Ride:
    return ride_along(place, replace(PUSHED, corrects=False), np.random.default_rng(1))


def test_a_closed_leaf_lies_behind_the_wall_and_an_open_door_leads_to_a_room() -> None:
    floor = floor_of(SHORT)

    def is_free(x: float, y: float) -> bool:
        row, col = floor.geometry.cells_of([[x, y]])[0]
        return bool(floor.is_free[row, col])

    assert is_free(3.0, HALF_WIDTH + RECESS / 2.0)
    assert not is_free(3.0, HALF_WIDTH + RECESS + 0.03)
    assert is_free(3.6, -HALF_WIDTH - 1.0)
    assert is_free(12.0, 3.0)
    assert not is_free(1.0, HALF_WIDTH + 0.03)


def test_the_walls_of_a_corridor_are_lines_on_both_sides() -> None:
    lines = map_lines(floor_of(SHORT))
    long = lines.chosen(lines.lengths > 2.0)
    normals = np.round(np.sin(long.polar[:, 0]), 3)
    is_side = (np.abs(long.ends[:, :, 1]).max(axis=1) < HALF_WIDTH + 0.03) & (normals != 0.0)
    assert set(normals[is_side]) == {1.0, -1.0}


def test_people_walk_in_the_corridor_alone() -> None:
    free = walkable(SHORT)
    x, y = free.geometry.centres_of(np.argwhere(free.is_free)).T
    assert x.min() > 0.0
    assert x.max() < SHORT.length
    assert np.abs(y).max() < HALF_WIDTH


def test_doors_that_face_each_other_share_a_node() -> None:
    topology = topology_of(SHORT)
    assert [node.pose.tolist() for node in topology.nodes] == [
        pytest.approx([3.3, 0.0, 0.0]),
        pytest.approx([8.0, 0.0, 0.0]),
    ]
    assert [(one.start, one.end) for one in topology.edges] == [(0, 1)]
    assert topology.edges[0].length == pytest.approx(4.7)
    ids = [node.id for node in topology.nodes] + [one.id for one in topology.edges]
    assert len(set(ids)) == 3


def test_features_lie_on_the_face_of_the_wall() -> None:
    found = features_of(SHORT)
    doors = found.chosen(found.kinds == KINDS.index("door"))
    assert doors.poses[:, :2].tolist() == [
        [3.0, HALF_WIDTH],
        [3.6, -HALF_WIDTH],
        [8.0, HALF_WIDTH],
    ]
    corners = found.chosen(found.kinds == KINDS.index("corner"))
    inward = corners.poses[:2, :2] + 0.1 * np.stack(
        [np.cos(corners.poses[:2, 2]), np.sin(corners.poses[:2, 2])], axis=1
    )
    assert (inward[:, 0] > 0.0).all()
    assert (np.abs(inward[:, 1]) < HALF_WIDTH).all()


@pytest.mark.parametrize("spacing", ["irregular", "modular"])
def test_a_corridor_depends_on_its_seed_alone(spacing: Spacing) -> None:
    assert corridor_of(30.0, 3, spacing) == corridor_of(30.0, 3, spacing)
    assert corridor_of(30.0, 3, spacing) != corridor_of(30.0, 4, spacing)


def test_a_regular_corridor_looks_the_same_from_both_ends() -> None:
    corridor = corridor_of(30.0, 0, "regular")
    doors = {(round(door.x, 2), door.side) for door in corridor.doors}
    assert doors == {(round(30.0 - x, 2), -side) for x, side in doors}


def test_a_push_moves_the_robot_and_not_its_odometry(place: Place) -> None:
    robot = CorridorRide(place.floor, START, np.random.default_rng(0))
    robot.drive(1.0)
    before = robot.look()
    robot.collide(0.5, 0.35)
    after = robot.look()
    x, y, theta = se2.between(before.truth, after.truth)
    assert np.hypot(x, y) == pytest.approx(0.5)
    assert abs(theta) == pytest.approx(0.35)
    assert after.odom_from_base == pytest.approx(before.odom_from_base)


def test_a_robot_turns_round_on_the_spot(place: Place) -> None:
    robot = CorridorRide(place.floor, START, np.random.default_rng(0))
    robot.turn_round()
    assert abs(se2.between(START, robot.truth)[2]) == pytest.approx(np.pi, abs=0.1)
    assert robot.truth[:2] == pytest.approx(START[:2], abs=0.01)


def test_a_robot_that_nobody_pushes_knows_its_pose_all_the_way(quiet: Ride) -> None:
    assert quiet.pairs.mean() >= 4.85
    assert quiet.pairs.min() >= 2
    assert np.median(quiet.errors[:, 0]) < 0.05
    assert quiet.errors[:, 0].max() < 0.25
    assert quiet.collision is None
    assert quiet.next_node is None


def test_pairs_vanish_after_a_push_and_come_back_at_the_next_node(pushed: Ride) -> None:
    assert pushed.collision is not None
    assert pushed.next_node is not None
    assert pushed.pairs[pushed.collision : pushed.next_node + 1].max() <= 1
    assert pushed.cycles[pushed.next_node].correction.began_anew
    assert recovered_at_next_node(pushed)
    assert is_found(pushed, -1)
    assert pushed.pairs[pushed.next_node + 1 :].mean() >= 3.2


def test_without_nodes_a_pushed_robot_stays_lost(unaided: Ride, pushed: Ride) -> None:
    assert unaided.collision == pushed.collision
    assert not recovered_at_next_node(unaided)
    assert not is_found(unaided, -1)
    assert unaided.pairs[unaided.collision :].mean() < 1.0


def test_people_cost_pairs_and_not_the_pose(place: Place, quiet: Ride) -> None:
    among = ride_along(place, Conditions(people=PEOPLE), np.random.default_rng(2))
    assert 3.2 <= among.pairs.mean() < quiet.pairs.mean()
    assert is_found(among, -1)
    assert len(among.cycles[0].people) == PEOPLE


def test_the_same_luck_gives_the_same_ride(place: Place, quiet: Ride) -> None:
    again = ride_along(place, Conditions(), np.random.default_rng(1))
    assert again.errors == pytest.approx(quiet.errors)


def test_two_beliefs_say_more_than_either() -> None:
    one = GaussianPose(np.array([1.0, 0.0, 3.1]), np.diag([0.04, 0.01, 0.01]))
    other = GaussianPose(np.array([2.0, 0.0, -3.1]), np.diag([0.04, 0.03, 0.01]))
    both = fused(one, other)
    assert both.mean[0] == pytest.approx(1.5)
    assert abs(both.mean[2]) == pytest.approx(np.pi, abs=0.01)
    assert (np.diag(both.covariance) < np.diag(one.covariance)).all()


def test_a_node_is_reached_once(place: Place) -> None:
    robot = CorridorRide(place.floor, START, np.random.default_rng(0))
    start = GaussianPose(START, 1e-4 * np.eye(3))
    localizer = HybridLocalizer(place.walls, place.topology, start)
    before, nodes = robot.look(), []
    for _ in range(4):
        robot.drive(0.8)
        now = robot.look()
        nodes.append(localizer.track(before, now).node)
        before = now
    assert [node for node in nodes if node >= 0] == [0]


def test_figures_tell_recovered_rides_from_lost_ones(pushed: Ride, unaided: Ride) -> None:
    figures = ride_figures([pushed]) | collision_figures([pushed])
    assert figures["recovered_at_next_node"] == 1.0
    assert figures["lost_at_the_end"] == 0.0
    assert figures["mean_matched_pairs"] == pytest.approx(pushed.pairs.mean())
    assert collision_figures([unaided])["lost_at_the_end"] == 1.0
    assert collision_figures([pushed, unaided])["recovered_at_next_node"] == 0.5


def test_rides_are_drawn(place: Place, quiet: Ride, pushed: Ride, unaided: Ride) -> None:
    floor, curve = static_figure(place, [quiet]).axes
    assert np.size(curve.lines[0].get_xdata()) == 20
    assert floor.get_legend() is not None
    assert len(dynamic_figure(place, [pushed], [unaided]).axes) == 2
    assert len(error_figure({"one": [pushed], "other": [unaided]}).axes) == 2


@pytest.mark.parametrize("name", ["hybrid-static", "hybrid-dynamic"])
def test_an_experiment_reports_what_the_issue_asks_for(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(hybrid_trial, "CYCLES", 7)
    shares: list[float] = []
    request = Request(1, 0)
    outcome = CATALOGUE[name].conduct(request, shares.append)
    write_report(tmp_path, {}, request, outcome)
    report = json.loads((tmp_path / "report.json").read_text("utf-8"))
    assert report["mean_matched_pairs"] > 0.0
    assert sum(shares) == pytest.approx(1.0)
    assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    assert (tmp_path / f"{name}.svg").exists()
    if name == "hybrid-dynamic":
        assert report["recovered_at_next_node"] == 1.0
        assert report["without_nodes"]["recovered_at_next_node"] == 0.0
        assert set(hybrid_dynamic.ARMS) - {"with_nodes"} <= set(report)
    else:
        assert hybrid_static.conduct is CATALOGUE[name].conduct
