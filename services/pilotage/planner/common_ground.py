"""Ground on which the robot may drive wherever it is: free under every likely place; pure.

While it is not known where the robot is, a way can only be said from where it stands. So this
grid lies round base_link, and a cell of it is passable if the body stands clear of the walls there
under all places that are still likely, or if the laser sees now that it does, which holds
wherever the robot is. What the laser sees in the way is never passable. Cells are asked for in the
order in which they are reached, for most of them never are.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.jit import kernel
from pilotage.core.laser_view import View
from pilotage.planner.situation import Hypotheses

RESOLUTION = 0.1
"""m."""


@dataclass(frozen=True)
class GroundParams:
    """How much room the robot takes.

    `radius` of the body [m]; `gap` kept to the walls of the map, and to what the laser sees [m];
    `reach`: how far from here ways are looked for [m]; `doubt`: share of the belief that may
    object to a cell, each place of it holding no more than `bold`.
    """

    radius: float = 0.165
    gap: float = 0.05
    reach: float = 25.0
    doubt: float = 0.05
    bold: float = 0.02


class Clearance:
    """How far it is from each cell of the map to the nearest one that stops a body."""

    def __init__(self, world: OccupancyMap) -> None:
        self.geometry = world.geometry
        half_a_cell = np.float32(0.5 * world.geometry.resolution)
        # Nobody knows what is beyond the edge.
        blocked = np.pad(~world.is_free, 1, constant_values=True)
        centres = distance_to_walls(blocked, world.geometry.resolution)[1:-1, 1:-1]
        self.metres = np.ascontiguousarray(centres) - half_a_cell


def common_ground(
    clearance: Clearance,
    places: Hypotheses,
    view: View,
    params: GroundParams,
) -> tuple[GridGeometry, NDArray[np.bool_]]:
    """Return a grid in base_link and where on it (rows, cols) the robot may go from here.

    Args:
        clearance: of the map.
        places: the likely places, heaviest first.
        view: what the laser sees.
        params: the room that the robot takes.
    """
    cells = 2 * round(params.reach / RESOLUTION) + 1
    corner = -0.5 * cells * RESOLUTION
    geometry = GridGeometry(cells, cells, RESOLUTION, (corner, corner, 0.0))
    needed = params.radius + params.gap
    blocked = _near(view.points, geometry, needed)
    is_seen_free = _seen_free(view, geometry, needed)
    in_grid = clearance.geometry.grid_from_map(places.poses[:, :2])
    turns = places.poses[:, 2] - clearance.geometry.origin[2]
    frames = np.column_stack([in_grid, np.cos(turns), np.sin(turns)])
    room = needed, params.doubt, params.bold
    known = clearance.metres, clearance.geometry.resolution
    return geometry, _flooded(known, frames, places.weights, (blocked, is_seen_free), room)


def _near(points: NDArray[np.float64], geometry: GridGeometry, reach: float) -> NDArray[np.bool_]:
    """Return the cells nearer than `reach` m to any point, but for those under the robot."""
    cells = geometry.cells_of(points) if len(points) else np.zeros((0, 2), np.int64)
    cells = cells[geometry.contains(cells)]
    holds = np.zeros(geometry.shape, bool)
    holds[cells[:, 0], cells[:, 1]] = True
    return distance_to_walls(holds, geometry.resolution) < reach


def _seen_free(view: View, geometry: GridGeometry, half_width: float) -> NDArray[np.bool_]:
    """Return the cells at the end of a straight way from here that the laser sees to be free."""
    free = np.zeros(geometry.shape, bool)
    if len(view.points) == 0:
        return free
    sight = float(np.hypot(*view.points.T).max())
    lengths = np.minimum(view.reach(view.bearings, half_width), sight) - half_width
    along = np.arange(0.0, sight, 0.5 * geometry.resolution)
    ways, steps = np.nonzero(along[None, :] < lengths[:, None])
    angles = view.bearings[ways]
    points = along[steps, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    cells = geometry.cells_of(points)
    cells = cells[geometry.contains(cells)]
    free[cells[:, 0], cells[:, 1]] = True
    return free


@kernel
def _flooded(
    known: tuple[NDArray[np.float32], float],
    frames: NDArray[np.float64],
    weights: NDArray[np.float64],
    seen: tuple[NDArray[np.bool_], NDArray[np.bool_]],
    room: tuple[float, float, float],
) -> NDArray[np.bool_]:
    """Return what is passable and connected with the middle of the grid (rows, cols).

    Args:
        known: clearance of the map (map rows, map cols) [m], and the width of its cells [m].
        frames: (n, 4) x, y [m], cos and sin of the places in the map's grid.
        weights: (n,) theirs.
        seen: where something stands, and where nothing does, (rows, cols) each.
        room: clearance needed [m], share that may object, most that one of them may weigh.
    """
    blocked, is_seen_free = seen
    rows, cols = blocked.shape
    passable = np.zeros((rows, cols), np.bool_)
    asked = np.zeros((rows, cols), np.bool_)
    queue = np.empty((rows * cols, 2), np.int32)
    queue[0, 0], queue[0, 1] = rows // 2, cols // 2
    asked[rows // 2, cols // 2] = passable[rows // 2, cols // 2] = True
    first, last = 0, 1
    while first < last:
        row, col = queue[first]
        first += 1
        for dr, dc in ((0, 1), (1, 0), (0, -1), (-1, 0)):
            r, c = row + dr, col + dc
            if not (0 <= r < rows and 0 <= c < cols) or asked[r, c]:
                continue
            asked[r, c] = True
            x, y = (c - cols // 2) * RESOLUTION, (r - rows // 2) * RESOLUTION
            # The robot stands where it stands: what is under it cannot be a wall.
            is_here = x * x + y * y < room[0] * room[0]
            if is_here or (
                not blocked[r, c]
                and (is_seen_free[r, c] or _is_agreed(known, frames, weights, (x, y), room))
            ):
                passable[r, c] = True
                queue[last, 0], queue[last, 1] = r, c
                last += 1
    return passable


@kernel
def _is_agreed(
    known: tuple[NDArray[np.float32], float],
    frames: NDArray[np.float64],
    weights: NDArray[np.float64],
    point: tuple[float, float],
    room: tuple[float, float, float],
) -> bool:
    """Say whether the body stands clear at a point of base_link under the places (n, 4)."""
    clearance, cell = known
    rows, cols = clearance.shape
    objecting = 0.0
    for i in range(len(frames)):
        x = frames[i, 0] + frames[i, 2] * point[0] - frames[i, 3] * point[1]
        y = frames[i, 1] + frames[i, 3] * point[0] + frames[i, 2] * point[1]
        col, row = int(np.floor(x / cell)), int(np.floor(y / cell))
        is_inside = 0 <= row < rows and 0 <= col < cols
        if not is_inside or clearance[row, col] < room[0]:
            objecting += weights[i]
            if weights[i] > room[2] or objecting > room[1]:
                return False
    return True


def warm_up() -> None:
    """Compile the kernels."""
    known = np.ones((1, 1), np.float32), 1.0
    nothing = np.zeros((3, 3), bool)
    _flooded(known, np.zeros((1, 4)), np.ones(1), (nothing, nothing), (1.0, 0.0, 0.0))
