"""Figures of many sonar drives: means, and spreads under the same names with `_std`."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pilotage.experiments.outcome import Outcome, Request
from pilotage.experiments.sonar_drive import Morcs2
from pilotage.experiments.sonar_errors import pose_errors
from pilotage.experiments.sonar_halls import Hall
from pilotage.experiments.sonar_maps import ON_WALL
from pilotage.experiments.sonar_plots import course_figure, maps_figure, noise_figure
from pilotage.experiments.sonar_trial import SonarTrial, try_out

MEANINGS = {
    "pose_error": "distance from the true place at the end of the way",
    "rotation_error": "mean error of a left and of a right turn; without turns, of the heading at "
    "the end of the way",
    "noise_ratio": f"occupied cells whose centre is farther than {ON_WALL} m from every true "
    "surface, over the other occupied cells; the mean of the runs' ratios",
    "plain": "centre lines of all readings, turning too, at the poses of odometry alone",
    "other models": "readings of 0.1 to 1.0 m, none while turning, at corrected poses",
}


def conduct_in(
    hall: Hall, name: str, request: Request, advance: Callable[[float], None]
) -> Outcome:
    """Drive through a hall as often as asked; report and plots under the experiment's name."""
    robot = Morcs2()
    trials: list[SonarTrial] = []
    for run in range(request.runs):
        rng = np.random.default_rng([request.seed, run])
        trials.append(try_out(hall, robot, rng))
        advance(1.0 / request.runs)
    noises = [trial.noise(hall.walls) for trial in trials]
    plots = {
        name: maps_figure(hall, trials[0]),
        f"{name}-errors": course_figure(trials),
        f"{name}-noise": noise_figure(noises),
    }
    return Outcome({"meanings": MEANINGS} | pose_report(trials) | noise_report(noises), plots)


def pose_report(trials: Sequence[SonarTrial]) -> dict[str, object]:
    """Return the errors of the ways `plain` and `corrected`, by their names."""
    plain = [pose_errors(trial.drive, trial.ways.plain) for trial in trials]
    corrected = [pose_errors(trial.drive, trial.ways.corrected) for trial in trials]
    ways = [_way_of(trial) for trial in trials]
    report: dict[str, object] = {"way_m": float(np.mean(ways))}
    for name in plain[0]:
        both = zip(plain, corrected, strict=True)
        report |= with_spread(name, [{"plain": p[name], "corrected": c[name]} for p, c in both])
    return report


def noise_report(noises: Sequence[Mapping[str, tuple[int, int]]]) -> dict[str, object]:
    """Return the share of noise by model, and what it is a share of."""
    ratios = [{name: noise / solid for name, (noise, solid) in run.items()} for run in noises]
    return (
        with_spread("noise_ratio", ratios)
        | with_spread("noise_cells", [{name: run[name][0] for name in run} for run in noises])
        | with_spread("obstacle_cells", [{name: run[name][1] for name in run} for run in noises])
    )


def with_spread(name: str, runs: Sequence[Mapping[str, float]]) -> dict[str, object]:
    """Return the means of named figures over runs, and their standard deviations."""
    table = {key: np.array([run[key] for run in runs], float) for key in runs[0]}
    return {
        name: {key: float(values.mean()) for key, values in table.items()},
        f"{name}_std": {key: float(values.std()) for key, values in table.items()},
    }


def _way_of(trial: SonarTrial) -> float:
    """Return the length of the true way, m."""
    steps = np.diff(trial.drive.truth[:, :2], axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
