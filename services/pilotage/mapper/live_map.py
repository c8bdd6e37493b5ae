"""What has to be said of a map in the making, so that whoever listens has it too.

The whole map when it has grown or was drawn anew, else the cells that changed. A late joiner gets
the last whole map and the patches since; these are kept only up to a number, and before it is
reached the whole map is said again. A map that grows by some cells with every scan would always
have to be said whole: so it is said with unknown cells around it, to whole blocks.
"""

import numpy as np

from pilotage.core.grid import UNKNOWN, GridGeometry, OccupancyMap
from pilotage.mapper.grid_patches import CellPatch, patches_between

BLOCK = 128
"""A map in the making begins and ends at multiples of so many cells of its frame."""


class LiveMap:
    """The map as it was last said; `most_patches` are said after a whole map, not more.

    Attributes:
        said: the map, in whole blocks; None before the first.
    """

    def __init__(self, most_patches: int) -> None:
        self.said: OccupancyMap | None = None
        self._most = most_patches
        self._patches = 0

    def news(self, world: OccupancyMap) -> tuple[CellPatch, ...] | None:
        """Return the patches that make what was said `world`; None: `said` must be said whole."""
        before, self.said = self.said, in_blocks(world)
        patches = None if before is None else patches_between(before, self.said)
        if patches is None or self._patches + len(patches) > self._most:
            self._patches = 0
            return None
        self._patches += len(patches)
        return patches

    def forget(self) -> None:
        """Let the next map be said whole."""
        self.said = None


def in_blocks(world: OccupancyMap) -> OccupancyMap:
    """Return a map with unknown cells around it, up to whole blocks.

    Blocks are counted from the frame's origin along the map's axes.
    """
    geometry = world.geometry
    corner = geometry.grid_from_map(np.zeros((1, 2)))[0] / geometry.resolution
    # The frame's origin lies at `corner` of the map; rounded, for cells lie on a lattice.
    col, row = (-int(value) for value in np.rint(corner))
    left, low = col % BLOCK, row % BLOCK
    right, high = -(col + geometry.cols) % BLOCK, -(row + geometry.rows) % BLOCK
    cells = np.pad(world.cells, ((low, high), (left, right)), constant_values=UNKNOWN)
    moved = geometry.centres_of(np.array([[-low - 0.5, -left - 0.5]]))[0]
    # Rounded, so that the same corner is the same number whatever it was computed from.
    x, y = (round(float(value), 9) for value in moved)
    rows, cols = cells.shape
    origin = (x, y, geometry.origin[2])
    return OccupancyMap(GridGeometry(rows, cols, geometry.resolution, origin), cells)
