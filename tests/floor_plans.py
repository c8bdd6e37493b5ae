"""Floor plans drawn as text, a mark for every 0.3 m, so that a whole flat fits on a page."""

import numpy as np
from numpy.typing import NDArray

from drawing import draw
from pilotage.core.grid import GridGeometry, OccupancyMap

MARK = 0.3
"""m that a mark is wide and high."""
WALL, DOOR, LEAST_ROOM, JAMB = 2, 9, 24, 1
"""Of random buildings, in cells of 0.1 m: how thick walls are, how wide doors, how wide rooms at
least, and how far a door keeps from the next wall."""


def floor_plan(
    picture: str, cell: float = 0.1, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> OccupancyMap:
    """Return the map with cells of so many m; # wall, . free, ? unknown, last line at y = 0."""
    drawn = draw(picture, MARK, origin)
    count = round(MARK / cell)
    return _on_grid(np.kron(drawn.cells, np.ones((count, count), np.int8)), cell, origin)


def turned(world: OccupancyMap) -> OccupancyMap:
    """Return the map turned by 90 degrees: a point (x, y) comes to (height - y, x)."""
    return _on_grid(np.rot90(world.cells, -1), world.geometry.resolution)


def mirrored(world: OccupancyMap) -> OccupancyMap:
    """Return the map with left and right exchanged: a point (x, y) comes to (width - x, y)."""
    return _on_grid(world.cells[:, ::-1], world.geometry.resolution)


def _on_grid(
    cells: NDArray[np.int8], cell: float, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> OccupancyMap:
    rows, cols = cells.shape
    return OccupancyMap(GridGeometry(rows, cols, cell, origin), np.ascontiguousarray(cells))


def random_building(rng: np.random.Generator) -> tuple[OccupancyMap, NDArray[np.float64]]:
    """Return a house of 10 m x 8 m of rooms side by side, and the middles (n, 2) of its doors."""
    cells = np.full((80, 100), 100, np.int8)
    inside = cells[WALL:-WALL, WALL:-WALL]
    inside[:] = 0
    walls = _divide(inside, rng, (0, 0))
    doors = [_open(inside, wall, rng) for wall in walls]
    middles = [middle for middle in doors if middle is not None]
    return _on_grid(cells, 0.1), (np.array(middles).reshape(-1, 2) + WALL) * 0.1


Wall = tuple[bool, int, int, int]
"""Whether it stands upright; its first row (its first column, if upright), first and last place."""


def _divide(room: NDArray[np.int8], rng: np.random.Generator, at: tuple[int, int]) -> list[Wall]:
    """Divide a room in two across its longer side, and those again; return the walls."""
    if room.shape[1] > room.shape[0]:
        crosswise = _divide(room.T, rng, at[::-1])
        return [(not upright, row, first, last) for upright, row, first, last in crosswise]
    rows, cols = room.shape
    if rows < 2 * LEAST_ROOM + WALL or (rows * cols < 4000 and rng.random() < 0.2):
        return []
    cut = int(rng.integers(LEAST_ROOM, rows - LEAST_ROOM - WALL + 1))
    room[cut : cut + WALL] = 100
    beyond = cut + WALL
    below, above = room[:cut], room[beyond:]
    wall = (False, at[0] + cut, at[1], at[1] + cols)
    return [wall, *_divide(below, rng, at), *_divide(above, rng, (at[0] + beyond, at[1]))]


def _open(
    inside: NDArray[np.int8], wall: Wall, rng: np.random.Generator
) -> tuple[float, float] | None:
    """Break a door into a wall where no other wall stands near; return its middle in cells."""
    upright, row, first, last = wall
    grid = inside.T if upright else inside
    beside = (grid[row - 1] > 0) | (grid[row + WALL] > 0)
    wide = DOOR + 2 * JAMB
    starts = [i for i in range(first, last - wide + 1) if not beside[i : i + wide].any()]
    if not starts:
        return None
    start = int(rng.choice(starts)) + JAMB
    grid[row : row + WALL, start : start + DOOR] = 0
    middle = row + WALL / 2.0, start + DOOR / 2.0
    return middle if upright else middle[::-1]


TWO_ROOMS = """
    #################################
    #...............#...............#
    #...............#...............#
    #...............#...............#
    #...............#...............#
    #...............#...............#
    #...............#...............#
    #...............................#
    #...............................#
    #...............................#
    #...............#...............#
    #...............#...............#
    #...............#...............#
    #...............#...............#
    #################################
"""
"""Two rooms of 4.5 m x 3.9 m with a door of 0.9 m between them, its middle at (4.95, 1.95)."""

FLAT = """
    #############################################
    #.............#.............#...............#
    #.............#.............#...............#
    #.............#.............#...............#
    #.............#.............#...............#
    #.............#.............#...............#
    #.............#.............#...............#
    #.............#.............#...............#
    #.............#.............#...............#
    #.............#.............#...............#
    ######...###########...############...#######
    #...........................................#
    #...........................................#
    #...........................................#
    #...........................................#
    #...........................................#
    #############################################
"""
"""Three rooms on a corridor of 12.9 m x 1.5 m, doors at x = 2.25, 6.45, 10.95; y = 1.95."""
