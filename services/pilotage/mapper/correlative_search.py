"""Correlative search (Olson 2009): the best pose of a scan on a map within a whole window.

Every pose of the window is covered, so a bad first guess costs time and not the answer; branch and
bound (Hess et al. 2016) leaves out what cannot win.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.correlative_kernels import Task, branch_and_bound, pooled
from pilotage.mapper.surfel_kernels import SurfelMap

FULL = 255
"""Value of a cell that a surfel lies in."""


@dataclass(frozen=True)
class SearchWindow:
    """How far around the guess to look: m and rad, and what a way off costs.

    `sigma` and `turn_sigma` are the standard deviations of the guess; `weight` the number of
    points whose agreement one squared standard deviation outweighs.
    """

    radius: float
    turn: float
    sigma: float = np.inf
    turn_sigma: float = np.inf
    weight: float = 1.0


@dataclass(frozen=True, eq=False)
class SearchRaster:
    """How well a point fits each cell, 0 to 255, in `depth` layers of doubling reach."""

    corner: NDArray[np.float64]
    cell: float
    layers: NDArray[np.uint8]

    @cached_property
    def pad(self) -> int:
        """Cells by which the layers begin before `corner`."""
        return 1 << (len(self.layers) - 1)


def search_raster(surfels: SurfelMap, blur: float, depth: int) -> SearchRaster:
    """Return the raster of a map: a Gaussian of `blur` m around every surfel."""
    near = np.exp(-0.5 * (surfels.distance / np.float32(blur)) ** 2)
    values = np.round(FULL * near).astype(np.uint8)
    pad = 1 << (depth - 1)
    layers = np.empty((depth, values.shape[0] + pad, values.shape[1] + pad), np.uint8)
    layers[0] = np.pad(values, ((pad, 0), (pad, 0)))
    for level in range(1, depth):
        layers[level] = pooled(layers[level - 1], 1 << (level - 1))
    return SearchRaster(surfels.corner, surfels.cell, layers)


def turn_step(points: NDArray[np.float64], cell: float) -> float:
    """Return the turn in rad that moves the far points (n, 2) of a scan by one cell."""
    far = float(np.percentile(np.hypot(points[:, 0], points[:, 1]), 80.0))
    return cell / max(far, 1.0)


def search(
    raster: SearchRaster,
    points: NDArray[np.float64],
    guess: NDArray[np.float64],
    window: SearchWindow,
    least: float = 0.0,
) -> tuple[NDArray[np.float64], float] | None:
    """Return the best pose (3,) of points (n, 2) around a guess (3,), and its mean value 0 to 1.

    None if no pose of the window is worth more than `least`.
    """
    step = turn_step(points, raster.cell)
    count = int(np.ceil(window.turn / step))
    turns: NDArray[np.float64] = step * np.arange(-count, count + 1, dtype=np.float64)
    cells = _cells(raster, points, guess, turns)
    scale = FULL * window.weight
    per_turn: NDArray[np.float64] = 0.5 * scale * (turns / window.turn_sigma) ** 2
    per_square = 0.5 * scale * (raster.cell / window.sigma) ** 2
    half = int(np.ceil(window.radius / raster.cell))
    floor = least * FULL * len(points)
    task = Task(raster.layers, cells, half, per_turn, per_square)
    turn, row, col, best = branch_and_bound(task, floor)
    if turn < 0:
        return None
    offset = np.array([col * raster.cell, row * raster.cell, turns[turn]])
    return guess + offset, best / (FULL * len(points))


def _cells(
    raster: SearchRaster,
    points: NDArray[np.float64],
    guess: NDArray[np.float64],
    turns: NDArray[np.float64],
) -> NDArray[np.int32]:
    """Return the cells (turns, n, 2) of the points for each turn of the guess."""
    heading = guess[2] + turns
    cos, sin = np.cos(heading)[:, None], np.sin(heading)[:, None]
    x = guess[0] + cos * points[:, 0] - sin * points[:, 1] - raster.corner[0]
    y = guess[1] + sin * points[:, 0] + cos * points[:, 1] - raster.corner[1]
    cells = np.stack([y, x], axis=-1) / raster.cell
    return np.floor(cells).astype(np.int32) + np.int32(raster.pad)
