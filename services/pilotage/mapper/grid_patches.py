"""What changed in a map, as small windows to be laid over what others have of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap

TILE = 32
"""Side of the squares [cells] in which changes are gathered."""

MOST_TILES = 8
"""No patch is wider or higher than so many tiles: 64 kB, sent in a millisecond."""


@dataclass(frozen=True)
class GridWindow:
    """A rectangle of cells of a map: the first `row` and `col`, and how many `rows`, `cols`."""

    row: int
    col: int
    rows: int
    cols: int

    @property
    def slices(self) -> tuple[slice, slice]:
        """The window as an index of an array (rows, cols) over the map."""
        return slice(self.row, self.row + self.rows), slice(self.col, self.col + self.cols)


@dataclass(frozen=True, eq=False)
class CellPatch:
    """New int8 `cells` (rows, cols), to be laid at `row`, `col`."""

    row: int
    col: int
    cells: NDArray[np.int8]


def patches_between(old: OccupancyMap, new: OccupancyMap) -> tuple[CellPatch, ...] | None:
    """Return what makes the old map the new one; None if only the whole new map can.

    That is so where the map grew: its cells lie elsewhere then. Patches do not overlap, none has
    a side above `TILE * MOST_TILES`, and changes far from each other have patches of their own.
    """
    if old.geometry != new.geometry:
        return None
    differs = old.cells != new.cells
    patches = (_patch(new, differs, window) for window in _windows(_tiles(differs)))
    return tuple(patches)


def patched(world: OccupancyMap, patches: tuple[CellPatch, ...]) -> OccupancyMap:
    """Return a map with patches laid over it.

    Raises:
        ValueError: a patch does not lie on the map.
    """
    cells = world.cells.copy()
    for patch in patches:
        window = GridWindow(patch.row, patch.col, *patch.cells.shape)
        if min(patch.row, patch.col) < 0 or cells[window.slices].shape != patch.cells.shape:
            raise ValueError(f"patch {window} lies off the map of {cells.shape} cells")
        cells[window.slices] = patch.cells
    return OccupancyMap(world.geometry, cells)


def _tiles(differs: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return for each tile of `TILE` x `TILE` cells whether a cell of it differs."""
    rows = np.arange(0, differs.shape[0], TILE)
    cols = np.arange(0, differs.shape[1], TILE)
    if differs.size == 0:
        return np.zeros((len(rows), len(cols)), bool)
    by_rows = np.logical_or.reduceat(differs, rows, axis=0)
    tiles: NDArray[np.bool_] = np.logical_or.reduceat(by_rows, cols, axis=1)
    return tiles


def _windows(tiles: NDArray[np.bool_]) -> list[GridWindow]:
    """Return rectangles of tiles that cover all that are set, and no other."""
    left = tiles.copy()
    windows = []
    for row, col in np.argwhere(tiles):
        if left[row, col]:
            cols = _run(left[row : row + 1, col : col + MOST_TILES])
            rows = _run(left[row : row + MOST_TILES, col : col + cols].T)
            windows.append(GridWindow(int(row), int(col), rows, cols))
            left[windows[-1].slices] = False
    return windows


def _run(columns: NDArray[np.bool_]) -> int:
    """Return how many columns of (rows, cols) are all set before the first that is not."""
    broken = np.flatnonzero(~columns.all(axis=0))
    return int(broken[0]) if len(broken) else columns.shape[1]


def _patch(new: OccupancyMap, differs: NDArray[np.bool_], tiles: GridWindow) -> CellPatch:
    """Return the patch for a rectangle of tiles, cut to the cells that differ."""
    area = GridWindow(*(TILE * k for k in (tiles.row, tiles.col, tiles.rows, tiles.cols)))
    rows = np.flatnonzero(differs[area.slices].any(axis=1)) + area.row
    cols = np.flatnonzero(differs[area.slices].any(axis=0)) + area.col
    cells = new.cells[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]
    return CellPatch(int(rows[0]), int(cols[0]), cells.copy())
