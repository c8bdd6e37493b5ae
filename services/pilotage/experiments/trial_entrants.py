"""Every policy that can be tried, by the name that the command line knows it by."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pilotage.experiments.trial_greedy import GreedyEntropyPolicy, gains_of
from pilotage.experiments.trial_policies import FixedPolicy, RandomPolicy
from pilotage.experiments.trial_steering import Body
from pilotage.experiments.trial_world import TrialWorld
from pilotage.planner.active_drive import ActiveDrive
from pilotage.planner.active_localization import ActiveLocalization, ActiveParams
from pilotage.planner.expected_scans import ExpectedScans, SightParams
from pilotage.planner.path_params import FollowerParams
from pilotage.planner.situation import Policy

MakePolicy = Callable[[np.random.Generator], Policy]
"""Makes a policy anew, for one run, with its own chances."""


def _greedy(trial: TrialWorld) -> MakePolicy:
    sight = replace(SightParams(), range_max=trial.robot.laser.range_max)
    gains, body = gains_of(ExpectedScans(trial.world, sight)), Body(trial.robot.drive.radius)
    return lambda _rng: GreedyEntropyPolicy(gains, body)


def _active(trial: TrialWorld) -> MakePolicy:
    usual, radius = ActiveParams(), trial.robot.drive.radius
    params = replace(
        usual,
        sight=replace(usual.sight, range_max=trial.robot.laser.range_max),
        ground=replace(usual.ground, radius=radius),
    )
    active = ActiveLocalization(trial.world, params)
    limits = FollowerParams(radius=radius)
    return lambda rng: ActiveDrive(active, rng, limits)


def _random(trial: TrialWorld) -> MakePolicy:
    body = Body(trial.robot.drive.radius)
    return lambda rng: RandomPolicy(rng, body)


def _fixed(trial: TrialWorld) -> MakePolicy:
    body = Body(trial.robot.drive.radius, gap=0.14, speed=0.45)
    return lambda _rng: FixedPolicy(body)


POLICIES: dict[str, Callable[[TrialWorld], MakePolicy]] = {
    "active": _active,
    "random": _random,
    "fixed": _fixed,
    "greedy": _greedy,
}
"""What is done once for a building, and gives what makes a policy for each run on it."""
