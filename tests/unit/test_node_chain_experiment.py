"""Robots that are put down anywhere among alike doors and make out nodes by themselves."""

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from pilotage.core import se2
from pilotage.experiments import node_chain_trial
from pilotage.experiments.catalogue import CATALOGUE
from pilotage.experiments.corridor_ride import CorridorRide
from pilotage.experiments.node_chain_plots import nodes_figure, start_figure
from pilotage.experiments.node_chain_robot import NodeSeen, NodeWatch
from pilotage.experiments.node_chain_starts import start_figures
from pilotage.experiments.node_chain_trial import ChainPlace, Start, start_anywhere
from pilotage.experiments.outcome import Request
from pilotage.experiments.report import write_report
from pilotage.topology.features import KINDS


@pytest.fixture(scope="module")
def irregular() -> ChainPlace:
    return ChainPlace.of("irregular", 0)


@pytest.fixture(scope="module")
def starts(irregular: ChainPlace) -> list[Start]:
    return [start_anywhere(irregular, np.random.default_rng([3, run]), 0) for run in range(4)]


def nodes_on(place: ChainPlace, start: tuple[float, float, float], way: float) -> list[NodeSeen]:
    robot = CorridorRide(place.floor, np.array(start), np.random.default_rng(0))
    watch, seen = NodeWatch(), []
    for _ in range(round(way / 0.2)):
        node = watch.see(robot.look())
        if node is not None:
            seen.append(node)
        robot.drive(0.2)
    return seen


def test_a_robot_makes_out_the_nodes_that_it_passes(irregular: ChainPlace) -> None:
    along = irregular.topology.places[:, 0]
    passed = along[(along > 22.5) & (along < 32.0)]
    seen = nodes_on(irregular, (21.0, 0.0, 0.0), 13.0)
    places = np.array([node.truth[0] for node in seen])
    for x in passed:
        assert np.abs(places - x).min() < 1.0


def test_the_way_between_nodes_is_that_of_odometry(irregular: ChainPlace) -> None:
    seen = nodes_on(irregular, (20.0, 0.0, 0.0), 12.0)
    for one, other in pairwise(seen):
        off = se2.between(se2.between(one.truth, other.truth), other.link.moved)
        assert np.hypot(off[0], off[1]) < 0.3
        assert abs(off[2]) < 0.1
        squared = off @ np.linalg.solve(other.link.covariance, off)
        assert squared < 25.0


def test_the_features_of_a_node_are_those_about_it(irregular: ChainPlace) -> None:
    doors = np.array([[door.x, 1.2 * door.side] for door in irregular.corridor.doors])
    for node in nodes_on(irregular, (20.0, 0.0, 0.0), 8.0):
        seen = node.link.seen
        found = seen.chosen(seen.kinds == KINDS.index("door")).moved(node.truth)
        assert len(found) > 0
        for x, y, _ in found.poses:
            assert np.hypot(*(doors - [x, y]).T).min() < 0.25


def test_among_irregular_doors_the_right_node_is_found(starts: list[Start]) -> None:
    assert [start.verdict for start in starts] == ["right"] * 4
    assert all(1 <= len(start.steps) <= 6 for start in starts)


def test_where_all_doors_are_alike_nothing_is_claimed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_chain_trial, "MOST_NODES", 6)
    start = start_anywhere(ChainPlace.of("regular", 0), np.random.default_rng(4), 0)
    assert start.verdict == "unknown"
    assert len(start.steps) == 6
    assert max(step.share for step in start.steps) < 0.6


def test_a_robot_that_comes_to_an_end_turns_round(
    irregular: ChainPlace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(node_chain_trial, "MOST_NODES", 4)
    never = replace(node_chain_trial.PARAMS, share=2.0)
    monkeypatch.setattr(node_chain_trial, "PARAMS", never)
    start = start_anywhere(irregular, np.random.default_rng(_seed_near_the_end()), 0)
    headings = np.cos([step.truth[2] for step in start.steps])
    assert headings[0] > 0.9
    assert headings[-1] < -0.9


def _seed_near_the_end() -> int:
    """A seed that puts the robot down some metres before the far end, looking there."""
    length = node_chain_trial.LENGTH
    for seed in range(1000):
        rng = np.random.default_rng(seed)
        x = rng.uniform(node_chain_trial.END, length - node_chain_trial.END)
        if length - 8.0 < x < length - 6.0 and rng.choice([0.0, np.pi]) == 0.0:
            return seed
    raise AssertionError


def test_figures_count_the_starts_by_their_end(starts: list[Start]) -> None:
    wrong = Start(starts[0].steps, "wrong", 3.0)
    unknown = Start((), "unknown", 80.0)
    figures = start_figures([*starts, wrong, unknown])
    assert figures["correct_node"] == 4
    assert figures["wrong_node"] == 1
    assert figures["still_unknown"] == 1
    assert figures["success_rate"] == pytest.approx(4 / 6)
    assert start_figures([unknown])["nodes_needed_median"] is None


def test_starts_are_drawn(irregular: ChainPlace, starts: list[Start]) -> None:
    figure = nodes_figure({"irregular": starts, "regular": [Start((), "unknown", 80.0)]})
    assert len(figure.axes) == 4
    assert start_figure(irregular, starts[0], "a start").axes[0].get_title() == "a start"


def test_the_experiment_reports_what_the_issue_asks_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(node_chain_trial, "MOST_NODES", 4)
    request, shares = Request(1, 0), list[float]()
    outcome = CATALOGUE["node-chain"].conduct(request, shares.append)
    write_report(tmp_path, {}, request, outcome)
    report = json.loads((tmp_path / "report.json").read_text("utf-8"))
    assert report["correct_node"] == 1
    assert report["success_rate"] == 1.0
    assert report["regular"]["still_unknown"] == 1
    assert sum(shares) == pytest.approx(1.0)
    assert (tmp_path / "node-chain.svg").exists()
