"""The outlines of walls in a map where they face free space, traced along the cells' sides.

A side between a wall cell and a free cell is walked with free space on the left, from corner to
corner of the grid; (x, y) are in cells. Where two wall cells touch at a corner no beam passes,
so there the outline stays at the same free cell.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

RIGHT, UP, LEFT, DOWN = 1, 2, 4, 8
"""Bits of the sides that begin at a grid corner, by where they lead."""


def sides_to_free_space(
    is_wall: NDArray[np.bool_], is_free: NDArray[np.bool_]
) -> NDArray[np.uint8]:
    """Return which sides begin at each grid corner (rows + 1, cols + 1), as bits."""
    rows, cols = is_wall.shape
    sides = np.zeros((rows + 1, cols + 1), np.uint8)
    sides[1:-1, :-1] |= RIGHT * (is_free[1:] & is_wall[:-1]).astype(np.uint8)
    sides[1:-1, 1:] |= LEFT * (is_wall[1:] & is_free[:-1]).astype(np.uint8)
    sides[:-1, 1:-1] |= UP * (is_free[:, :-1] & is_wall[:, 1:]).astype(np.uint8)
    sides[1:, 1:-1] |= DOWN * (is_wall[:, :-1] & is_free[:, 1:]).astype(np.uint8)
    return sides


@kernel
def trace_contours(
    sides: NDArray[np.uint8],
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Return the corners (n, 2) as x, y of all outlines, and where each begins (k + 1,).

    A closed outline ends at the corner where it began. The sides (rows + 1, cols + 1) are used
    up: zero afterwards.
    """
    most = 0
    for way in range(4):
        most += int((sides >> way & 1).sum())
    corners = np.empty((2 * most, 2), np.int32)
    begins = np.empty(most + 1, np.int64)
    count, outlines = 0, 0
    for row in range(sides.shape[0]):
        for col in range(sides.shape[1]):
            while sides[row, col]:
                begins[outlines] = count
                outlines += 1
                x, y, way = _beginning(sides, col, row)
                count = _walk(sides, (x, y, way), corners, count)
    begins[outlines] = count
    return corners[:count], begins[: outlines + 1]


@kernel
def _ahead(x: int, y: int, way: int) -> tuple[int, int]:
    """Return the corner where a side ends that begins at x, y."""
    if way == 0:
        return x + 1, y
    if way == 1:
        return x, y + 1
    if way == 2:
        return x - 1, y
    return x, y - 1


@kernel
def _next_way(sides: NDArray[np.uint8], x: int, y: int, way: int) -> int:
    """Return where an outline that comes to x, y goes on; -1 if it ends there."""
    # Left first: that is round the same free cell.
    for turn in (1, 0, 3):
        onward = (way + turn) & 3
        if sides[y, x] >> onward & 1:
            return onward
    return -1


@kernel
def _former_way(sides: NDArray[np.uint8], x: int, y: int, way: int) -> int:
    """Return by which way an outline that leaves x, y came there; -1 if it begins there."""
    rows, cols = sides.shape
    for turn in (3, 0, 1):
        former = (way + turn) & 3
        back_x, back_y = _ahead(x, y, former ^ 2)
        inside = 0 <= back_x < cols and 0 <= back_y < rows
        if inside and sides[back_y, back_x] >> former & 1:
            return former
    return -1


@kernel
def _beginning(sides: NDArray[np.uint8], x: int, y: int) -> tuple[int, int, int]:
    """Return the first side of the outline that holds a side beginning at x, y."""
    way = 0
    while not sides[y, x] >> way & 1:
        way += 1
    start_x, start_y, start_way = x, y, way
    while True:
        former = _former_way(sides, x, y, way)
        if former < 0:
            return x, y, way
        x, y = _ahead(x, y, former ^ 2)
        way = former
        if x == start_x and y == start_y and way == start_way:
            return x, y, way


@kernel
def _walk(
    sides: NDArray[np.uint8],
    start: tuple[int, int, int],
    corners: NDArray[np.int32],
    count: int,
) -> int:
    """Write the corners of an outline from its first side on; return how many there are now."""
    x, y, way = start
    corners[count, 0], corners[count, 1] = x, y
    count += 1
    while way >= 0:
        sides[y, x] &= ~(1 << way) & 15
        x, y = _ahead(x, y, way)
        corners[count, 0], corners[count, 1] = x, y
        count += 1
        way = _next_way(sides, x, y, way)
    return count
