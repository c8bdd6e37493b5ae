"""Scan matching in plain numpy: every pose of the window, then Gauss-Newton; no compiled code.

The twin that the product is measured against (and, in the tests, compared with). It looks at all
offsets of a turn at once, and nowhere else when nothing fits, which is in its favour.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.mapper.scan_tracker import LocalMap, Tracked, TrackerParams
from pilotage.mapper.surfel_kernels import SurfelMap

FULL = 255.0
Floats = NDArray[np.float64]


def plain_match(guess: Tracked, points: Floats, here: LocalMap, params: TrackerParams) -> Floats:
    """Return the pose (3,) of the points (n, 2) of a scan, as `scan_tracker.corrected` finds it."""
    few = points[:: max(1, len(points) // params.search_points)]
    start = best_pose(guess, few, here, params)
    return refined(here.surfels, points, start, guess, params)


def best_pose(guess: Tracked, points: Floats, here: LocalMap, params: TrackerParams) -> Floats:
    """Return the best pose (3,) within three standard deviations, each looked at."""
    sigma = float(np.sqrt(np.linalg.eigvalsh(guess.covariance[:2, :2])[-1]))
    turn_sigma = float(np.sqrt(guess.covariance[2, 2]))
    radius, turn = np.minimum(3.0 * np.array([sigma, turn_sigma]), params.search_limits)
    cell = here.surfels.cell
    step = cell / max(float(np.percentile(np.linalg.norm(points, axis=1), 80.0)), 1.0)
    half, turns = int(np.ceil(radius / cell)), int(np.ceil(turn / step))
    offsets = cell * np.arange(-half, half + 1)
    away = (offsets[:, None] ** 2 + offsets**2) / sigma**2
    penalty = 0.25 * max(1.0, len(points) / params.match.worth) * FULL
    best, pose = -np.inf, guess.pose
    for k in range(-turns, turns + 1):
        turned = guess.pose + np.array([0.0, 0.0, k * step])
        scores = scores_around(here, se2.transform_points(turned, points), half)
        scores -= penalty * (away + (k * step / turn_sigma) ** 2)
        row, col = np.unravel_index(int(scores.argmax()), scores.shape)
        if scores[row, col] > best:
            best = float(scores[row, col])
            pose = turned + np.array([offsets[col], offsets[row], 0.0])
    return pose


def scores_around(here: LocalMap, places: Floats, half: int) -> Floats:
    """Return the sums (rows, cols) of the map's values under places (n, 2) moved by -half..half."""
    values = np.pad(here.raster.layers[0], half)
    cells = np.floor((places - here.raster.corner) / here.raster.cell).astype(int)
    cells += here.raster.pad
    rows, cols = here.raster.layers[0].shape
    width = 2 * half + 1
    total = np.zeros((width, width))
    for col, row in cells[np.all((cells >= 0) & (cells < [cols, rows]), axis=1)]:
        total += values[row : row + width, col : col + width]
    return total


def refined(
    walls: SurfelMap, points: Floats, start: Floats, guess: Tracked, params: TrackerParams
) -> Floats:
    """Return the most probable pose (3,) next to `start`, by Gauss-Newton."""
    pose, held, match = start.copy(), np.linalg.inv(guess.covariance), params.match
    for scale in match.scales:
        for _ in range(match.iterations):
            H, g = normal_equations(pose, points, walls, (match.across, match.along, scale))
            off = pose - guess.pose
            off[2] = wrap(float(off[2]))
            step = -np.linalg.solve(H + held, g + held @ off)
            pose += step
            if np.abs(step[:2]).max() < 1e-4 and abs(step[2]) < 1e-5:
                break
    pose[2] = wrap(float(pose[2]))
    return pose


def normal_equations(
    pose: Floats, points: Floats, walls: SurfelMap, sigmas: tuple[float, float, float]
) -> tuple[Floats, Floats]:
    """Return H (3, 3) and g (3,) of the points (n, 2), all of them at once."""
    across, along, scale = sigmas
    turned = se2.transform_points((0.0, 0.0, pose[2]), points)
    near = _nearest(turned + pose[:2], walls)
    turned, near = turned[near >= 0], near[near >= 0]
    flat = walls.flatness[near]
    normals = np.where(flat[:, None] > 0.0, walls.normals[near], [1.0, 0.0])
    tangents = np.stack([-normals[:, 1], normals[:, 0]], axis=1)
    error = turned + pose[:2] - walls.means[near]
    jacobians, residuals, chi = [], [], np.zeros(len(near))
    weights = np.full(len(near), across**-2.0), (across + (along - across) * flat) ** -2.0
    for axis, weight in zip((normals, tangents), weights, strict=True):
        lever = axis[:, 1] * turned[:, 0] - axis[:, 0] * turned[:, 1]
        jacobians.append(np.column_stack([axis, lever]))
        residuals.append(np.sum(axis * error, axis=1))
        chi += weight * residuals[-1] ** 2 * (across / scale) ** 2
    J, r = np.vstack(jacobians), np.concatenate(residuals)
    w = np.concatenate([weight / (1.0 + chi) ** 2 for weight in weights])
    return (J * w[:, None]).T @ J, J.T @ (w * r)


def _nearest(places: Floats, walls: SurfelMap) -> NDArray[np.int64]:
    """Return the numbers (n,) of the surfels at places (n, 2), -1 where there is none."""
    cols, rows = np.floor((places - walls.corner) / walls.cell).astype(int).T
    inside = (rows >= 0) & (rows < walls.nearest.shape[0])
    inside &= (cols >= 0) & (cols < walls.nearest.shape[1])
    near = np.full(len(places), -1, np.int64)
    near[inside] = walls.nearest[rows[inside], cols[inside]]
    return near
