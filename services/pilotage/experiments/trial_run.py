"""One trial: how far a robot that knows nothing drives until it is localized; pure."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import difference
from pilotage.experiments.trial_world import Ride, TrialWorld
from pilotage.experiments.trials import RIGHT_TURN, RIGHT_WAY
from pilotage.planner.situation import Policy, State

CONFIRMED = 3
"""Scans weighed in a row that must leave the robot localized."""

LONGEST_WAY, LONGEST_TIME = 60.0, 300.0
"""A trial that has not ended after so many m or s has failed."""

Clock = Callable[[], float]
"""Seconds of processor time: what a decision costs."""


@dataclass(frozen=True)
class TrialRun:
    """What came of a trial.

    `track` (n, 3): true poses at the scans; `localized`: whether the localizer said so to the end;
    `error_m`, `error_rad`: of its pose then; `travel_m`: the true way until it first said so and
    stayed with it, or the whole way; `seconds`: until the end; `steps`: scans weighed;
    `history`: what the localizer said, and how many times in a row; `decisions_s` (n,): processor
    time of each step of the policy.
    """

    track: NDArray[np.float64]
    localized: bool
    error_m: float
    error_rad: float
    travel_m: float
    seconds: float
    steps: int
    contacts: int
    history: list[tuple[State, int]]
    decisions_s: NDArray[np.float64]

    @property
    def correct(self) -> bool:
        """Whether it was localized, and where it said."""
        is_right = self.error_m <= RIGHT_WAY and self.error_rad <= RIGHT_TURN
        return self.localized and is_right


def conduct_trial(
    world: TrialWorld,
    policy: Policy,
    start: NDArray[np.float64],
    rng: np.random.Generator,
    clock: Clock,
) -> TrialRun:
    """Let a policy drive from a start pose (3,) until the robot is localized, or for too long."""
    ride = Ride(world, start, rng)
    track, costs = [], []
    ways: list[float] = []
    situation = ride.look()
    while not _is_over(ride):
        ways.extend([ride.travel_m] * (len(ride.said) - len(ways)))
        track.append(ride.truth)
        before = clock()
        speeds = policy.step(situation)
        costs.append(clock() - before)
        ride.drive(speeds)
        situation = ride.look()
    ways.extend([ride.travel_m] * (len(ride.said) - len(ways)))
    return _outcome(ride, [*track, ride.truth], ways, costs)


def _is_over(ride: Ride) -> bool:
    too_long = ride.travel_m >= LONGEST_WAY or ride.time >= LONGEST_TIME
    return too_long or _is_localized(ride)


def _is_localized(ride: Ride) -> bool:
    return ride.said[-CONFIRMED:] == ["localized"] * CONFIRMED


def _outcome(
    ride: Ride, track: list[NDArray[np.float64]], ways: list[float], costs: list[float]
) -> TrialRun:
    """Return what came of a ride whose scans were weighed after `ways` [m]."""
    localized = _is_localized(ride)
    off = ride.pose - ride.truth
    said = [(state, len(list(group))) for state, group in groupby(ride.said)]
    return TrialRun(
        track=np.array(track),
        localized=localized,
        error_m=float(np.hypot(off[0], off[1])),
        error_rad=abs(difference(float(ride.pose[2]), float(ride.truth[2]))),
        travel_m=ways[-CONFIRMED] if localized else ride.travel_m,
        seconds=ride.time,
        steps=len(ride.said),
        contacts=ride.contacts,
        history=said,
        decisions_s=np.array(costs),
    )
