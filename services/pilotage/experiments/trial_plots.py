"""Where trials began and how the robot went, on the map."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from pilotage.core import se2
from pilotage.core.grid import OccupancyMap
from pilotage.experiments.plots import draw_arrows, draw_place
from pilotage.experiments.trial_run import TrialRun

MARGIN = 6
"""Cells that are shown round the free ones."""

COLOURS = {"correct": "#1e8449", "wrong": "#c0392b", "not localized": "#b9770e"}


def track_figure(world: OccupancyMap, runs: Sequence[TrialRun], title: str) -> Figure:
    """Return the map with the start and the true track of each run, coloured by its outcome."""
    rows, cols = np.nonzero(world.is_free)
    left, right = np.array([cols.min() - MARGIN, cols.max() + MARGIN]) * world.geometry.resolution
    low, high = np.array([rows.min() - MARGIN, rows.max() + MARGIN]) * world.geometry.resolution
    size = 10.0, 1.0 + 9.0 * (high - low) / (right - left)
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots()
    # The grid is drawn along its own axes, wherever the map frame lies.
    geometry = replace(world.geometry, origin=(0.0, 0.0, 0.0))
    draw_place(axes, OccupancyMap(geometry, world.cells))
    for run in runs:
        track = se2.compose(se2.inverse(world.geometry.origin), run.track)
        colour = COLOURS[_outcome(run)]
        axes.plot(track[:, 0], track[:, 1], color=colour, linewidth=1.0)
        draw_arrows(axes, track[:1], colour, "")
    counts = {name: sum(_outcome(run) == name for run in runs) for name in COLOURS}
    said = ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    axes.set(xlim=(left, right), ylim=(low, high))
    axes.set_title(f"{title}: {said}")
    return figure


def _outcome(run: TrialRun) -> str:
    if not run.localized:
        return "not localized"
    return "correct" if run.correct else "wrong"
