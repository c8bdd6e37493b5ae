"""The faces of the walls of an occupancy map, as lines seen from its free space.

Outlines are traced along the sides between wall cells and free cells, cut into straight faces and
those of one wall merged across cracks. A face lies on the sides of its cells, not on their
centres: there a beam ends.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.grid import UNKNOWN, GridGeometry, OccupancyMap
from pilotage.core.lines import Lines
from pilotage.core.map_line_merging import merge_faces
from pilotage.core.map_line_splitting import lines_of, moments_of, split_contours
from pilotage.core.wall_contours import sides_to_free_space, trace_contours


@dataclass(frozen=True)
class MapLineParams:
    """What counts as a straight face of a wall in a map."""

    tolerance_cells: float = 1.5
    """Cells that the outline may lie off its face: walls drawn by a laser are ragged."""
    least_length: float = 0.3
    """m."""
    fringe_cells: int = 1
    """Free space is seen through so many unknown cells: a map's faces are often neither."""
    gap: float = 0.3
    """m: cracks in a wall up to this are closed; doors are wider."""


def map_lines(world: OccupancyMap, params: MapLineParams = MapLineParams()) -> Lines:
    """Return the faces of walls that free space touches, in the map frame.

    A face is known to within a cell (variance resolution^2 / 12, and what its outline scatters
    added): half of that it is off as a whole, and each of its ends is off by as much by itself.
    """
    sides = sides_to_free_space(world.is_wall, _seen_through(world, params.fringe_cells))
    corners, begins = trace_contours(sides)
    outline = corners.astype(np.float64)
    pieces = split_contours(outline, begins, params.tolerance_cells)
    faces = outline[pieces], moments_of(outline, pieces)
    resolution = world.geometry.resolution
    ends, moments = merge_faces(faces, params.gap / resolution, params.tolerance_cells)
    long = _lengths(ends, moments) >= params.least_length / resolution
    if not long.any():
        return Lines.none()
    lines = _in_grid(ends[long], moments[long], resolution)
    return lines.moved(world.geometry.origin)


def _seen_through(world: OccupancyMap, fringe: int) -> NDArray[np.bool_]:
    """Return free cells (rows, cols) and the unknown ones at most so far from them."""
    free, unknown = world.is_free, world.cells == UNKNOWN
    for _ in range(fringe):
        grown = free.copy()
        grown[1:] |= free[:-1]
        grown[:-1] |= free[1:]
        grown[:, 1:] |= free[:, :-1]
        grown[:, :-1] |= free[:, 1:]
        free = free | (grown & unknown)
    return free


def _lengths(ends: NDArray[np.float64], moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far apart (n,) the ends of faces are along the lines that fit them, in cells.

    The outline of a lump may fit a line that stands across the way between its ends.
    """
    angles = lines_of(moments)[:, 0]
    along = np.column_stack([-np.sin(angles), np.cos(angles)])
    return np.asarray(np.abs(np.einsum("ki,ki->k", ends[:, 1] - ends[:, 0], along)))


def _in_grid(ends: NDArray[np.float64], moments: NDArray[np.float64], resolution: float) -> Lines:
    """Return faces given in cells as lines in the grid's frame."""
    fits = lines_of(moments)
    along = ends[:, 1] - ends[:, 0]
    normals = np.column_stack([np.cos(fits[:, 0]), np.sin(fits[:, 0])])
    # Free space lies on the left of the way from end to end.
    backward = normals[:, 1] * along[:, 0] - normals[:, 0] * along[:, 1] < 0.0
    normals[backward] *= -1.0
    rho = np.where(backward, -fits[:, 1], fits[:, 1]) * resolution
    off = np.einsum("kei,ki->ke", ends * resolution, normals) - rho[:, None]
    laid = ends * resolution - off[:, :, None] * normals[:, None]
    alpha = np.asarray(wrap(np.arctan2(normals[:, 1], normals[:, 0])))
    variance = (1.0 / 12.0 + fits[:, 2]) * resolution**2
    return Lines(laid, np.column_stack([alpha, rho]), _covariances(laid, normals, variance))


def _covariances(
    ends: NDArray[np.float64], normals: NDArray[np.float64], variances: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the covariances (k, 2, 2) of lines whose two ends (k, 2, 2) err by variances (k,).

    Between them a line then errs by that variance, too.
    """
    along = np.column_stack([-normals[:, 1], normals[:, 0]])
    places = np.einsum("kei,ki->ke", ends, along)
    # A line through ends at places s and t that err by a and b across: d alpha = (a - b) / (t - s)
    # and d rho = (a t - b s) / (t - s).
    apart = places[:, 1] - places[:, 0]
    turning = np.stack([np.ones(len(apart)), -np.ones(len(apart))], axis=1)
    pushing = np.stack([places[:, 1], -places[:, 0]], axis=1)
    jacobian = np.stack([turning, pushing], axis=1) / apart[:, None, None]
    spread: NDArray[np.float64] = jacobian @ jacobian.transpose(0, 2, 1)
    spread[:, 1, 1] += 0.5
    return variances[:, None, None] * spread


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    cells = np.zeros((4, 8), np.int8)
    cells[:2] = 100
    map_lines(OccupancyMap(GridGeometry(4, 8, 0.1), cells))
