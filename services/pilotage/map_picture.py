"""A map and the robot's way through it as a picture for people."""

import io

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap

UNKNOWN_SHADE, FREE_SHADE, WALL_SHADE = "#dfe3e8", "#ffffff", "#1d2733"
SHADES = ListedColormap([UNKNOWN_SHADE, FREE_SHADE, WALL_SHADE])
WAY, END_SHADE = colormaps["viridis"], "#c0392b"
MARGIN = 0.03
"""Shown around what is known of the map and around the way, as a share of its longer side."""

LONGER_SIDE, DPI = 11.0, 150
"""Inches, and pixels of each: a cell of 0.05 m has a pixel in buildings of up to 80 m."""
MOST_CELLS = 1600
"""Along the longer side; larger maps are shrunk first, which keeps thin walls and saves memory."""

POINTS_DRAWN = 5000
"""Of the way: more are not told apart."""


def map_picture(world: OccupancyMap, poses: NDArray[np.float64], title: str) -> bytes:
    """Return a PNG: the map, the way over poses (n, 3) from dark to light, and a scale bar.

    The map's cells are -1, 0 or 100.
    """
    low, high = _shown(world, poses)
    width, height = high - low
    size = np.maximum(LONGER_SIDE * np.array([width, height]) / max(width, height), 3.0)
    figure = Figure(figsize=(size[0], size[1] + 0.4), layout="constrained")
    axes = figure.subplots()
    _draw_map(axes, world)
    _draw_way(axes, poses)
    _draw_scale(axes, low, high)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xticks=[], yticks=[])
    axes.set_title(title, fontsize="medium")
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=DPI)
    return drawn.getvalue()


def _shown(world: OccupancyMap, poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the lower left and the upper right corner (2, 2) of what is worth showing."""
    low_row, high_row, low_col, high_col = _known_box(world.cells)
    corners = [(row, col) for row in (low_row, high_row) for col in (low_col, high_col)]
    known = world.geometry.centres_of(np.array(corners) - 0.5)
    points = np.concatenate([known, poses[:, :2]])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = MARGIN * float((high - low).max())
    return np.array([low - margin, high + margin])


def _known_box(cells: NDArray[np.int8]) -> tuple[int, int, int, int]:
    """Return first row, last row + 1, first column and last column + 1 that hold known cells."""
    rows, cols = (np.flatnonzero((cells >= 0).any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        return 0, cells.shape[0], 0, cells.shape[1]
    return int(rows[0]), int(rows[-1]) + 1, int(cols[0]), int(cols[-1]) + 1


def _draw_map(axes: Axes, world: OccupancyMap) -> None:
    low_row, high_row, low_col, high_col = _known_box(world.cells)
    step = max(1, -(-max(high_row - low_row, high_col - low_col) // MOST_CELLS))
    cells = shrunk(np.sign(world.cells[low_row:high_row, low_col:high_col]), step)
    side = world.geometry.resolution
    left, bottom = low_col * side, low_row * side
    width, height = cells.shape[1] * step * side, cells.shape[0] * step * side
    x, y, theta = world.geometry.origin
    place = Affine2D().rotate(theta).translate(x, y)
    axes.set_facecolor(UNKNOWN_SHADE)
    axes.imshow(
        cells,
        cmap=SHADES,
        vmin=-1,
        vmax=1,
        origin="lower",
        extent=(left, left + width, bottom, bottom + height),
        interpolation="antialiased" if theta == 0.0 else "nearest",
        interpolation_stage="rgba",
        transform=place + axes.transData,
    )


def shrunk(cells: NDArray[np.int8], step: int) -> NDArray[np.int8]:
    """Return cells of -1, 0 and 1 by blocks of `step` x `step`, the highest of each block.

    Walls count before what is free, and that before what is unknown: thin walls stay.
    """
    rows, cols = (-(-size // step) for size in cells.shape)
    padded = np.full((rows * step, cols * step), -1, np.int8)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    blocks: NDArray[np.int8] = padded.reshape(rows, step, cols, step).max(axis=(1, 3))
    return blocks


def _draw_way(axes: Axes, poses: NDArray[np.float64]) -> None:
    if len(poses) == 0:
        return
    points = poses[:: max(1, len(poses) // POINTS_DRAWN), :2]
    pieces = np.stack([points[:-1], points[1:]], axis=1)
    way = LineCollection(list(pieces), cmap=WAY, linewidth=0.9, alpha=0.9)
    way.set_array(np.linspace(0.0, 1.0, len(pieces)))
    axes.add_collection(way)
    for pose, shape, name, above in ((poses[0], "o", "start", 5), (poses[-1], "s", "end", -12)):
        axes.plot(*pose[:2], shape, color=END_SHADE, markersize=5, zorder=4)
        axes.annotate(
            name,
            pose[:2],
            (5, above),
            textcoords="offset points",
            color=END_SHADE,
            fontsize="small",
        )


def _draw_scale(axes: Axes, low: NDArray[np.float64], high: NDArray[np.float64]) -> None:
    """Draw a bar of a round length of about a fifth of the width in the lower left corner."""
    length = round_length(0.25 * float(high[0] - low[0]))
    inset = 0.025 * float((high - low).max())
    start = low + inset
    axes.plot([start[0], start[0] + length], [start[1]] * 2, color=WALL_SHADE, linewidth=3)
    label = f"{length:g} m"
    axes.annotate(label, (start[0], start[1]), (0, 4), textcoords="offset points", fontsize="small")


def round_length(longest: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not longer."""
    unit = 10.0 ** np.floor(np.log10(longest))
    return float(max(step * unit for step in (1.0, 2.0, 5.0) if step * unit <= longest * 1.0001))
