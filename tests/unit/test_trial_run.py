"""One trial: what is driven, seen and said, and when it ends."""

import itertools
import json
from collections.abc import Callable

import numpy as np
import pytest

from localizer_world import flat
from pilotage.core import se2
from pilotage.experiments import trial_run
from pilotage.experiments.trial_plots import track_figure
from pilotage.experiments.trial_policies import RandomPolicy
from pilotage.experiments.trial_report import report_of
from pilotage.experiments.trial_run import CONFIRMED, TrialRun, conduct_trial
from pilotage.experiments.trial_starts import Starts
from pilotage.experiments.trial_world import PERIOD_S, SAMPLES, Ride
from pilotage.planner.situation import Situation, Speeds
from trial_floors import ROOM_WITH_PILLAR, TWINS, Deaf, trial_world

FLAT = trial_world(flat())
IN_A_TWIN = np.array([1.8, 4.0, 0.4])
IN_THE_FLAT = np.array([2.0, 4.9, 0.2])
STARTS = Starts(np.array([IN_A_TWIN]), 12.0, by="turn", draws=9, unsettled=5, probed=4, hard=1)


class Straight:
    """Drives straight on, or on a circle, whatever it is told."""

    def __init__(self, linear: float = 0.4, angular: float = 0.0) -> None:
        self.speeds = linear, angular
        self.seen: list[Situation] = []

    def step(self, situation: Situation) -> Speeds:
        self.seen.append(situation)
        return self.speeds


def ticking() -> Callable[[], float]:
    """A clock by which everything takes a second."""
    return itertools.count().__next__


def in_the_flat(seed: int = 1) -> TrialRun:
    rng = np.random.default_rng(seed)
    return conduct_trial(FLAT, Straight(0.3), IN_THE_FLAT, rng, ticking())


def test_a_robot_that_goes_on_looking_is_localized_and_right() -> None:
    run = in_the_flat()
    assert run.localized
    assert run.correct
    assert run.error_m < 0.2
    assert run.contacts == 0


def test_the_way_counts_until_it_was_first_said() -> None:
    run = in_the_flat()
    driven = np.hypot(*np.diff(run.track[:, :2], axis=0).T).sum()
    assert run.history[-1] == ("localized", CONFIRMED)
    assert sum(times for _, times in run.history) == run.steps
    assert 0.0 < run.travel_m < driven - 0.2


def test_each_decision_is_timed() -> None:
    run = in_the_flat()
    assert np.array_equal(run.decisions_s, np.ones(len(run.track) - 1))
    assert run.seconds == pytest.approx(PERIOD_S * len(run.decisions_s))


def test_the_same_seed_gives_the_same_run() -> None:
    errors = [in_the_flat(seed).error_m for seed in (1, 1, 2)]
    assert errors[0] == errors[1] != errors[2]


def test_twins_are_told_apart_outside() -> None:
    world = trial_world(TWINS)
    policy = RandomPolicy(np.random.default_rng(3))
    run = conduct_trial(world, policy, IN_A_TWIN, np.random.default_rng(3), ticking())
    assert run.correct
    assert run.travel_m > 0.5
    assert "ambiguous" in dict(run.history)


def test_a_trial_that_leads_nowhere_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_run, "LONGEST_TIME", 2.0)
    world = trial_world(ROOM_WITH_PILLAR, method=Deaf)
    start = np.array([1.0, 1.2, 0.0])
    run = conduct_trial(world, Straight(0.0), start, np.random.default_rng(0), ticking())
    assert not run.localized
    assert not run.correct
    assert run.seconds == pytest.approx(2.0)
    assert run.travel_m == 0.0


def test_a_trial_ends_after_a_long_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_run, "LONGEST_WAY", 0.5)
    world = trial_world(ROOM_WITH_PILLAR, method=Deaf)
    start = np.array([1.0, 1.2, 0.0])
    run = conduct_trial(world, Straight(0.4), start, np.random.default_rng(0), ticking())
    assert 0.5 <= run.travel_m < 0.6


def test_running_into_walls_is_counted_once_each() -> None:
    ride = Ride(trial_world(ROOM_WITH_PILLAR, method=Deaf), np.array([1.0, 1.2, np.pi]), rng())
    for speeds in [(0.5, 0.0)] * 20 + [(-0.3, 0.0)] * 5 + [(0.5, 0.0)] * 10:
        ride.drive(speeds)
    assert ride.contacts == 2


def test_the_belief_goes_along_with_the_robot_between_two_scans_weighed() -> None:
    ride = Ride(FLAT, IN_THE_FLAT, rng())
    first = ride.look()
    ride.drive((0.3, 0.0))
    second = ride.look()
    assert len(ride.said) == 1
    assert len(first.belief.weights) <= SAMPLES
    assert first.belief.weights.sum() == pytest.approx(1.0)
    moved = se2.compose(first.belief.poses, second.odom_from_base)
    assert second.belief.poses == pytest.approx(moved)


def test_what_is_seen_is_what_is_there() -> None:
    ride = Ride(FLAT, IN_THE_FLAT, rng())
    view = ride.look().view
    in_map = se2.transform_points(IN_THE_FLAT, view.points)
    gaps = [FLAT.walls.nearest(x, y, 1.0)[0] for x, y in in_map]
    assert np.median(gaps) < 0.02


def test_the_report_has_what_other_programs_rely_on() -> None:
    run = in_the_flat()
    report = json.loads(json.dumps(report_of(STARTS, [run]), allow_nan=False))
    (entry,) = report["runs"]
    assert {"localized", "correct", "travel_m", "steps"} <= set(entry)
    assert entry["start"] == IN_A_TWIN.tolist()
    assert report["laser_range_m"] == 12.0
    assert report["summary"]["correct_share"] == 1.0
    assert report["summary"]["median_travel_m"] == run.travel_m
    assert report["summary"]["contacts"] == 0


def test_the_picture_says_what_came_of_the_runs() -> None:
    figure = track_figure(FLAT.world, [in_the_flat()], "flat")
    assert figure.axes[0].get_title() == "flat: 1 correct"


def rng() -> np.random.Generator:
    return np.random.default_rng(0)
