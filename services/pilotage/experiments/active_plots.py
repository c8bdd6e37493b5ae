"""Figures 1 to 4 of Liu et al. 2008 redrawn: the fields, and the mean error against the step."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pilotage.experiments.active_comparison import (
    CONVERGED,
    FIXED_PATH,
    POLICIES,
    Trials,
    convergence_step,
)
from pilotage.experiments.landmark_field import CARPET, START, LandmarkField, carpet
from pilotage.experiments.plots import extent_of
from pilotage.planner.landmark_targets import Field

COLOURS = {"active": "#1e8449", "fixed": "#1f77b4", "random": "#c0392b"}
MARKERS = ("s", "o", "^", "P", "X", "D")


def error_figure(field: LandmarkField, trials: Trials) -> Figure:
    """Return the mean error of each policy against the step, with the spread of its runs."""
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    axes = figure.subplots()
    for name in POLICIES:
        runs = np.array([trial.errors for trial in trials[name]])
        mean, steps = runs.mean(axis=0), np.arange(runs.shape[1])
        low, high = np.quantile(runs, (0.1, 0.9), axis=0)
        axes.fill_between(steps, low, high, color=COLOURS[name], alpha=0.13, linewidth=0.0)
        at = convergence_step(mean)
        said = "never below" if at is None else f"below from step {at}"
        axes.plot(steps, mean, color=COLOURS[name], label=f"{name}: {said}")
    axes.axhline(CONVERGED, color="grey", linestyle="--", linewidth=0.8)
    axes.set(xlabel="step", ylabel="error of position [m]", ylim=(0.0, None))
    axes.set_title(f"{field.name}: mean of {len(runs)} runs, and where four of five lie")
    axes.legend()
    axes.grid(alpha=0.3)
    return figure


def field_figure(field: LandmarkField, potentials: Field, trials: Trials) -> Figure:
    """Return the field: the environment potential, its maxima, landmarks, and the first runs."""
    figure = Figure(figsize=(10.5, 6.8), layout="constrained")
    axes = figure.subplots()
    _draw_potential(figure, axes, potentials)
    for line in field.lines:
        axes.plot(*line.T, color="white", linewidth=1.5)
    _draw_landmarks(axes, field)
    way = np.array([START[:2], *FIXED_PATH])
    axes.plot(*way.T, "--", color=COLOURS["fixed"], linewidth=1.2, label="fixed path")
    for name in ("active", "random"):
        path = trials[name][0].path
        axes.plot(*path[:, :2].T, color=COLOURS[name], linewidth=1.4, label=f"{name}, first run")
    axes.plot(*START[:2], marker=(3, 0, 0), color="black", markersize=10, label="start")
    half = CARPET[0] / 2.0, CARPET[1] / 2.0
    axes.set(xlim=(-half[0], half[0]), ylim=(-half[1], half[1]))
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title=field.name)
    figure.legend(loc="outside lower center", ncols=5, fontsize="small")
    return figure


def _draw_potential(figure: Figure, axes: Axes, potentials: Field) -> None:
    """Draw the environment potential with contours, and the maxima of both potentials."""
    geometry = carpet().geometry
    shade = axes.imshow(
        potentials.environment, cmap="YlGn", origin="lower", extent=extent_of(geometry), alpha=0.85
    )
    figure.colorbar(shade, ax=axes, label="environment potential", shrink=0.8)
    left, right, bottom, top = extent_of(geometry)
    x = np.linspace(left, right, geometry.cols + 1)[:-1] + geometry.resolution / 2.0
    y = np.linspace(bottom, top, geometry.rows + 1)[:-1] + geometry.resolution / 2.0
    axes.contour(x, y, potentials.environment, levels=10, colors="#33691e", linewidths=0.5)
    axes.plot(*potentials.window_maxima[:, :2].T, "+", color="#6a1b9a", label="M")
    axes.plot(*potentials.environment_maxima.T, "x", color="#e65100", label="S")


def _draw_landmarks(axes: Axes, field: LandmarkField) -> None:
    """Draw each class by a mark of its own."""
    classes = np.array(field.landmarks.classes)
    for kind, marker in zip(dict.fromkeys(field.landmarks.classes), MARKERS, strict=False):
        places = field.landmarks.positions[classes == kind]
        axes.plot(*places.T, marker, color="#fbc02d", markeredgecolor="black", label=kind)
