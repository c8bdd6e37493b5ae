"""What a look may be expected to tell, place by place and by its definition."""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.laser_view import View
from pilotage.core.raycast import cast_rays
from pilotage.planner.common_ground import GroundParams
from pilotage.planner.expected_scans import HEADINGS, LEVELS, SightParams
from pilotage.planner.situation import Hypotheses

Cell = tuple[int, int]


def entropy(weights: NDArray[np.float64]) -> float:
    """Twin of `information.entropy`, in bits."""
    return -sum(float(w) * math.log2(w) for w in weights if w > 0.0)


def expected_gain(log_likelihoods: NDArray[np.float32], weights: NDArray[np.float64]) -> float:
    """Twin of `information.expected_gain`: one belief after the other, by Bayes."""
    left = 0.0
    for row in log_likelihoods.astype(float):
        posterior = weights * np.exp(row - row.max())
        left += entropy(posterior / posterior.sum())
    return entropy(weights) - left / len(log_likelihoods)


def expected_scan(
    world: OccupancyMap, table: GridGeometry, pose: NDArray[np.float64], params: SightParams
) -> NDArray[np.float64]:
    """Twin of one column of `ExpectedScans.at`: rays cast from the state nearest to a pose."""
    cell = table.cells_of(pose[None, :2])
    if not table.contains(cell)[0]:
        return np.zeros(params.beams)
    centre = table.centres_of(cell)[0]
    step = 2.0 * np.pi / HEADINGS
    rays = np.empty((params.beams, 3))
    rays[:, :2] = centre
    for beam in range(params.beams):
        rays[beam, 2] = round(pose[2] / step + beam * HEADINGS / params.beams) * step
    ranges = np.minimum(cast_rays(world, rays, params.range_max), params.range_max)
    scan: NDArray[np.float64] = np.rint(ranges * LEVELS / params.range_max) * (
        params.range_max / LEVELS
    )
    return scan


def log_likelihoods(
    scans: NDArray[np.float32], truths: NDArray[np.int64], params: SightParams
) -> NDArray[np.float64]:
    """Twin of `ExpectedScans.log_likelihoods`: beam by beam."""
    costs = np.zeros((len(truths), scans.shape[1]))
    for i, truth in enumerate(truths):
        for j in range(scans.shape[1]):
            for beam in scans.astype(float):
                sigma = params.sigma + params.sigma_per_metre * beam[truth]
                costs[i, j] += min(params.bound, 0.5 * ((beam[j] - beam[truth]) / sigma) ** 2)
    return -params.tempering * costs


def merged(belief: Hypotheses, near: float, alike: float, most: int) -> Hypotheses:
    """Twin of `hypotheses.merged`, with a list of samples for each place."""
    places: list[list[int]] = []
    for i in np.argsort(-belief.weights, kind="stable"):
        if belief.weights[i] <= 0.0:
            continue
        for place in places:
            off = belief.poses[i] - belief.poses[place[0]]
            if math.hypot(off[0], off[1]) <= near and abs(wrap(float(off[2]))) <= alike:
                place.append(int(i))
                break
        else:
            if len(places) < most:
                places.append([int(i)])
    poses = np.array([_mean(belief, place) for place in places]).reshape(-1, 3)
    mass = np.array([belief.weights[place].sum() for place in places])
    order = np.argsort(-mass, kind="stable")
    return Hypotheses(poses[order], mass[order] / mass.sum())


def _mean(belief: Hypotheses, place: list[int]) -> NDArray[np.float64]:
    """Return the mean pose (3,) of some samples that point nearly the same way."""
    poses, weights = belief.poses[place].copy(), belief.weights[place]
    first = poses[0, 2]
    poses[:, 2] = wrap(poses[:, 2] - first)
    mean: NDArray[np.float64] = weights @ poses / weights.sum()
    mean[2] = wrap(float(mean[2] + first))
    return mean


def clearance(world: OccupancyMap) -> NDArray[np.float64]:
    """Twin of `common_ground.Clearance`: every cell against every one that stops a body.

    Those all round the map stop it as well.
    """
    rows, cols = world.geometry.shape
    around = [(r, c) for r in (-1, rows) for c in range(-1, cols + 1)]
    around += [(r, c) for c in (-1, cols) for r in range(rows)]
    blocked = np.concatenate([np.argwhere(~world.is_free), around])
    metres = np.full(world.geometry.shape, np.inf)
    for cell in np.ndindex(metres.shape):
        metres[cell] = np.hypot(*(blocked - cell).T).min() - 0.5
    distances: NDArray[np.float64] = metres * world.geometry.resolution
    return distances


