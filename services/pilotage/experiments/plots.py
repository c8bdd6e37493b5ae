"""The papers' figures redrawn: the only module that knows matplotlib's axes.

Grey is the belief, whatever the heading: the darkest value that each cell had at any shown place.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.experiments.ranger_localizer import Place
from pilotage.experiments.symmetric_walk import Shown, Symmetry, Walk, errors
from pilotage.localizer.modes import Mode

ARROW_M = 0.55
PATH, WITHOUT, WITH = "#1f77b4", "#c0392b", "#1e8449"
FAINTEST = 1e-3
"""Share of a marginal's maximum that is still drawn, as the lightest grey."""


def walk_figure(place: Place, walk: Walk, title: str) -> Figure:
    """Return a walk without and with the compass, the most probable poses after every metre."""
    width, height = place.world.geometry.size_m
    is_wide = width > 1.5 * height
    layout = (2, 1) if is_wide else (1, 2)
    size = (10.0, 1.5 + 20.0 * height / width) if is_wide else (13.0, 7.2)
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(*layout)
    figure.suptitle(title)
    for axes, name, shown, colour in zip(
        panels,
        ("without compass", "with compass"),
        (walk.without_compass, walk.with_compass),
        (WITHOUT, WITH),
        strict=True,
    ):
        draw_place(axes, place.world)
        draw_belief(axes, place.states.geometry, [step.marginal for step in shown])
        axes.plot(*walk.path[:, :2].T, color=PATH, linewidth=1.2, label="true path")
        draw_poses(axes, (mode for step in shown for mode in step.modes), colour)
        axes.set_title(f"{name}: {_counted(shown)} after every metre")
        axes.legend(loc="upper right", fontsize="small")
    return figure


def mode_figure(walk: Walk, symmetry: Symmetry) -> Figure:
    """Return the modes' masses, and their errors, against the way."""
    figure = Figure(figsize=(9.0, 6.0), layout="constrained")
    masses, distances = figure.subplots(2, 1, sharex=True)
    for name, shown, (colour, dash), fold in (
        ("without compass", walk.without_compass, (WITHOUT, "-"), symmetry.fold),
        ("with compass", walk.with_compass, (WITH, "--"), 1),
    ):
        way = np.arange(1, len(shown) + 1)
        points = [(m, mode.mass) for m, step in zip(way, shown, strict=True) for mode in step.modes]
        masses.scatter(*np.array(points).T, color=colour, s=14, label=name)
        images = [symmetry.images(step.truth)[:fold] for step in shown]
        off = [errors(step.modes[:fold], at)[0] for step, at in zip(shown, images, strict=True)]
        distances.plot(way, off, color=colour, linestyle=dash, marker=".", label=name)
    masses.axhline(1.0 / symmetry.fold, color="grey", linewidth=0.6, linestyle="--")
    masses.set(ylabel="mass of each mode", ylim=(0.0, 1.05))
    distances.axhline(0.1, color="grey", linewidth=0.6, linestyle="--", label="one cell")
    distances.set(xlabel="way [m]", ylabel="largest error of the modes [m]", ylim=(0.0, None))
    for axes in (masses, distances):
        axes.legend(fontsize="small")
        axes.grid(alpha=0.3)
    return figure


def draw_place(axes: Axes, world: OccupancyMap) -> None:
    """Draw the walls of a map whose axes are the map frame's."""
    walls = np.ma.masked_equal(world.is_wall, 0)
    axes.imshow(
        walls, cmap="binary", vmin=0, vmax=1.4, origin="lower", extent=extent_of(world.geometry)
    )
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")


def draw_belief(
    axes: Axes, geometry: GridGeometry, marginals: Sequence[NDArray[np.float32]]
) -> None:
    """Draw marginals (rows, cols) one over the other, each as dark as its maximum allows."""
    darkest = np.max([marginal / marginal.max() for marginal in marginals], axis=0)
    shade = np.ma.masked_less(1.0 + np.log10(np.maximum(darkest, FAINTEST)) / 3.0, 1e-6)
    axes.imshow(
        shade,
        cmap="Greys",
        vmin=0,
        vmax=1.3,
        origin="lower",
        extent=extent_of(geometry),
        zorder=0.5,
    )


def draw_poses(axes: Axes, modes: Iterable[Mode], colour: str, label: str = "modes") -> None:
    """Draw modes as arrows along their headings."""
    poses = np.array([mode.pose for mode in modes]).reshape(-1, 3)
    draw_arrows(axes, poses, colour, label)


def draw_arrows(axes: Axes, poses: ArrayLike, colour: str, label: str) -> None:
    """Draw poses (n, 3) as arrows of ARROW_M metres."""
    x, y, theta = np.reshape(np.asarray(poses, float), (-1, 3)).T
    along, up = ARROW_M * np.cos(theta), ARROW_M * np.sin(theta)
    axes.quiver(
        *(x, y, along, up),
        angles="xy", scale_units="xy", scale=1.0, color=colour, width=0.005, zorder=3, label=label,
    )  # fmt: skip


def extent_of(geometry: GridGeometry) -> tuple[float, float, float, float]:
    """Return left, right, bottom and top [m] of a grid that is not turned."""
    x, y, _ = geometry.origin
    width, height = geometry.size_m
    return x, x + width, y, y + height


def _counted(shown: list[Shown]) -> str:
    """Return how many modes there were, in words."""
    counts = {len(step.modes) for step in shown}
    low, high = min(counts), max(counts)
    if low == high:
        return f"{low} most probable pose{'s' * (low > 1)}"
    return f"{low} to {high} most probable poses"
