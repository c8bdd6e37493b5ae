"""Scan matching as formulas: dictionaries of cells, all pairs, all offsets, step by step."""

import math
from collections import defaultdict
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pilotage.mapper.correlative_kernels import Task
from pilotage.mapper.surfel_kernels import SurfelMap

Floats = NDArray[np.float64]
Numbers = NDArray[np.int32]


def thin_points(points: Floats, size: float) -> Floats:
    """Twin of `surfel_kernels.thin_points`: row by row of the squares."""
    if len(points) == 0:
        return np.empty((0, 2))
    cells = np.floor((points - points.min(axis=0)) / size).astype(int)[:, ::-1]
    _, which = np.unique(cells, axis=0, return_inverse=True)
    return np.array([points[which == k].mean(axis=0) for k in range(which.max() + 1)])


def pool_points(points: Floats, corner: Floats, index: Numbers, size: float) -> Floats:
    """Twin of `surfel_kernels.pool_points`: cells are numbered as points come to them."""
    members: dict[tuple[int, int], list[Floats]] = defaultdict(list)
    for point in points:
        col, row = np.floor((point - corner) / size).astype(int)
        members[row, col].append(point)
    for number, cell in enumerate(members):
        index[cell] = number
    return np.array([np.mean(some, axis=0) for some in members.values()]).reshape(-1, 2)


def wall_directions(
    means: Floats, corner: Floats, index: Numbers, size: float, reach: int
) -> tuple[Floats, Floats]:
    """Twin of `surfel_kernels.wall_directions`: the eigenvectors of the neighbours' scatter."""
    cells = np.floor((means - corner) / size).astype(int)
    assert all(index[row, col] == k for k, (col, row) in enumerate(cells))
    normals, flatness = np.zeros((len(means), 2)), np.zeros(len(means))
    for k, cell in enumerate(cells):
        near = means[np.abs(cells - cell).max(axis=1) <= reach]
        if len(near) < 3:
            continue
        spread = near - near.mean(axis=0)
        values, vectors = np.linalg.eigh(spread.T @ spread)
        normals[k] = vectors[:, 0]
        flatness[k] = 1.0 - math.sqrt(max(values[0], 0.0) / values[1]) if values[1] > 1e-9 else 0.0
    return normals, flatness


def spread_nearest(
    means: Floats, corner: Floats, shape: tuple[int, int], size: float, reach: int
) -> tuple[Numbers, NDArray[np.float32]]:
    """Twin of `surfel_kernels.spread_nearest`: each cell asks every mean."""
    nearest, distance = np.full(shape, -1, np.int32), np.full(shape, np.inf, np.float32)
    cells = np.floor((means - corner) / size).astype(int)
    for row, col in np.ndindex(shape):
        centre = corner + size * np.array([col + 0.5, row + 0.5])
        is_near = np.abs(cells - [col, row]).max(axis=1) <= reach
        if is_near.any():
            apart = np.where(is_near, np.linalg.norm(means - centre, axis=1), np.inf)
            nearest[row, col], distance[row, col] = apart.argmin(), apart.min()
    return nearest, distance


def normal_equations(
    pose: Floats, points: Floats, walls: SurfelMap, sigmas: tuple[float, float, float]
) -> tuple[Floats, Floats, float, int]:
    """Twin of `matching_kernels.normal_equations`: Jacobians as matrices, point by point."""
    H, g, cost, seen = np.zeros((3, 3)), np.zeros(3), 0.0, 0
    for point in points:
        k = surfel_of(pose, point, walls)
        if k < 0:
            cost += 1.0
            continue
        seen += 1
        axes, error, precision = _residual(pose, point, walls, k, sigmas)
        chi = _chi(error, precision, sigmas)
        lever = _rotation(pose[2] + math.pi / 2.0) @ point
        jacobian = axes @ np.column_stack([np.eye(2), lever])
        weight = (1.0 + chi) ** -2.0
        H += weight * jacobian.T @ precision @ jacobian
        g += weight * jacobian.T @ precision @ error
        cost += chi / (1.0 + chi)
    return H, g, cost / max(1, len(points)), seen