def common_ground(
    world: OccupancyMap,
    places: Hypotheses,
    view: View,
    geometry: GridGeometry,
    params: GroundParams,
) -> NDArray[np.bool_]:
    """Twin of `common_ground.common_ground`: a cell is asked for once a neighbour is passable."""
    needed, metres = params.radius + params.gap, clearance(world)
    free = _seen_free(view, geometry, needed)
    blocked = _near_points(view, geometry, needed)
    passable = np.zeros(geometry.shape, bool)
    middle = geometry.rows // 2, geometry.cols // 2
    passable[middle] = True
    waiting, asked = [middle], {middle}
    while waiting:
        for cell in _beside(waiting.pop(0), geometry):
            if cell in asked:
                continue
            asked.add(cell)
            point = geometry.centres_of(np.array([cell]))[0]
            is_here = math.hypot(*point) < needed - 1e-9
            agreed = free[cell] or _is_agreed(world, metres, places, point, params)
            if is_here or (not blocked[cell] and agreed):
                passable[cell] = True
                waiting.append(cell)
    return passable


def _beside(cell: Cell, geometry: GridGeometry) -> list[Cell]:
    row, col = cell
    around = [(row, col + 1), (row + 1, col), (row, col - 1), (row - 1, col)]
    return [(r, c) for r, c in around if 0 <= r < geometry.rows and 0 <= c < geometry.cols]


def _is_agreed(
    world: OccupancyMap,
    metres: NDArray[np.float64],
    places: Hypotheses,
    point: NDArray[np.float64],
    params: GroundParams,
) -> bool:
    """Say whether few enough of the places have a wall near a point of base_link."""
    objecting = 0.0
    for pose, weight in zip(places.poses, places.weights, strict=True):
        cell = world.geometry.cells_of(se2.transform_points(pose, point[None]))
        is_inside = world.geometry.contains(cell)[0]
        if not is_inside or metres[tuple(cell[0])] < params.radius + params.gap:
            if weight > params.bold:
                return False
            objecting += weight
    return objecting <= params.doubt


def _near_points(view: View, geometry: GridGeometry, reach: float) -> NDArray[np.bool_]:
    """Say which cells lie nearer than `reach` m to the cell of a point."""
    holds = {tuple(cell) for cell in geometry.cells_of(view.points)} if len(view.points) else set()
    holds = {cell for cell in holds if geometry.contains(np.array([cell]))[0]}
    near = np.zeros(geometry.shape, bool)
    for cell in np.ndindex(near.shape):
        apart = [math.hypot(cell[0] - row, cell[1] - col) for row, col in holds]
        near[cell] = np.float32(min(apart, default=np.inf) * geometry.resolution) < reach
    return near


def _seen_free(view: View, geometry: GridGeometry, half_width: float) -> NDArray[np.bool_]:
    """Say which cells a straight way from here crosses that ends before anything seen."""
    free = np.zeros(geometry.shape, bool)
    farthest = max((math.hypot(x, y) for x, y in view.points), default=0.0)
    for bearing in view.bearings:
        way = min(float(view.reach(bearing, half_width)[0]), farthest) - half_width
        for step in range(math.ceil(max(way, 0.0) / (0.5 * geometry.resolution))):
            length = step * 0.5 * geometry.resolution
            point = length * np.array([[math.cos(bearing), math.sin(bearing)]])
            cell = geometry.cells_of(point)
            if length < way and geometry.contains(cell)[0]:
                free[tuple(cell[0])] = True
    return free


def look(scan: NDArray[np.float64], terms: int) -> NDArray[np.float64]:
    """Twin of `map_potential._looks` for one scan (beams,): Fourier sums as defined."""
    beams, values = len(scan), []
    for k in range(terms):
        total = sum(r * np.exp(-2j * np.pi * k * b / beams) for b, r in enumerate(scan))
        values.append(abs(total) / beams * (1.0 if k == 0 else math.sqrt(2.0)))
    return np.array(values)


def information(
    looks: NDArray[np.float32], others: NDArray[np.float32], width: float
) -> NDArray[np.float64]:
    """Twin of `map_potential._information`: each look against each other."""
    bits = []
    for one in looks:
        alike = sum(
            math.exp(-float(((one - other) ** 2).sum()) / (2 * width**2)) for other in others
        )
        bits.append(math.log2((len(others) + 1.0) / (1.0 + alike)))
    return np.array(bits)
