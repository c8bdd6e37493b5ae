"""The map as it is now: the last whole one, and the patches that came for it."""

from collections import deque

from pilotage_schemas.mapping import GridPatch, OccupancyGrid
from pilotage_schemas.topics import PATCHES_KEPT


class GrowingMap:
    """A map that is patched.

    Patches and maps come by topics of their own, so that a gateway that has just started may hear
    a patch before its map: such patches wait.

    Attributes:
        grid: the map with all its patches laid over it, None before the first.
        revision: how many patches the map has had.
    """

    def __init__(self) -> None:
        self.grid: OccupancyGrid | None = None
        self.revision = 0
        self._waiting: deque[GridPatch] = deque(maxlen=PATCHES_KEPT)

    def take(self, grid: OccupancyGrid) -> None:
        """Begin with a whole map, and the patches that came before it."""
        self.grid, self.revision = grid, 0
        waiting, self._waiting = self._waiting, deque(maxlen=PATCHES_KEPT)
        for patch in waiting:
            self.lay(patch)

    def lay(self, patch: GridPatch) -> bool:
        """Lay a patch over the map; say whether it belongs there."""
        grid = self.grid
        if grid is None or grid.map_id != patch.map_id:
            self._waiting.append(patch)
            return False
        rows, cols = patch.cells.shape
        window = slice(patch.row, patch.row + rows), slice(patch.col, patch.col + cols)
        if grid.cells[window].shape != patch.cells.shape:
            return False
        cells = grid.cells.copy()
        cells[window] = patch.cells
        cells.flags.writeable = False
        self.grid = grid.model_copy(update={"cells": cells, "stamp_ns": patch.stamp_ns})
        self.revision += 1
        return True
