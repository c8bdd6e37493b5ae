"""Three policies on one field under the same luck, run after run; pure."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.experiments.active_filter import LandmarkFilter
from pilotage.experiments.active_policies import ActivePolicy, FixedPolicy, Policy, RandomPolicy
from pilotage.experiments.active_robot import luck_of, recognised_landmarks, walked
from pilotage.experiments.landmark_field import START, LandmarkField, carpet
from pilotage.experiments.outcome import Request
from pilotage.planner.landmark_localization import ActiveParams, LandmarkLocalization

Array = NDArray[np.float64]
POLICIES = ("active", "fixed", "random")
CONVERGED = 0.30
"""m: the mean error below which a policy has converged, if it stays there."""

FIXED_PATH = (
    *((2.4, 1.4), (1.3, 1.4), (1.3, -1.4), (0.0, -1.4), (0.0, 1.4)),
    *((-1.3, 1.4), (-1.3, -1.4), (-2.4, -1.4), (-2.4, 1.4)),
)
"""Corners of the fixed path [m]: lanes across the field, the whole of it in the end.

The paper shows dashed lines without figures. Lanes 1.2 m apart pass every landmark at 1.2 m or
less, which is how one covers a field of which one knows nothing.
"""


@dataclass(frozen=True)
class Setting:
    """What an experiment fixes: where, with how many particles, how many steps of 0.10 m."""

    field: LandmarkField
    particles: int
    steps: int


@dataclass(frozen=True)
class Trial:
    """One run of one policy: true poses (steps + 1, 3) and errors of position (steps + 1,) [m]."""

    path: Array
    errors: Array


Trials = Mapping[str, list[Trial]]
"""Runs by policy."""


def method_for(field: LandmarkField) -> LandmarkLocalization:
    """Return what the paper proposes, ready for a field."""
    return LandmarkLocalization(field.sources, carpet(), ActiveParams())


def compare(
    setting: Setting,
    method: LandmarkLocalization,
    request: Request,
    advance: Callable[[float], None],
) -> Trials:
    """Run each policy as often as asked; the k-th runs of all share their random numbers."""
    trials: dict[str, list[Trial]] = {name: [] for name in POLICIES}
    for run in range(request.runs):
        seed = [request.seed, run]
        policies: dict[str, Policy] = {
            "active": ActivePolicy(method, np.random.default_rng([*seed, 2])),
            "fixed": FixedPolicy.along(np.array(START), FIXED_PATH),
            "random": RandomPolicy(np.random.default_rng([*seed, 3])),
        }
        for name, policy in policies.items():
            trials[name].append(conduct_trial(setting, method, policy, seed))
            advance(1.0 / (len(policies) * request.runs))
    return trials


def conduct_trial(
    setting: Setting, method: LandmarkLocalization, policy: Policy, seed: list[int]
) -> Trial:
    """Let a robot that does not know where it is follow a policy."""
    sources, camera = method.sources, method.params.camera
    localizer = LandmarkFilter(sources, camera, setting.particles, [*seed, 0])
    path, errors = [np.array(START)], [_error(localizer, np.array(START))]
    for step in range(setting.steps):
        luck = luck_of(np.random.default_rng([*seed, 1, step]), len(sources.kinds))
        move, gaze = policy.step(localizer.belief, step)
        path.append(walked(path[-1], move, luck))
        sightings = recognised_landmarks(sources, path[-1], gaze, camera, luck)
        localizer.update(move, gaze, sightings, step)
        errors.append(_error(localizer, path[-1]))
    return Trial(np.array(path), np.array(errors))


def convergence_step(errors: Array) -> int | None:
    """Return the first step from which errors (steps + 1,) stay below CONVERGED; None if never."""
    above = np.nonzero(errors >= CONVERGED)[0]
    first = int(above[-1]) + 1 if len(above) else 0
    return first if first < len(errors) else None


def comparison_report(trials: Trials) -> dict[str, object]:
    """Return the figures for `report.json`; index k of a curve is after step k."""
    errors = {name: np.array([trial.errors for trial in trials[name]]) for name in trials}
    means = {name: runs.mean(axis=0) for name, runs in errors.items()}
    return {
        "convergence_step": {name: convergence_step(mean) for name, mean in means.items()},
        "final_error_m": {name: float(mean[-1]) for name, mean in means.items()},
        "active_is_best_from_step": _best_from(means),
        "curves": {
            name: {
                "mean_error_m": runs.mean(axis=0).tolist(),
                "standard_deviation_m": runs.std(axis=0).tolist(),
                "median_error_m": np.median(runs, axis=0).tolist(),
            }
            for name, runs in errors.items()
        },
        "meanings": {
            "error": "distance of the particles' mean from the true position; index k of a curve "
            "is after step k, index 0 before the first",
            "convergence_step": f"first step from which the mean error stays below {CONVERGED} m",
        },
    }


def _best_from(means: Mapping[str, Array]) -> int | None:
    """Return the first step from which on the active policy has the lowest mean error."""
    others = np.minimum(means["fixed"], means["random"])
    worse = np.nonzero(means["active"] >= others)[0]
    first = int(worse[-1]) + 1 if len(worse) else 0
    return first if first < len(others) else None


def _error(localizer: LandmarkFilter, pose: Array) -> float:
    return float(np.hypot(*(localizer.estimate - pose[:2])))
