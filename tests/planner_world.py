"""Floors, views and beliefs for whoever decides where to look from."""

import itertools

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drawing import draw
from pilotage.core import se2
from pilotage.core.grid import FREE, OCCUPIED, GridGeometry, OccupancyMap
from pilotage.core.laser_view import View
from pilotage.core.raycast import cast_scan
from pilotage.planner.situation import Hypotheses

BEARINGS = np.linspace(-0.75 * np.pi, 0.75 * np.pi, 271)
RANGE_MAX = 12.0
NOTHING = View(np.zeros((0, 2)), np.zeros(1))
"""What a laser sees that sees nothing."""


def plan(picture: str, mark: int = 5, resolution: float = 0.1) -> OccupancyMap:
    """Return a map whose marks are `mark` x `mark` cells of `resolution` metres."""
    coarse = draw(picture).cells
    cells = np.kron(coarse, np.ones((mark, mark), np.int8)).astype(np.int8)
    return OccupancyMap(GridGeometry(len(cells), len(cells[0]), resolution), cells)


def hall(side: float, resolution: float = 0.1) -> OccupancyMap:
    """Return an empty square hall with a wall around, `side` m inside."""
    count = round(side / resolution) + 2
    cells = np.full((count, count), FREE, np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    geometry = GridGeometry(count, count, resolution, (-resolution, -resolution, 0.0))
    return OccupancyMap(geometry, cells)


def seen(world: OccupancyMap, pose: ArrayLike, bearings: NDArray[np.float64] = BEARINGS) -> View:
    """Return what a laser in the middle of the robot sees without error."""
    return View.of(cast_scan(world, pose, bearings, RANGE_MAX), bearings, np.zeros(3))


def belief(*poses: ArrayLike, weights: ArrayLike | None = None) -> Hypotheses:
    """Return a belief in some poses, equally if nothing else is said."""
    shares = np.ones(len(poses)) if weights is None else np.asarray(weights, float)
    return Hypotheses(np.array([np.asarray(p, float) for p in poses]), shares / shares.sum())


def gap_to_walls(world: OccupancyMap, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far (n,) m points (n, 2) lie from the nearest cell that stops a body, exactly."""
    geometry = world.geometry
    in_cells = geometry.grid_from_map(points) / geometry.resolution
    boxes = np.argwhere(~world.is_free)[:, ::-1]
    gaps = np.empty(len(points))
    for i, point in enumerate(in_cells):
        off = np.maximum(np.maximum(boxes - point, point - boxes - 1.0), 0.0)
        gaps[i] = np.hypot(*off.T).min(initial=np.inf)
    return gaps * geometry.resolution


def along(path: NDArray[np.float64], step: float = 0.02) -> NDArray[np.float64]:
    """Return points (n, 2) every `step` m of a path."""
    pieces = []
    for start, end in itertools.pairwise(path):
        shares = np.linspace(0.0, 1.0, 2 + int(np.hypot(*(end - start)) / step))
        pieces.append(start + shares[:, None] * (end - start))
    return np.vstack(pieces)


def gaps_along(
    world: OccupancyMap, places: Hypotheses, path: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the least gap (n,) m of a path (m, 2) in base_link under each of n places."""
    points = along(path)
    return np.array(
        [gap_to_walls(world, se2.transform_points(pose, points)).min() for pose in places.poses]
    )
