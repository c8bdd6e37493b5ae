"""A pose that was found at a node: who takes it, from when to when it is moved, and on the bus."""

import logging
from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from localizer_bench import STANDING, Bench, pose2
from localizer_world import ELSEWHERE, ROUND, START
from pilotage.bus.node import Node
from pilotage.core import se2
from pilotage.localizer.config import LocalizerSettings
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.method import MethodName
from pilotage.localizer.modes import Mode
from pilotage.localizer.second_chance import Found, takes
from pilotage.localizer.verdict import State
from pilotage_schemas.codec import decode
from pilotage_schemas.commands import SetPose
from pilotage_schemas.mapping import MappingStatus
from pilotage_schemas.topology import MatchedPairs, Relocalization

Array = NDArray[np.float64]

HERE, THERE = np.array([2.0, 3.0, 0.5]), np.array([9.0, 3.0, 0.5])
SURE = np.diag([0.01, 0.01, 0.003])
STILL = np.zeros(3)


def estimate(
    state: State, modes: list[tuple[float, Array]], matched: float | None = 0.9
) -> Estimate:
    found = [Mode(mass, pose, SURE) for mass, pose in modes]
    best = found[0].pose if found else np.zeros(3)
    return Estimate(best, SURE, state, 0.5, found, matched)


def found(pose: Array = HERE, matched: int = 4) -> Found:
    return Found(pose, SURE, matched)


@pytest.mark.parametrize("state", ["unknown", "lost"])
def test_whoever_knows_nothing_takes_it(state: State) -> None:
    assert takes(estimate(state, []), STILL, found())
    assert takes(estimate(state, [(0.9, THERE)]), STILL, found())


def test_a_start_that_is_being_earned_is_not_begun_again() -> None:
    assert not takes(estimate("unknown", [(0.9, HERE)]), STILL, found())
    assert takes(estimate("unknown", [(0.6, THERE), (0.3, HERE)]), STILL, found())


def test_a_lost_one_takes_it_also_where_it_is() -> None:
    assert takes(estimate("lost", [(0.9, HERE)]), STILL, found())


def test_a_localized_one_that_agrees_or_fits_well_leaves_it() -> None:
    assert not takes(estimate("localized", [(0.9, HERE)], 0.3), STILL, found())
    assert not takes(estimate("localized", [(0.9, THERE)], 0.9), STILL, found())
    assert not takes(estimate("localized", [(0.9, THERE)], None), STILL, found())


def test_a_localized_one_that_neither_agrees_nor_fits_takes_it() -> None:
    assert takes(estimate("localized", [(0.9, THERE)], 0.3), STILL, found())


def test_an_ambiguous_one_takes_what_one_of_its_modes_says_too() -> None:
    rivals = [(0.5, THERE), (0.4, HERE)]
    assert takes(estimate("ambiguous", rivals), STILL, found())
    elsewhere = found(np.array([5.0, 9.0, 0.0]))
    assert not takes(estimate("ambiguous", rivals), STILL, elsewhere)


def test_one_feature_is_too_little() -> None:
    assert not takes(estimate("lost", []), STILL, found(matched=1))


def test_beliefs_are_compared_where_odometry_has_taken_them() -> None:
    step = np.array([0.4, 0.0, 0.0])
    ahead = found(se2.compose(HERE, np.array([0.8, 0.0, 0.0])))
    rivals = estimate("ambiguous", [(0.5, HERE), (0.4, THERE)])
    assert not takes(rivals, STILL, ahead)
    assert takes(rivals, step, ahead)


def test_a_pose_is_moved_on_and_gets_less_sure() -> None:
    step = np.array([1.0, 0.1, 0.3])
    moved = found().moved(step)
    assert moved.pose == pytest.approx(se2.compose(HERE, step))
    assert np.linalg.eigvalsh(moved.covariance - SURE)[0] > -1e-9
    assert moved.covariance[2, 2] > SURE[2, 2]
    assert moved.matched == 4
    assert found().moved(STILL).covariance == pytest.approx(SURE)


class Nodes:
    """The topology service of a bench: it knows where the robot is."""

    def __init__(self, method: MethodName = "ekf") -> None:
        settings = LocalizerSettings(headings=36, method=method)
        self.bench = Bench(settings=settings)
        self.topology = Node("topology", "demo", self.bench.fabric, self.bench.clock)
        self.pairs: list[MatchedPairs] = []
        self.bench.fabric.declare_subscriber(
            "pilotage/@v1/demo/matched_lines",
            "latest_wins",
            lambda sample: self.pairs.append(decode(MatchedPairs, sample.payload)),
        )

    def say(
        self,
        pose: Array | None = None,
        matched: int = 4,
        map_id: str = "",
        covariance: Array = SURE,
    ) -> Relocalization:
        message = Relocalization(
            stamp_ns=self.bench.clock.now_ns(),
            frame_id="map",
            node=7,
            pose=pose2(self.bench.pose if pose is None else pose),
            covariance=covariance,
            matched=matched,
            map_id=map_id,
            cause="recovered",
        )
        self.put(message)
        return message

    def put(self, message: Relocalization) -> None:
        self.bench.put("relocalization", message, by=self.topology)

    def turn_about(self, times: int = 10) -> list[str]:
        return [self.bench.go((0.05, 0.0, 0.3)).state for _ in range(times)]


