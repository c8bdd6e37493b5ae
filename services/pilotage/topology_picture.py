"""A topological map over its occupancy map as a picture for people."""

import io

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.map_picture import UNKNOWN_SHADE, WALL_SHADE
from pilotage.topology.features import KINDS, Features
from pilotage.topology.from_map.building import Building
from pilotage.topology.topological_map import TopologicalMap

ROOM_TINTS = ("#dcebf7", "#e6f4dd", "#fbeed5", "#efe2f5", "#d9f0ec", "#f9e0e0", "#ebe9d2")
DOOR, PASSAGE, NODE, CORNER = "#c0392b", "#1f6fb4", "#196659", "#8a5a12"
LONGER_SIDE, DPI = 14.0, 150
NAMED = 80
"""Names of so many nodes can be read at most."""


def topology_picture(world: OccupancyMap, building: Building, title: str) -> bytes:
    """Return a PNG: rooms tinted, walls, doors and passages as strokes, ways, nodes, corners."""
    low, high = _shown(building)
    width, height = high - low
    size = np.maximum(LONGER_SIDE * np.array([width, height]) / max(width, height), 4.0)
    figure = Figure(figsize=(size[0], size[1] + 0.6), layout="constrained")
    axes = figure.subplots()
    _draw_rooms(axes, world, building)
    _draw_openings(axes, building)
    _draw_graph(axes, building.topology)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_title(title, fontsize="medium")
    figure.legend(handles=_legend(), loc="outside lower center", ncols=4, fontsize="small")
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=DPI)
    return drawn.getvalue()


def _shown(building: Building) -> NDArray[np.float64]:
    """Return the lower left and the upper right corner (2, 2) of the rooms, and some margin."""
    cells = np.argwhere(building.openings.labels > 0)
    points = building.space.geometry.centres_of(cells)
    return np.array([points.min(axis=0) - 1.0, points.max(axis=0) + 1.0])


def _draw_rooms(axes: Axes, world: OccupancyMap, building: Building) -> None:
    labels = building.openings.labels
    shades = np.where(labels > 0, 2 + labels % len(ROOM_TINTS), 0)
    shades[np.pad(world.is_wall, 1)] = 1
    geometry = building.space.geometry
    x, y, theta = geometry.origin
    place = Affine2D().rotate(theta).translate(x, y)
    axes.set_facecolor(UNKNOWN_SHADE)
    axes.imshow(
        shades,
        cmap=ListedColormap([UNKNOWN_SHADE, WALL_SHADE, *ROOM_TINTS]),
        vmin=0,
        vmax=1 + len(ROOM_TINTS),
        origin="lower",
        extent=(0.0, geometry.size_m[0], 0.0, geometry.size_m[1]),
        interpolation="nearest",
        transform=place + axes.transData,
    )


def _draw_openings(axes: Axes, building: Building) -> None:
    openings = building.openings
    for is_door, colour in ((True, DOOR), (False, PASSAGE)):
        ends = openings.chords.ends[openings.is_door == is_door]
        axes.add_collection(LineCollection(list(ends), colors=colour, linewidths=3.0, zorder=3))


def _draw_graph(axes: Axes, topology: TopologicalMap) -> None:
    ways = [edge.way for edge in topology.edges]
    axes.add_collection(LineCollection(ways, colors=NODE, linewidths=1.1, alpha=0.8, zorder=2))
    corners = Features.joined([node.features for node in topology.nodes])
    corners = corners.chosen(corners.kinds == KINDS.index("corner"))
    axes.plot(*corners.poses[:, :2].T, "+", color=CORNER, markersize=5, zorder=2)
    for node in topology.nodes:
        colour = {"door": DOOR, "passage": PASSAGE}.get(node.kind, NODE)
        axes.plot(*node.pose[:2], "o", color=colour, markersize=4, zorder=4)
        if len(topology.nodes) <= NAMED:
            axes.annotate(
                node.name,
                (float(node.pose[0]), float(node.pose[1])),
                (3, 3),
                textcoords="offset points",
                fontsize=6,
                zorder=5,
            )


def _legend() -> list[Line2D]:
    return [
        Line2D([], [], color=NODE, marker="o", markersize=4, label="node, edge"),
        Line2D([], [], color=DOOR, linewidth=3.0, label="door"),
        Line2D([], [], color=PASSAGE, linewidth=3.0, label="passage"),
        Line2D([], [], color=CORNER, marker="+", linestyle="", label="corner"),
    ]
