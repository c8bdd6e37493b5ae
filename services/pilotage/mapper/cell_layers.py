"""Cells of a sonar grid: a part of the world that grows where something is seen."""

import math
from collections.abc import Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import GridGeometry

CHUNK = 64
"""The part grows by whole chunks, so that it seldom has to."""
MOST_CELLS = 64_000_000
"""400 m x 400 m at 0.05 m: what lies farther off is a mistake, or for another map."""

LAYERS = ("log_odds", "recent", "votes", "counts")

Window = tuple[slice, slice]
Box = tuple[float, float, float, float]
"""Lowest and highest x, lowest and highest y, m in the map."""
Cell = TypeVar("Cell", bound=np.generic)


class CellLayers:
    """What is known of cells of `resolution` m: arrays (rows, cols), new cells zero.

    `log_odds` holds what closed slices of time said, `recent` the open one; `votes` are the last
    slices as bits, `counts` their number. Cell borders lie on multiples of the resolution in the
    map, whenever and however the part grows.
    """

    def __init__(self, resolution: float, chunk: int = CHUNK) -> None:
        self.resolution = resolution
        self._chunk = chunk
        self.first = (0, 0)
        """Row and col of cell (0, 0), counted from the origin of the map."""
        self.log_odds = np.zeros((0, 0), np.float32)
        self.recent = np.zeros((0, 0), np.float32)
        self.votes = np.zeros((0, 0), np.uint8)
        self.counts = np.zeros((0, 0), np.uint8)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and cols."""
        rows, cols = self.log_odds.shape
        return rows, cols

    @property
    def corner(self) -> tuple[float, float]:
        """Return x, y in m of the outer corner of cell (0, 0) in the map."""
        row, col = self.first
        return col * self.resolution, row * self.resolution

    @property
    def geometry(self) -> GridGeometry:
        """Where the cells lie."""
        return GridGeometry(*self.shape, self.resolution, (*self.corner, 0.0))

    @property
    def box(self) -> Box | None:
        """The box about all cells; None while there are none."""
        if self.log_odds.size == 0:
            return None
        # Half a cell inside: the upper border belongs to the next cell.
        (x, y), (rows, cols), half = self.corner, self.shape, 0.5 * self.resolution
        far_x, far_y = x + cols * self.resolution, y + rows * self.resolution
        return x + half, far_x - half, y + half, far_y - half

    def cover(self, box: Box) -> bool:
        """Grow until a box lies inside; return False if it is too far away."""
        low_x, high_x, low_y, high_y = box
        low = self._chunk_of(low_y), self._chunk_of(low_x)
        high = self._chunk_of(high_y) + self._chunk, self._chunk_of(high_x) + self._chunk
        if self.log_odds.size:
            ends = self.first[0] + self.shape[0], self.first[1] + self.shape[1]
            low = min(low[0], self.first[0]), min(low[1], self.first[1])
            high = max(high[0], ends[0]), max(high[1], ends[1])
        size = high[0] - low[0], high[1] - low[1]
        if size[0] * size[1] > MOST_CELLS:
            return False
        if size != self.shape:
            self._grow(low, size)
        return True

    def window(self, box: Box) -> Window:
        """Return the slices of rows and cols that hold a box which is covered."""
        low_x, high_x, low_y, high_y = (math.floor(metres / self.resolution) for metres in box)
        row, col = self.first
        rows = slice(max(0, low_y - row), high_y - row + 1)
        return rows, slice(max(0, low_x - col), high_x - col + 1)

    def remember(self) -> dict[str, NDArray[np.generic]]:
        """Return all that `resume` needs."""
        layers: dict[str, NDArray[np.generic]] = {
            name: getattr(self, name).copy() for name in LAYERS
        }
        return {**layers, "first": np.array(self.first)}

    def resume(self, memory: Mapping[str, NDArray[np.generic]]) -> None:
        """Go on from what was remembered; ValueError if it does not fit."""
        if not {*LAYERS, "first"} <= memory.keys():
            raise ValueError("the memory lacks layers of the sonar grid")
        shape = memory["log_odds"].shape
        for name in LAYERS:
            layer, known = memory[name], getattr(self, name)
            if layer.dtype != known.dtype or layer.shape != shape or layer.ndim != 2:
                raise ValueError(f"{name} is no layer of this grid: {layer.dtype} {layer.shape}")
        for name in LAYERS:
            setattr(self, name, memory[name].copy())
        row, col = memory["first"].tolist()
        self.first = int(row), int(col)

    def _chunk_of(self, metres: float) -> int:
        """Return the first cell of the chunk that a coordinate lies in."""
        return math.floor(metres / (self.resolution * self._chunk)) * self._chunk

    def _grow(self, first: tuple[int, int], size: tuple[int, int]) -> None:
        """Move all layers into larger ones."""
        at = self.first[0] - first[0], self.first[1] - first[1]
        self.log_odds = _moved(self.log_odds, at, size)
        self.recent = _moved(self.recent, at, size)
        self.votes = _moved(self.votes, at, size)
        self.counts = _moved(self.counts, at, size)
        self.first = first


def _moved(layer: NDArray[Cell], at: tuple[int, int], size: tuple[int, int]) -> NDArray[Cell]:
    """Return a layer of zeros with an old one at (row, col)."""
    larger = np.zeros(size, layer.dtype)
    if layer.size:
        larger[at[0] : at[0] + layer.shape[0], at[1] : at[1] + layer.shape[1]] = layer
    return larger


def both(first: Box | None, second: Box) -> Box:
    """Return the box about two boxes."""
    if first is None:
        return second
    return (
        min(first[0], second[0]),
        max(first[1], second[1]),
        min(first[2], second[2]),
        max(first[3], second[3]),
    )
