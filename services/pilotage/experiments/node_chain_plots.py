"""Plots of unknown starts: nodes needed, and one start in its corridor."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pilotage.experiments.corridor_doors import Spacing
from pilotage.experiments.hybrid_plots import LOST, NODE, PEOPLE, draw_doors, draw_robots
from pilotage.experiments.node_chain_trial import MOST_NODES, ChainPlace, Start
from pilotage.experiments.plots import PATH, draw_place

COLOURS = {"right": PATH, "wrong": LOST, "unknown": PEOPLE}


def nodes_figure(starts: Mapping[Spacing, list[Start]]) -> Figure:
    """Return how many nodes each corridor took, and how the candidates fell."""
    figure = Figure(figsize=(11.0, 2.6 * len(starts) + 0.6), layout="constrained")
    rows = figure.subplots(len(starts), 2, squeeze=False)
    for (name, each), (counts, course) in zip(starts.items(), rows, strict=True):
        _draw_counts(counts, each)
        _draw_course(course, each)
        counts.set_title(f"{name}: {len(each)} starts")
    for axes in rows[-1]:
        axes.set_xlabel("nodes passed")
    return figure


def start_figure(place: ChainPlace, start: Start, title: str) -> Figure:
    """Return one start: the robot at each node, and where the likeliest candidate has it."""
    figure = Figure(figsize=(14.0, 4.4), layout="constrained")
    axes = figure.subplots()
    draw_place(axes, place.floor)
    draw_doors(axes, place.corridor)
    nodes = place.topology.places
    axes.plot(*nodes[:, :2].T, color=NODE, linewidth=0.6, linestyle=":", marker="D", markersize=3)
    truth = np.array([step.truth for step in start.steps]).reshape(-1, 3)
    draw_robots(axes, truth, PATH, "robot at each node it saw")
    believed = np.array([step.pose for step in start.steps]).reshape(-1, 3)
    draw_robots(axes, believed, LOST, "likeliest candidate then")
    for number, step in enumerate(start.steps, start=1):
        for pose, height, colour in ((step.truth, 1.7, PATH), (step.pose, -2.1, LOST)):
            axes.annotate(f"{number}", (pose[0], height), ha="center", color=colour)
    axes.set_xlim(-1.0, place.corridor.length + 1.0)
    axes.legend(loc="upper right", fontsize="small")
    axes.set_title(title)
    return figure


def _draw_counts(axes: Axes, starts: Sequence[Start]) -> None:
    """Draw how many starts ended after each number of nodes, by what they ended with."""
    bins = np.arange(1, MOST_NODES + 1)
    floor = np.zeros(len(bins))
    for verdict, colour in COLOURS.items():
        ended = np.array([len(s.steps) for s in starts if s.verdict == verdict], int)
        count = np.array([(ended == number).sum() for number in bins])
        axes.bar(bins, count, bottom=floor, color=colour, label=f"{verdict}: {len(ended)}")
        floor += count
    axes.set(ylabel="starts", xticks=bins)
    axes.legend(fontsize="small")


def _draw_course(axes: Axes, starts: Sequence[Start]) -> None:
    """Draw the share of the likeliest place after each node, every start."""
    for start in starts:
        shares = [step.share for step in start.steps]
        axes.plot(
            np.arange(1, len(shares) + 1), shares, color=COLOURS[start.verdict], alpha=0.25,
            linewidth=0.9, marker=".",
        )  # fmt: skip
    axes.axhline(0.95, color="grey", linewidth=0.6, linestyle="--")
    axes.set(ylabel="share of the likeliest", ylim=(0.0, 1.05), xlim=(0.5, MOST_NODES + 0.5))
    axes.grid(alpha=0.3)
