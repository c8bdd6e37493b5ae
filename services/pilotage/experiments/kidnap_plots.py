"""Plots of kidnappings: the course of belief and error, and one of them in the hall."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pilotage.experiments.kidnapping import STEPS_BEFORE, Kidnapping
from pilotage.experiments.plots import PATH, WITH, WITHOUT, draw_arrows, draw_place
from pilotage.experiments.ranger_localizer import Place

COLOURS = {"m1": WITHOUT, "m2": WITH}
NAMES = {"m1": "M1 (eq. 3)", "m2": "M2 (eq. 8)"}


def course_figure(kidnappings: list[Kidnapping]) -> Figure:
    """Return the belief at the true place, and the error of the best one, against the step."""
    figure = Figure(figsize=(9.0, 6.4), layout="constrained")
    shares, distances = figure.subplots(2, 1, sharex=True)
    for name, colour in COLOURS.items():
        seen = [kidnapping.seen[name] for kidnapping in kidnappings]
        _draw_course(shares, np.array([one.share for one in seen]), colour, NAMES[name])
        _draw_course(distances, np.array([one.error_m for one in seen]), colour, NAMES[name])
    shares.set(ylabel="belief at the true place", ylim=(-0.03, 1.03))
    distances.set(
        xlabel="steps since the kidnapping", ylabel="error of the most probable place [m]"
    )
    shares.set_title(f"{len(kidnappings)} kidnappings: every run, and the median")
    for axes in (shares, distances):
        axes.axvline(0.0, color="black", linewidth=0.8, linestyle="--")
        axes.legend(loc="center right", fontsize="small")
        axes.grid(alpha=0.3)
    return figure


def event_figure(place: Place, kidnapping: Kidnapping) -> Figure:
    """Return one kidnapping in its hall: the true path, and where each algorithm sees it."""
    figure = Figure(figsize=(13.0, 7.2), layout="constrained")
    before, after = kidnapping.path[:STEPS_BEFORE], kidnapping.path[STEPS_BEFORE:]
    for axes, name in zip(figure.subplots(1, 2), COLOURS, strict=True):
        draw_place(axes, place.world)
        for part, label in ((before, None), (after, "true path")):
            axes.plot(*part[:, :2].T, color=PATH, linewidth=1.2, label=label)
        axes.annotate("", after[0, :2], before[-1, :2], arrowprops={"arrowstyle": "->", "ls": ":"})
        axes.annotate("$l_1$", before[0, :2], (4, 4), textcoords="offset points")
        axes.annotate("$l_i$", after[0, :2], (4, 4), textcoords="offset points")
        poses = kidnapping.seen[name].poses
        draw_arrows(axes, poses[:STEPS_BEFORE:5], "grey", "most probable before")
        draw_arrows(axes, poses[STEPS_BEFORE::5], COLOURS[name], "most probable afterwards")
        axes.set_title(NAMES[name])
        axes.legend(loc="upper right", fontsize="small")
    return figure


def _draw_course(axes: Axes, values: NDArray[np.float64], colour: str, label: str) -> None:
    """Draw runs (runs, steps) faintly and their median."""
    steps = np.arange(values.shape[1]) - STEPS_BEFORE + 1
    axes.plot(steps, values.T, color=colour, alpha=0.15, linewidth=0.7)
    # A belief that died out has no error any more: the median is over those that live.
    lives = np.isfinite(values).any(axis=0)
    middle = np.nanmedian(values[:, lives], axis=0)
    axes.plot(steps[lives], middle, color=colour, linewidth=1.8, label=label)
