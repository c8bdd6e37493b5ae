"""Greedy entropy: the fixed move that tells most for its length; and every policy by its name."""

import numpy as np
import pytest
from numpy.typing import NDArray

from pilotage.core.laser_view import View
from pilotage.experiments.trial_entrants import POLICIES
from pilotage.experiments.trial_greedy import DIRECTIONS, LENGTHS, GreedyEntropyPolicy, gains_of
from pilotage.experiments.trial_run import conduct_trial
from pilotage.planner.expected_scans import ExpectedScans, SightParams
from pilotage.planner.situation import Hypotheses, Situation
from trial_floors import TWINS, trial_world

ALL_AROUND = np.linspace(-np.pi, np.pi, 61)
TWIN_PLACES = np.array([[1.8, 4.0, -np.pi / 2.0], [8.6, 4.0, -np.pi / 2.0]])
"""The same spot in both rooms, looking at the door."""


class Wish:
    """Wants to be as far along one direction as can be; remembers what it was asked."""

    def __init__(self, direction: float) -> None:
        self.towards = np.array([np.cos(direction), np.sin(direction)])
        self.asked = np.zeros((0, 2))

    def __call__(self, places: Hypotheses, points: NDArray[np.float64]) -> NDArray[np.float64]:
        del places
        self.asked = points
        gains: NDArray[np.float64] = 5.0 * points @ self.towards
        return gains


def situation(*points: tuple[float, float]) -> Situation:
    view = View(np.array(points, float).reshape(-1, 2), ALL_AROUND)
    return Situation(0.0, np.zeros(3), view, Hypotheses(np.zeros((1, 3)), np.ones(1)), "ambiguous")


def test_in_the_open_every_move_is_weighed() -> None:
    wish = Wish(0.0)
    GreedyEntropyPolicy(wish).step(situation())
    assert len(wish.asked) == DIRECTIONS * len(LENGTHS)


def test_it_turns_to_the_best_move() -> None:
    linear, angular = GreedyEntropyPolicy(Wish(np.pi / 2.0)).step(situation())
    assert linear == 0.0
    assert angular > 0.5


def test_moves_into_what_is_seen_are_left_out() -> None:
    wish = Wish(0.0)
    wall = [(1.5, float(y)) for y in np.arange(-1.0, 1.0, 0.02)]
    GreedyEntropyPolicy(wish).step(situation(*wall))
    ahead = wish.asked[np.abs(wish.asked[:, 1]) < 0.1]
    assert ahead[:, 0].max() == pytest.approx(1.0)


def test_with_no_room_for_any_move_it_turns_on_the_spot() -> None:
    ring = [(0.5 * float(np.cos(a)), 0.5 * float(np.sin(a))) for a in np.arange(0.0, 6.3, 0.02)]
    assert GreedyEntropyPolicy(Wish(0.0)).step(situation(*ring)) == (0.0, 1.2)


def test_twins_are_told_apart_outside_their_doors_and_not_inside() -> None:
    places = Hypotheses(TWIN_PLACES, np.array([0.5, 0.5]))
    gains = gains_of(ExpectedScans(TWINS, SightParams(resolution=0.1)))
    inside, outside = gains(places, np.array([[0.4, 0.0], [2.6, 0.0]]))
    assert outside > inside + 0.3


@pytest.mark.parametrize("name", POLICIES)
def test_every_policy_tells_the_twins_apart_without_touching_anything(name: str) -> None:
    world = trial_world(TWINS)
    policy = POLICIES[name](world)(np.random.default_rng(1))
    noise = np.random.default_rng(2)
    run = conduct_trial(world, policy, np.array([1.8, 4.0, 0.4]), noise, lambda: 0.0)
    assert run.correct
    assert run.contacts == 0
