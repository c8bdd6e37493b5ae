"""The thesis's figures redrawn: maps by model with the true walls, errors and noise beside them."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from pilotage.core.grid import OccupancyMap
from pilotage.experiments.plots import PATH, WITH, WITHOUT, extent_of
from pilotage.experiments.sonar_drive import TICK
from pilotage.experiments.sonar_errors import distances, pose_errors
from pilotage.experiments.sonar_halls import Hall
from pilotage.experiments.sonar_trial import SonarTrial
from pilotage.experiments.wall_segments import Floats

TITLES = {
    "plain": "plain: centre line, uncorrected",
    "centre_line": "centre line, corrected",
    "bayes": "Bayesian grid, corrected",
    "atm": "ATM, corrected",
    "improved_atm": "improved ATM, corrected",
}
WAYS = {"plain": WITHOUT, "corrected": WITH}
SHADES = {
    "plain": WITHOUT,
    "centre_line": "#d68910",
    "bayes": "#7d8a8c",
    "atm": "#1f77b4",
    "improved_atm": WITH,
}


def maps_figure(hall: Hall, trial: SonarTrial) -> Figure:
    """Return one drive and its maps by every model, each with the true walls."""
    low, high = _frame(hall.walls)
    width, height = high - low
    columns = 2 if width > 2.0 * height else 3
    rows = -(-(len(trial.maps) + 1) // columns)
    figure = Figure(
        figsize=(14.0, 0.8 + rows * (14.0 / columns * height / width + 0.5)), layout="constrained"
    )
    panels = figure.subplots(rows, columns).flat
    first = next(panels)
    draw_walls(first, hall.walls)
    for way, colour, label in (
        (trial.ways.truth, PATH, "true way"),
        (trial.ways.plain, WITHOUT, "odometry"),
        (trial.ways.corrected, WITH, "corrected"),
    ):
        first.plot(*way[:, :2].T, color=colour, linewidth=1.2, label=label)
    first.plot(*trial.ways.truth[0, :2], "o", color=PATH, markersize=5)
    first.set_title("the hall and the way (first run)")
    first.legend(loc="upper left", fontsize="small")
    for axes, (name, world) in zip(panels, trial.maps.items(), strict=True):
        draw_map(axes, world)
        draw_walls(axes, hall.walls)
        axes.set_title(TITLES[name])
    for axes in figure.axes:
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    return figure


def course_figure(trials: Sequence[SonarTrial]) -> Figure:
    """Return errors of the place against time, and of place and rotation at the end."""
    figure = Figure(figsize=(12.0, 4.0), layout="constrained")
    course, places, rotations = figure.subplots(1, 3, width_ratios=(3.0, 1.0, 1.0))
    for name, colour in WAYS.items():
        ways: list[Floats] = [getattr(trial.ways, name) for trial in trials]
        off = np.array([distances(t.drive, way) for t, way in zip(trials, ways, strict=True)])
        seconds = TICK * np.arange(off.shape[1])
        course.plot(seconds, off.T, color=colour, alpha=0.2, linewidth=0.7)
        course.plot(seconds, off.mean(axis=0), color=colour, linewidth=2.0, label=name)
        errors = [pose_errors(t.drive, way) for t, way in zip(trials, ways, strict=True)]
        draw_bar(places, name, [one["pose_error_m"] for one in errors], colour)
        turned = [np.rad2deg(one["rotation_error_rad"]) for one in errors]
        draw_bar(rotations, name, turned, colour)
    course.set(xlabel="time [s]", ylabel="error of the place [m]", ylim=(0.0, None))
    course.set_title(f"{len(trials)} runs, and their mean")
    course.legend(loc="upper left")
    course.grid(alpha=0.3)
    places.set_title("place at the end [m]")
    rotations.set_title("rotation [degrees]")
    return figure


def noise_figure(noises: Sequence[Mapping[str, tuple[int, int]]]) -> Figure:
    """Return the ratio of noise cells to obstacle cells by model: every run and the mean."""
    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.subplots()
    for name in noises[0]:
        ratios = [100.0 * run[name][0] / run[name][1] for run in noises]
        draw_bar(axes, name.replace("_", "\n"), ratios, SHADES[name])
    axes.set(ylabel="noise cells / obstacle cells [%]")
    axes.set_title(f"{len(noises)} runs: mean, spread and every run")
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(axis="y", alpha=0.3)
    return figure


def draw_bar(axes: Axes, label: str, values: Sequence[float], colour: str) -> None:
    """Draw the mean of values with their spread, and each as a dot."""
    axes.bar(label, np.mean(values), yerr=np.std(values), color=colour, alpha=0.6, capsize=4)
    axes.plot([label] * len(values), values, ".", color="black", markersize=3, alpha=0.5)


def _frame(walls: Floats) -> tuple[Floats, Floats]:
    """Return the lower left and the upper right corner about walls, with a margin."""
    ends = walls.reshape(-1, 2)
    return ends.min(axis=0) - 0.5, ends.max(axis=0) + 0.5


def draw_map(axes: Axes, world: OccupancyMap) -> None:
    """Draw a map: white free, black occupied, unknown left in a light tint."""
    cells = np.ma.masked_less(world.cells, 0)
    axes.set_facecolor("#e8eef2")
    axes.imshow(
        cells, cmap="Greys", vmin=0, vmax=100, origin="lower", extent=extent_of(world.geometry)
    )
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")


def draw_walls(axes: Axes, walls: Floats) -> None:
    """Draw the true walls as thin red lines."""
    for x1, y1, x2, y2 in walls:
        axes.plot([x1, x2], [y1, y2], color="#e74c3c", linewidth=0.9, zorder=3)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
