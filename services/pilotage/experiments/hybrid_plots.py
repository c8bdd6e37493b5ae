"""Figure 4 of Zhuang et al. 2005 redrawn: a ride in the corridor, and its matched pairs."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pilotage.experiments.corridor_doors import DOOR_WIDTH, HALF_WIDTH, Corridor
from pilotage.experiments.hybrid_trial import WAY, Place, Ride
from pilotage.experiments.plots import draw_place

ESTIMATE, LOST, TRUE, DOOR, NODE = "#1f77b4", "#c0392b", "#7f8c8d", "#1e8449", "black"
PEOPLE = "#e67e22"
RADIUS = 0.25
"""m of the circle that stands for the robot."""
PAPER_MEANS = {"static": 4.85, "dynamic": 3.2}


def static_figure(place: Place, rides: Sequence[Ride]) -> Figure:
    """Return figures 4a and 4b: the first ride, and the pairs of all."""
    figure, (floor, curve) = _panels()
    draw_corridor(floor, place)
    _draw_ride(floor, rides[0], ESTIMATE, "estimated pose after each cycle")
    floor.set_title("(a) poses by the hybrid method, corridor without people")
    _draw_pairs(curve, rides, ESTIMATE, "every ride, and the mean")
    curve.set_title(_titled("b", rides, PAPER_MEANS["static"]))
    return _finished(figure, floor, curve)


def dynamic_figure(place: Place, rides: Sequence[Ride], without: Sequence[Ride]) -> Figure:
    """Return figures 4c and 4d: people and a collision, with nodes and without them."""
    figure, (floor, curve) = _panels()
    draw_corridor(floor, place)
    _draw_people(floor, rides[0])
    _draw_ride(floor, without[0], LOST, "the same without correction at nodes")
    _draw_ride(floor, rides[0], ESTIMATE, "estimated pose after each cycle")
    _draw_collision(floor, curve, rides[0])
    floor.set_title("(c) poses with people about and a collision")
    _draw_pairs(curve, without, LOST, "without correction at nodes")
    _draw_pairs(curve, rides, ESTIMATE, "every ride, and the mean")
    curve.set_title(_titled("d", rides, PAPER_MEANS["dynamic"]))
    return _finished(figure, floor, curve)


def error_figure(arms: dict[str, Sequence[Ride]]) -> Figure:
    """Return how far off the pose is in every cycle, by arm: every ride, and the median."""
    figure = Figure(figsize=(9.0, 2.2 * len(arms) + 0.6), layout="constrained")
    panels = np.atleast_1d(figure.subplots(len(arms), 1, sharex=True))
    for axes, (name, rides) in zip(panels, arms.items(), strict=True):
        errors = np.array([ride.errors[:, 0] for ride in rides])
        cycles = np.arange(1, errors.shape[1] + 1)
        axes.plot(cycles, errors.T, color=ESTIMATE, alpha=0.25, linewidth=0.7)
        axes.plot(cycles, np.median(errors, axis=0), color=ESTIMATE, linewidth=1.8)
        axes.set(ylabel="error [m]", title=name, yscale="log", ylim=(1e-3, 10.0))
        axes.grid(alpha=0.3)
    panels[-1].set(xlabel="cycle", xticks=cycles[1::2])
    return figure


def draw_corridor(axes: Axes, place: Place) -> None:
    """Draw walls, doors, and the nodes with their numbers and edges."""
    draw_place(axes, place.floor)
    draw_doors(axes, place.corridor)
    nodes = place.topology.places
    axes.plot(*nodes[:, :2].T, color=NODE, linewidth=0.6, linestyle=":", marker="D", markersize=4)
    for number, (x, y, _) in enumerate(nodes, start=1):
        axes.annotate(
            f"{number}", (x, y), (0, -14), textcoords="offset points", ha="center", fontsize=8
        )


def draw_doors(axes: Axes, corridor: Corridor) -> None:
    """Draw each door as a line across its opening."""
    for door in corridor.doors:
        x, y = [door.x - DOOR_WIDTH / 2.0, door.x + DOOR_WIDTH / 2.0], [door.side * HALF_WIDTH] * 2
        axes.plot(x, y, color=DOOR, linewidth=2.5, linestyle=":" if door.is_open else "-")


def draw_robots(axes: Axes, poses: NDArray[np.float64], colour: str, label: str) -> None:
    """Draw poses (n, 3) as circles with a short line to the front."""
    angles = np.linspace(0.0, 2.0 * np.pi, 25)
    circle = RADIUS * np.stack([np.cos(angles), np.sin(angles)])
    for number, (x, y, theta) in enumerate(poses):
        axes.plot(
            x + circle[0], y + circle[1], color=colour, linewidth=1.0, zorder=3,
            label=label if number == 0 else None,
        )  # fmt: skip
        tip = x + RADIUS * np.cos(theta), y + RADIUS * np.sin(theta)
        axes.plot((x, tip[0]), (y, tip[1]), color=colour, linewidth=1.0, zorder=3)


def _panels() -> tuple[Figure, tuple[Axes, Axes]]:
    figure = Figure(figsize=(11.0, 7.6), layout="constrained")
    upper, lower = figure.subplots(2, 1, height_ratios=(1.5, 1.0))
    return figure, (upper, lower)


def _draw_ride(axes: Axes, ride: Ride, colour: str, label: str) -> None:
    truth = np.array([cycle.truth for cycle in ride.cycles])
    axes.plot(*truth[:, :2].T, color=TRUE, linewidth=0.8, marker=".", markersize=3, zorder=2)
    draw_robots(axes, np.array([cycle.estimate for cycle in ride.cycles]), colour, label)


def _draw_people(axes: Axes, ride: Ride) -> None:
    seen = np.concatenate([cycle.people for cycle in ride.cycles[::4]])
    axes.plot(
        *seen[:, :2].T, "o", markersize=4, color=PEOPLE, alpha=0.35, label="people, now and then"
    )


def _draw_collision(floor: Axes, curve: Axes, ride: Ride) -> None:
    if ride.collision is None:
        return
    x, y, _ = ride.cycles[ride.collision].truth
    floor.annotate("collision", (x, y), (x - 0.6, y + 2.3), arrowprops={"arrowstyle": "->"})
    curve.axvline(ride.collision + 1, color="black", linewidth=0.8, linestyle="--", zorder=0)
    curve.annotate("collision", (ride.collision + 1.1, 0.3), fontsize="small")
    if ride.next_node is not None:
        curve.axvline(ride.next_node + 1, color="black", linewidth=0.8, linestyle=":", zorder=0)
        curve.annotate("node 2", (ride.next_node + 1.1, 1.0), fontsize="small")


def _draw_pairs(axes: Axes, rides: Sequence[Ride], colour: str, label: str) -> None:
    """Draw the pairs of every ride faintly, of the first one as points, and their mean."""
    pairs = np.array([ride.pairs for ride in rides])
    cycles = np.arange(1, pairs.shape[1] + 1)
    axes.plot(cycles, pairs.T, color=colour, alpha=0.15, linewidth=0.7)
    axes.plot(cycles, pairs[0], color=colour, linestyle="", marker="o", markersize=4)
    axes.plot(cycles, pairs.mean(axis=0), color=colour, linewidth=1.8, label=label)


def _titled(letter: str, rides: Sequence[Ride], paper: float) -> str:
    mean = np.mean([ride.pairs.mean() for ride in rides])
    return f"({letter}) matched pairs, mean {mean:.2f} (paper {paper:g}); points: the ride above"


def _finished(figure: Figure, floor: Axes, curve: Axes) -> Figure:
    floor.set_ylim(-5.6, 5.6)
    floor.legend(loc="upper right", fontsize="small")
    curve.set(xlabel=f"cycle, every {WAY:g} m", ylabel="pairs of lines", ylim=(-0.3, 12.0))
    curve.set_xticks(range(1, 21))
    curve.legend(loc="upper right", fontsize="small")
    curve.grid(alpha=0.3)
    return figure