def robust_cost(
    pose: Floats,
    points: Floats,
    walls: SurfelMap,
    sigmas: tuple[float, float, float],
    surfels: list[int],
) -> float:
    """The mean of Geman and McClure's cost over the points, whose surfels are given."""
    total = 0.0
    for point, k in zip(points, surfels, strict=True):
        _, error, precision = _residual(pose, point, walls, k, sigmas)
        chi = _chi(error, precision, sigmas)
        total += chi / (1.0 + chi) if k >= 0 else 1.0
    return total / len(points)


def _residual(
    pose: Floats, point: Floats, walls: SurfelMap, k: int, sigmas: tuple[float, float, float]
) -> tuple[Floats, Floats, Floats]:
    """Rows across and along the wall, the point's error along these, and its precision."""
    across, along, _ = sigmas
    flat = walls.flatness[k]
    nx, ny = walls.normals[k] if flat > 0.0 else (1.0, 0.0)
    axes = np.array([[nx, ny], [-ny, nx]])
    error = axes @ (_rotation(pose[2]) @ point + pose[:2] - walls.means[k])
    return axes, error, np.diag([across**-2.0, (across + (along - across) * flat) ** -2.0])


def _chi(error: Floats, precision: Floats, sigmas: tuple[float, float, float]) -> float:
    return float(error @ precision @ error) * (sigmas[0] / sigmas[2]) ** 2


def surfel_of(pose: Floats, point: Floats, walls: SurfelMap) -> int:
    """The number of the surfel that a point of a scan belongs to, -1 without one."""
    place = _rotation(pose[2]) @ point + pose[:2]
    col, row = np.floor((place - walls.corner) / walls.cell).astype(int)
    rows, cols = walls.nearest.shape
    return int(walls.nearest[row, col]) if 0 <= row < rows and 0 <= col < cols else -1


def pooled(layer: NDArray[np.uint8], step: int) -> NDArray[np.uint8]:
    """Twin of `correlative_kernels.pooled`: beyond the edge is as at the edge."""
    best = layer.copy()
    for rows, cols in product((0, step), repeat=2):
        wide = np.pad(layer, ((0, rows), (0, cols)), mode="edge")
        best = np.maximum(best, wide[rows:, cols:])
    return best


def score(task: Task, turn: int, row: int, col: int) -> float:
    """What `branch_and_bound` finds the most of: values under the points, less penalties."""
    layer, total = task.layers[0], -float(task.per_turn[turn])
    for r, c in task.cells[turn] + [row, col]:
        if 0 <= r < layer.shape[0] and 0 <= c < layer.shape[1]:
            total += int(layer[r, c])
    return total - task.per_square * (row**2 + col**2)


def branch_and_bound(task: Task, least: float) -> tuple[int, int, int, float]:
    """Twin of `correlative_kernels.branch_and_bound`: every turn and every offset is tried."""
    best = (-1, 0, 0, least)
    offsets = range(-task.half, task.half + 1)
    for turn, row, col in product(range(len(task.cells)), offsets, offsets):
        found = score(task, turn, row, col)
        if found > best[3]:
            best = turn, row, col, found
    return best


def beams_through_walls(origin: Floats, ends: Floats, walls: SurfelMap, margin: float) -> int:
    """Twin of `visibility_kernels.beams_through_walls`: all places of a beam at once."""
    through = 0
    for end in ends:
        length = float(np.linalg.norm(end - origin))
        count = int((length - margin) / (0.5 * walls.cell))
        ways = 0.5 * walls.cell * np.arange(4, max(4, count))
        places = origin + ways[:, None] * (end - origin) / length
        cols, rows = np.floor((places - walls.corner) / walls.cell).astype(int).T
        shape = walls.distance.shape
        inside = (rows >= 0) & (rows < shape[0]) & (cols >= 0) & (cols < shape[1])
        through += bool((walls.distance[rows[inside], cols[inside]] < 0.5 * walls.cell).any())
    return through


def shortest_ways(count: int, edges: list[tuple[int, int, float]], start: int) -> Floats:
    """Lengths (count,) of the shortest ways from `start` (Floyd and Warshall), infinite if none."""
    ways = np.where(np.eye(count, dtype=bool), 0.0, np.inf)
    for one, other, length in edges:
        ways[one, other] = ways[other, one] = min(ways[one, other], length)
    for middle in range(count):
        ways = np.minimum(ways, ways[:, [middle]] + ways[[middle], :])
    from_there: Floats = ways[start]
    return from_there


def _rotation(angle: float) -> Floats:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])
