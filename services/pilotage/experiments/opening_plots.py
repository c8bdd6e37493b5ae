"""Figures 5-8 to 5-10 of Li 2008 redrawn: the opening by model, and how wide it is found."""

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from pilotage.core.grid import OccupancyMap
from pilotage.experiments.sonar_drive import RIM
from pilotage.experiments.sonar_halls import MIDDLE, OPENING, UPPER, Hall
from pilotage.experiments.sonar_plots import SHADES, draw_bar, draw_map, draw_walls
from pilotage.mapper.sonar_arcs import ArcCrossings

NAMES = {
    "centre_line": "centre line (figure 5-8)",
    "bayes": "Bayesian grid",
    "atm": "ATM (figure 5-9)",
    "improved_atm": "improved ATM (figure 5-10)",
}


def opening_figure(
    hall: Hall, maps: Mapping[str, OccupancyMap], crossings: Mapping[str, ArcCrossings]
) -> Figure:
    """Return each map whole, and below it the opening from near with the crossings used."""
    figure = Figure(figsize=(16.0, 7.2), layout="constrained")
    panels = figure.subplots(2, len(maps), height_ratios=(1.0, 0.8))
    for column, (name, world) in enumerate(maps.items()):
        for row in range(2):
            axes = panels[row, column]
            draw_map(axes, world)
            draw_walls(axes, hall.walls)
        if name in crossings:
            used = crossings[name].points[crossings[name].is_used]
            axes.plot(*used.T, ".", color="#1f77b4", markersize=3, label="crossings used")
            axes.legend(loc="lower left", fontsize="small")
        panels[0, column].set(xlim=(-0.3, 5.3), ylim=(-0.4, 4.1), title=NAMES[name])
        axes.set(xlim=(MIDDLE - 0.8, MIDDLE + 0.8), ylim=(UPPER - 0.5, UPPER + 0.5))
    return figure


def width_figure(widths: Sequence[Mapping[str, float]]) -> Figure:
    """Return the widths found by model: every run, mean and spread, beside the true one."""
    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.subplots()
    for name in widths[0]:
        draw_bar(axes, name.replace("_", "\n"), [one[name] for one in widths], SHADES[name])
    axes.axhline(OPENING, color="#e74c3c", linewidth=1.0, label="true width")
    axes.axhline(2.0 * RIM, color="black", linestyle="--", linewidth=0.8, label="robot")
    axes.set(ylabel="opening found [m]", title=f"{len(widths)} runs")
    axes.legend(loc="upper left", fontsize="small")
    return figure
