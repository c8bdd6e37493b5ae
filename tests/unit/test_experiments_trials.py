"""What a run of estimates is worth: right, wrong, honest, and how soon."""

import numpy as np
import pytest

from localizer_world import COARSE, FEW_PARTICLES, flat
from pilotage.core.grid import OccupancyMap
from pilotage.experiments.clutter import CONDITIONS
from pilotage.experiments.tracks import Track
from pilotage.experiments.trials import (
    RIGHT_TURN,
    RIGHT_WAY,
    WRONG_TURN,
    WRONG_WAY,
    Outcome,
    outcome_of,
    run_trial,
    simulated_track,
)
from pilotage.localizer.estimate import Estimate
from pilotage.localizer.log_run import LogEstimate
from pilotage.localizer.markov_localizer import MarkovLocalizer
from pilotage.localizer.method import LocalizationMethod
from pilotage.localizer.methods import FINDERS, MethodSetup, make_method
from pilotage.localizer.verdict import State
from pilotage.robot.simulator.range_sensors import LaserParams

TRUTH = np.array([2.0, 3.0, 3.1])

Said = tuple[State, tuple[float, float, float]]
"""A state, and how far the estimate is off: ahead, aside, turned."""


def outcome(*said: Said, kidnapped: int | None = None) -> Outcome:
    """What estimates are worth whose robot always is at TRUTH."""
    truth = np.tile(TRUTH, (len(said), 1))
    track = Track(truth, truth, np.ones((len(said), 2), np.float32), LaserParams(), kidnapped)
    estimates = []
    for stamp, (state, off) in enumerate(said):
        pose = TRUTH + off
        estimate = Estimate(pose, np.eye(3), state, 0.1 * stamp, [], None)
        estimates.append(LogEstimate(float(stamp), pose, estimate, updated=True))
    return outcome_of(estimates, track)


EXACT = (0.0, 0.0, 0.0)
FAR = (5.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("off", "right", "wrong"),
    [
        (EXACT, True, False),
        ((0.3, 0.39, 0.0), True, False),
        ((0.0, 0.0, 0.99 * RIGHT_TURN), True, False),
        ((RIGHT_WAY + 0.01, 0.0, 0.0), False, False),
        ((0.0, 0.0, -1.01 * RIGHT_TURN), False, False),
        ((0.0, WRONG_WAY + 0.01, 0.0), False, True),
        ((0.0, 0.0, 1.01 * WRONG_TURN), False, True),
    ],
    ids=["exact", "near", "turned a little", "beside", "turned", "far", "turned away"],
)
def test_a_localized_estimate_is_right_near_the_truth_and_wrong_far_off(
    off: tuple[float, float, float], *, right: bool, wrong: bool
) -> None:
    told = outcome(("localized", off))
    assert (told.right[0], told.wrong[0]) == (right, wrong)


def test_a_turn_through_the_wrap_is_short() -> None:
    assert outcome(("localized", (0.0, 0.0, 0.1))).turn == pytest.approx([0.1])


@pytest.mark.parametrize("state", ["unknown", "ambiguous", "lost"])
def test_what_does_not_claim_to_be_localized_is_never_wrong(state: State) -> None:
    told = outcome((state, FAR))
    assert not told.wrong.any()
    assert not told.ends_right


def test_a_run_ends_right_if_its_last_estimate_is_localized_and_right() -> None:
    assert outcome(("unknown", FAR), ("localized", EXACT)).ends_right
    assert not outcome(("localized", EXACT), ("localized", FAR)).ends_right
    assert not outcome(("localized", EXACT), ("unknown", EXACT)).ends_right


def test_a_run_that_ends_ambiguous_is_told_apart() -> None:
    assert outcome(("localized", EXACT), ("ambiguous", FAR)).ends_ambiguous
    assert not outcome(("ambiguous", FAR), ("lost", FAR)).ends_ambiguous


def test_scans_to_the_fix_are_counted_from_one() -> None:
    told = outcome(("unknown", EXACT), ("localized", FAR), ("localized", EXACT))
    assert told.scans_to_fix() == 3
    assert outcome(("localized", EXACT)).scans_to_fix() == 1
    assert outcome(("unknown", EXACT), ("localized", FAR)).scans_to_fix() is None


def test_after_a_kidnapping_the_count_begins_there() -> None:
    told = outcome(
        ("localized", EXACT), ("lost", FAR), ("unknown", FAR), ("localized", EXACT), kidnapped=1
    )
    assert told.kidnapped == 1
    assert told.scans_to_fix(1) == 3


def test_confidences_are_kept_in_order() -> None:
    told = outcome(("unknown", EXACT), ("unknown", EXACT), ("unknown", EXACT))
    assert told.confidence == pytest.approx([0.0, 0.1, 0.2])


@pytest.fixture(scope="module")
def world() -> OccupancyMap:
    return flat()


@pytest.fixture(scope="module")
def methods(world: OccupancyMap) -> dict[str, LocalizationMethod]:
    """Every method there is, on the same map."""
    setup = MethodSetup(markov=COARSE, particles=FEW_PARTICLES)
    rng = np.random.default_rng(0)
    return {name: make_method(name, world, setup, rng) for name in FINDERS}


every_method = pytest.mark.parametrize("name", FINDERS)


@every_method
def test_a_method_is_tried_on_a_simulated_track(
    world: OccupancyMap, methods: dict[str, LocalizationMethod], name: str
) -> None:
    track = simulated_track(world, CONDITIONS["clean"], (25,), seed=2)
    told = run_trial(methods[name], track)
    assert len(told.way) == len(told.signs) == 25
    assert told.ends_right
    assert not told.wrong.any()
    assert (told.scans_to_fix() or 99) <= 10


@every_method
def test_a_kidnapping_is_tried_too(
    world: OccupancyMap, methods: dict[str, LocalizationMethod], name: str
) -> None:
    track = simulated_track(world, CONDITIONS["hard"], (20, 25), seed=2)
    told = run_trial(methods[name], track)
    assert told.kidnapped == 20
    assert told.ends_right
    assert not told.wrong.any()


def test_a_trial_begins_anywhere_whatever_came_before(world: OccupancyMap) -> None:
    track = simulated_track(world, CONDITIONS["clean"], (8,), seed=2)
    localizer = MarkovLocalizer(world, COARSE)
    told, again = run_trial(localizer, track), run_trial(localizer, track)
    assert (again.way == told.way).all()
    assert (again.confidence == told.confidence).all()
