"""A path from here to a goal of the map, or the reason why there is none; pure."""

import itertools
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.planner.ground import LEAST_GAP, Ground, Terrain
from pilotage.planner.path_search import shortened, travel_field, way_to

Cell = tuple[int, int]

LEAVING = 0.5
"""m round a robot too near a wall in which it may be as near, on its way away from it."""
LEAVING_COST = 20.0
"""What a metre costs there: away from the wall first."""
STANDS_BESIDE = 0.25
"""m that a robot may seem to be inside of a wall, its pose and the map being what they are."""
ENCLOSED = 1.0
"""m^2 within which a robot is enclosed."""


class NoPathError(ValueError):
    """There is no path; the text says why."""


def find_path(
    ground: Ground, start: ArrayLike, goal: ArrayLike, radius: float
) -> NDArray[np.float64]:
    """Return the corners (n, 2) of the best path for a disc, map frame, start and goal included.

    It keeps clear of walls where it can at little cost and squeezes through where it must. A
    robot that stands too near a wall may leave it.

    Args:
        ground: where bodies fit.
        start: (2,) m, map frame.
        goal: (2,) m, map frame.
        radius: of the body, m.

    Raises:
        NoPathError: the goal is no place for the robot or cannot be reached; the text says which.
    """
    terrain = ground.terrain(radius)
    last = _goal_cell(ground, goal, radius)
    first = _start_cell(ground, start)
    terrain = _with_way_out(ground, terrain, first, radius)
    resolution = ground.geometry.resolution
    field = travel_field(terrain.passable, terrain.cost, resolution, first, last)
    if not np.isfinite(field[last]):
        raise NoPathError(_why_not_reached(field, resolution, goal))
    way = way_to(field, terrain.passable, last, terrain.cost)
    corners = shortened(way, terrain.passable, terrain.cost)
    between = ground.geometry.centres_of(corners[1:-1])
    return np.vstack([np.asarray(start, float), between, np.asarray(goal, float)])


def _goal_cell(ground: Ground, goal: ArrayLike, radius: float) -> Cell:
    """Return the cell of the goal; NoPathError if a body of this radius cannot stand there."""
    place = _in_words(goal)
    cells = ground.geometry.cells_of(np.atleast_2d(goal))
    if not ground.geometry.contains(cells)[0]:
        raise NoPathError(f"the goal {place} lies off the map")
    row, col = (int(index) for index in cells[0])
    if ground.world.cells[row, col] < 0:
        raise NoPathError(f"the goal {place} lies on unknown ground")
    if ground.world.is_wall[row, col]:
        raise NoPathError(f"the goal {place} lies in a wall")
    if ground.is_blocked[row, col]:
        raise NoPathError(f"something that the map lacks stands at the goal {place}")
    if ground.clearance[row, col] < np.float32(ground.needed(radius)):
        raise NoPathError(
            f"the goal {place} is too close to a wall for this robot: "
            f"{ground.gaps_at(np.atleast_2d(goal))[0]:.2f} m, it needs "
            f"{ground.needed(radius) - 0.5 * ground.geometry.resolution:.2f} m"
        )
    return row, col


def _start_cell(ground: Ground, start: ArrayLike) -> Cell:
    """Return the cell the robot is in, or the free one beside it if the map has a wall there."""
    cells = ground.geometry.cells_of(np.atleast_2d(start))
    if not ground.geometry.contains(cells)[0]:
        raise NoPathError(f"the robot is off the map, at {_in_words(start)}")
    row, col = (int(index) for index in cells[0])
    if not ground.is_blocked[row, col]:
        return row, col
    rows, cols = _window(ground, (row, col), STANDS_BESIDE)
    free = np.argwhere(~ground.is_blocked[rows, cols]) + np.array([rows.start, cols.start])
    distances = np.hypot(*(free - np.array([row, col])).T) * ground.geometry.resolution
    if distances.min(initial=np.inf) > STANDS_BESIDE:
        raise NoPathError(f"the robot stands where the map is not free, at {_in_words(start)}")
    nearest = free[int(np.argmin(distances))]
    return int(nearest[0]), int(nearest[1])


def _with_way_out(ground: Ground, terrain: Terrain, first: Cell, radius: float) -> Terrain:
    """Return the terrain on which a body may leave its place although it is too near a wall."""
    if terrain.passable[first]:
        return terrain
    passable, cost = terrain.passable.copy(), terrain.cost.copy()
    for cell in _climbed(ground, first, ground.needed(radius) - LEAST_GAP):
        if not passable[cell]:
            passable[cell], cost[cell] = True, LEAVING_COST
    return replace(terrain, passable=passable, cost=cost)


def _climbed(ground: Ground, first: Cell, fits: float) -> set[Cell]:
    """Return the cells nearby that one gets to by going away from walls all the way.

    So no gap is passed that is too narrow: the way into one leads nearer to its walls. Where the
    body `fits`, which is a clearance in m, it may also go along them.
    """
    clearance, span = ground.clearance, int(LEAVING / ground.geometry.resolution)
    rows, cols = clearance.shape
    found, ends = {first}, [first]
    while ends:
        row, col = ends.pop()
        before = clearance[row, col]
        for cell in itertools.product((row - 1, row, row + 1), (col - 1, col, col + 1)):
            is_near = max(abs(cell[0] - first[0]), abs(cell[1] - first[1])) <= span
            inside = 0 <= cell[0] < rows and 0 <= cell[1] < cols
            if not (is_near and inside) or cell in found:
                continue
            if clearance[cell] > before or clearance[cell] == before >= fits:
                found.add(cell)
                ends.append(cell)
    return found


def _window(ground: Ground, cell: Cell, reach: float) -> tuple[slice, slice]:
    """Return the rows and cols within `reach` m of a cell."""
    span = int(np.ceil(reach / ground.geometry.resolution))
    row, col = cell
    return (
        slice(max(row - span, 0), row + span + 1),
        slice(max(col - span, 0), col + span + 1),
    )


def _why_not_reached(field: NDArray[np.float32], resolution: float, goal: ArrayLike) -> str:
    """Say whether it is the robot that cannot leave or the goal that cannot be reached."""
    reached = float(np.count_nonzero(np.isfinite(field))) * resolution**2
    if reached < ENCLOSED:
        return "the robot is enclosed: no way that it fits through leads away from here"
    return f"the goal {_in_words(goal)} cannot be reached: no way that the robot fits through"


def _in_words(point: ArrayLike) -> str:
    x, y = np.asarray(point, float)[:2]
    return f"({x:.2f}, {y:.2f})"
