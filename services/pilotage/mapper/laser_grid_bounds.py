"""Rectangles on the endless raster of cells whose corner is the origin of the map frame."""

from typing import NamedTuple

BLOCK = 128
"""The map grows by blocks of so many cells in a row."""


class Bounds(NamedTuple):
    """Rows and cols of cells, the first included, the last not."""

    row_from: int
    row_to: int
    col_from: int
    col_to: int

    @property
    def shape(self) -> tuple[int, int]:
        """How many rows and cols there are."""
        return self.row_to - self.row_from, self.col_to - self.col_from

    def union(self, other: "Bounds | None") -> "Bounds":
        """Return the least bounds that hold both."""
        if other is None:
            return self
        return Bounds(
            min(self.row_from, other.row_from),
            max(self.row_to, other.row_to),
            min(self.col_from, other.col_from),
            max(self.col_to, other.col_to),
        )

    def overlap(self, other: "Bounds") -> "Bounds":
        """Return what both share, if they do."""
        return Bounds(
            max(self.row_from, other.row_from),
            min(self.row_to, other.row_to),
            max(self.col_from, other.col_from),
            min(self.col_to, other.col_to),
        )

    def widened(self, cells: int) -> "Bounds":
        """Return the bounds with so many cells more on every side."""
        row_from, row_to, col_from, col_to = self
        return Bounds(row_from - cells, row_to + cells, col_from - cells, col_to + cells)

    def in_blocks(self) -> "Bounds":
        """Return the whole blocks that hold these bounds."""
        return Bounds(
            self.row_from // BLOCK * BLOCK,
            -(-self.row_to // BLOCK) * BLOCK,
            self.col_from // BLOCK * BLOCK,
            -(-self.col_to // BLOCK) * BLOCK,
        )

    def with_reserve(self, before: "Bounds | None") -> "Bounds":
        """Return room for a quarter more on the sides that grew: growing again is rare."""
        if before is None:
            return self
        tall, wide = self.shape[0] // 4, self.shape[1] // 4
        return Bounds(
            self.row_from - tall * (self.row_from < before.row_from),
            self.row_to + tall * (self.row_to > before.row_to),
            self.col_from - wide * (self.col_from < before.col_from),
            self.col_to + wide * (self.col_to > before.col_to),
        )

    def slices_from(self, corner: tuple[int, int]) -> tuple[slice, slice]:
        """Return the bounds as an index of an array whose first cell is `corner` (row, col)."""
        row, col = corner
        return (
            slice(self.row_from - row, self.row_to - row),
            slice(self.col_from - col, self.col_to - col),
        )
