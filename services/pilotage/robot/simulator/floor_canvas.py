"""A sheet on which floors are drawn in metres, cell by cell; pure.

World x runs to the right, y up, (0, 0) is the lower left inner corner of the building.
Everything is unknown until a floor is laid.
"""

from dataclasses import dataclass

import numpy as np

from pilotage.core.grid import FREE, OCCUPIED, UNKNOWN, GridGeometry, OccupancyMap

Box = tuple[float, float, float, float]
"""x0, y0, x1, y1 in metres, x0 < x1, y0 < y1."""


class FloorCanvas:
    """Cells of `resolution` m around a building of `width` x `height` m, `margin` m beyond it."""

    def __init__(self, width: float, height: float, resolution: float, margin: float) -> None:
        rows = round((height + 2.0 * margin) / resolution)
        cols = round((width + 2.0 * margin) / resolution)
        self.geometry = GridGeometry(rows, cols, resolution, (-margin, -margin, 0.0))
        self._margin = margin
        self._cells = np.full((rows, cols), UNKNOWN, np.int8)

    def floor(self, box: Box) -> None:
        """Lay free floor."""
        self._fill(box, FREE)

    def solid(self, box: Box) -> None:
        """Fill a box with wall or furniture, at least one cell thick."""
        self._fill(box, OCCUPIED)

    def hidden(self, box: Box) -> None:
        """Make a box unknown: what lies behind closed walls."""
        self._fill(box, UNKNOWN)

    def wall(self, start: tuple[float, float], end: tuple[float, float], thickness: float) -> None:
        """Build a wall along x or y, centred on the line from `start` to `end`."""
        half = thickness / 2.0
        (x0, y0), (x1, y1) = start, end
        self.solid((min(x0, x1) - half, min(y0, y1) - half, max(x0, x1) + half, max(y0, y1) + half))

    def round(self, x: float, y: float, radius: float) -> None:
        """Put down something round: a column, a plant, a stool."""
        rows, cols = np.indices(self._cells.shape, sparse=True)
        step = self.geometry.resolution
        dx = (cols + 0.5) * step - self._margin - x
        dy = (rows + 0.5) * step - self._margin - y
        self._cells[np.asarray(dx**2 + dy**2 <= radius**2)] = OCCUPIED

    def to_map(self) -> OccupancyMap:
        """Return what has been drawn so far."""
        return OccupancyMap(self.geometry, self._cells.copy())

    def _fill(self, box: Box, value: int) -> None:
        step = self.geometry.resolution
        col0, row0, col1, row1 = (round((edge + self._margin) / step) for edge in box)
        self._cells[row0 : max(row1, row0 + 1), col0 : max(col1, col0 + 1)] = value


@dataclass(frozen=True)
class Room:
    """A rectangle with a door side, and its own coordinates for what stands in it.

    `along` runs along the door's wall (from its left end, seen from inside with the back to the
    door), `deep` away from it, so the same furniture fits a room on either side of a corridor;
    `mirrored` swaps left and right.
    """

    box: Box
    door_side: str
    mirrored: bool = False

    @property
    def along(self) -> float:
        """Length of the wall with the door, m."""
        x0, y0, x1, y1 = self.box
        return x1 - x0 if self.door_side in "SN" else y1 - y0

    @property
    def deep(self) -> float:
        """Distance from the door's wall to the opposite one, m."""
        x0, y0, x1, y1 = self.box
        return y1 - y0 if self.door_side in "SN" else x1 - x0

    def point(self, along: float, deep: float) -> tuple[float, float]:
        """Return the world point of a point of the room."""
        u = self.along - along if self.mirrored else along
        x0, y0, x1, y1 = self.box
        match self.door_side:
            case "S":
                return x0 + u, y0 + deep
            case "N":
                return x1 - u, y1 - deep
            case "W":
                return x0 + deep, y1 - u
            case _:
                return x1 - deep, y0 + u

    def place(self, along0: float, deep0: float, along1: float, deep1: float) -> Box:
        """Return the world box of a box of the room."""
        (xa, ya), (xb, yb) = self.point(along0, deep0), self.point(along1, deep1)
        return min(xa, xb), min(ya, yb), max(xa, xb), max(ya, yb)