METHODS = pytest.mark.parametrize("method", ["markov", "mcl", "ekf"])


@METHODS
def test_every_method_begins_where_a_node_finds_the_robot(
    method: Literal["markov", "mcl", "ekf"],
) -> None:
    nodes = Nodes(method)
    nodes.bench.begin()
    nodes.bench.say_odometry()
    nodes.say()
    assert nodes.bench.latest().state == "unknown"
    assert nodes.bench.is_right(within=0.2)
    assert nodes.turn_about()[-1] == "localized"
    assert nodes.bench.is_right()


def test_after_a_collision_tracking_goes_on_at_the_next_node() -> None:
    """0.5 m and 20 degrees aside, while odometry noticed nothing."""
    nodes = Nodes()
    bench = nodes.bench
    bench.begin()
    bench.ask("set_pose", SetPose(pose=pose2(bench.pose)))
    for step in ROUND[:12]:
        bench.go(step)
    assert bench.poses[-1].state == "localized"
    assert nodes.pairs[-1].seen.shape[0] >= 3
    bench.pose = se2.compose(bench.pose, [0.3, -0.4, np.deg2rad(20.0)])
    assert bench.go(STANDING).state == "lost"
    nodes.say(se2.compose(bench.pose, [0.05, 0.05, 0.02]))
    assert nodes.turn_about()[-1] == "localized"
    assert bench.is_right()
    assert nodes.pairs[-1].seen.shape[0] >= 3


def test_a_pose_that_comes_late_is_moved_on_to_now() -> None:
    nodes = Nodes()
    nodes.bench.begin()
    nodes.bench.say_odometry()
    late = nodes.say(matched=0)
    for step in ROUND[:6]:
        nodes.bench.go(step)
    nodes.put(late.model_copy(update={"matched": 5, "seq": 0}))
    nodes.bench.latest()
    assert nodes.bench.is_right(within=0.05)


def test_a_robot_that_is_localized_is_left_alone() -> None:
    nodes = Nodes("markov")
    nodes.bench.begin()
    nodes.bench.drive_round()
    nodes.say(np.array(ELSEWHERE))
    assert nodes.bench.latest().state == "localized"
    assert nodes.bench.is_right()


def test_what_cannot_be_used_is_left(caplog: pytest.LogCaptureFixture) -> None:
    nodes = Nodes()
    nodes.say()
    nodes.bench.begin()
    with caplog.at_level(logging.WARNING):
        nodes.say()
    assert "no odometry is known" in caplog.text
    nodes.bench.say_odometry()
    nodes.say(map_id="another")
    nodes.say(matched=1)
    assert nodes.bench.method.estimate.modes == []


@pytest.mark.parametrize(
    ("pose", "covariance", "reason"),
    [
        (np.array([-40.0, 0.0, 0.0]), SURE, "not in the map's free space"),
        (np.array(START), np.diag([-1.0, 1.0, 1.0]), "not symmetric and positive"),
    ],
    ids=["off the map", "no covariance"],
)
def test_what_is_no_pose_is_told_and_ignored(
    caplog: pytest.LogCaptureFixture, pose: Array, covariance: Array, reason: str
) -> None:
    nodes = Nodes()
    nodes.bench.begin()
    nodes.bench.say_odometry()
    with caplog.at_level(logging.WARNING):
        nodes.say(pose, covariance=covariance)
    assert reason in caplog.text
    assert nodes.bench.method.estimate.modes == []


def test_nobody_begins_anew_while_a_map_is_made() -> None:
    nodes = Nodes()
    nodes.bench.begin()
    nodes.bench.say_odometry()
    nodes.bench.put(
        "mapping_status",
        MappingStatus(
            stamp_ns=nodes.bench.clock.now_ns(),
            frame_id="map",
            mode="mapping",
            sensor="laser",
        ),
        by=nodes.bench.mapper,
    )
    nodes.say()
    assert nodes.bench.method.estimate.modes == []


def test_pairs_are_published_as_long_as_walls_are_followed() -> None:
    nodes = Nodes()
    nodes.bench.begin()
    nodes.bench.ask("set_pose", SetPose(pose=pose2(np.array(START))))
    nodes.turn_about(6)
    last = nodes.pairs[-1]
    assert last.stamp_ns == nodes.bench.clock.now_ns() - 100_000_000
    assert last.node is None
    assert set(last.kinds) <= {"line", "corner"}
    assert last.kinds.count("line") >= 3
    assert np.abs(last.seen - last.expected).max() < 0.5
    nodes.bench.pose = np.array(ELSEWHERE)
    nodes.bench.go(STANDING)
    assert len(nodes.pairs[-1].kinds) < len(last.kinds), "also when they vanish"


@pytest.mark.parametrize("method", ["markov", "mcl"])
def test_other_methods_match_no_lines(method: MethodName) -> None:
    nodes = Nodes(method)
    nodes.bench.begin()
    nodes.turn_about(2)
    assert nodes.pairs == []
