"""Starts from which it is not clear where the robot is."""

import numpy as np
import pytest

from localizer_world import flat
from pilotage.experiments import trial_starts
from pilotage.experiments.trial_starts import (
    NoStartError,
    Starts,
    find_starts,
    is_settled_at_rest,
    is_settled_by_turning,
)
from pilotage.experiments.trial_world import Ride, TrialWorld
from trial_floors import TWINS, floor_of, trial_world

TWIN_ROOMS = trial_world(TWINS)


def found(world: TrialWorld, seed: int = 0, sights: tuple[float, ...] = (12.0,)) -> Starts:
    return find_starts(world, 1, seed, sights, lambda _done: None)


def ride(world: TrialWorld, pose: tuple[float, float, float]) -> Ride:
    return Ride(world, np.array(pose), np.random.default_rng(0))


def test_a_room_that_looks_like_nothing_else_is_told_by_turning() -> None:
    assert is_settled_by_turning(ride(trial_world(flat()), (2.0, 4.9, 0.2)))


def test_one_of_two_twins_is_not_told_by_turning() -> None:
    inside = ride(TWIN_ROOMS, (1.0, 4.2, 0.4))
    assert not is_settled_at_rest(inside)
    assert not is_settled_by_turning(inside)


def test_ambiguous_starts_are_in_the_twins() -> None:
    starts = found(TWIN_ROOMS)
    assert starts.by == "turn"
    assert starts.hard == len(starts.poses) == 1
    assert (starts.poses[:, 1] > 2.0).all()


def test_the_same_seed_finds_the_same_starts() -> None:
    one, same, other = (found(TWIN_ROOMS, seed).poses for seed in (3, 3, 4))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


def test_a_sight_that_tells_everything_is_shortened(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_starts, "is_settled_at_rest", sees_far)
    monkeypatch.setattr(trial_starts, "is_settled_by_turning", sees_far)
    starts = found(TWIN_ROOMS, sights=(12.0, 8.0, 3.0))
    assert starts.range_max == 3.0
    assert starts.draws == 1


def test_a_start_that_turning_would_settle_will_do_if_there_is_no_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(trial_starts, "is_settled_at_rest", sees_far)
    monkeypatch.setattr(trial_starts, "is_settled_by_turning", lambda _ride: True)
    starts = found(TWIN_ROOMS, sights=(12.0, 8.0, 4.0, 3.0))
    assert (starts.by, starts.range_max) == ("look", 4.0)
    assert starts.hard == 0


def test_where_everything_is_told_there_is_no_start(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_starts, "is_settled_at_rest", sees_far)
    with pytest.raises(NoStartError, match="12 or 6 m tells the robot where it is"):
        found(TWIN_ROOMS, sights=(12.0, 6.0))


def sees_far(ride: Ride) -> bool:
    """Take a laser that sees 5 m or more to tell everything."""
    return bool(ride.laser.range_max >= 5.0)


def test_where_the_robot_does_not_fit_there_is_no_start() -> None:
    slit = trial_world(floor_of("### #.# ###"))
    with pytest.raises(NoStartError, match="no free place"):
        found(slit)
