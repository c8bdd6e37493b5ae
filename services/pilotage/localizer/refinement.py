"""The pose beyond the cell: Gauss-Newton on the distance from beam ends to the nearest wall.

Lu & Milios's idea on a distance field: move the pose so that the ends of the beams come to lie
on walls. Robust by a weight that falls with the distance, so that people and furniture which the
map lacks do not pull.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import GridGeometry, OccupancyMap

ITERATIONS = 8
NEAR = 0.2
"""Ends within this distance [m] of a wall count as matched."""

REACH = 0.25
"""Scale [m] beyond which a beam's end no longer pulls."""

DAMPING = 1.0
"""Added to the information [1/m^2 and 1/rad^2]: a corridor must not slide along itself."""


@dataclass(frozen=True)
class WallDistance:
    """Distance (rows, cols) to the nearest wall [m], capped, on its geometry."""

    geometry: GridGeometry
    distance: NDArray[np.float64]

    def sample(
        self, points_map: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return distance (n,) and its gradient (n, 2) in the map frame, bilinear."""
        resolution = self.geometry.resolution
        at = self.geometry.grid_from_map(points_map) / resolution - 0.5
        limit = np.array(self.geometry.shape[::-1]) - 2
        low = np.clip(np.floor(at), 0, limit).astype(np.int64)
        fx, fy = np.clip(at - low, 0.0, 1.0).T
        col, row = low.T
        d = self.distance
        a, b, c, e = d[row, col], d[row, col + 1], d[row + 1, col], d[row + 1, col + 1]
        value = (a * (1 - fx) + b * fx) * (1 - fy) + (c * (1 - fx) + e * fx) * fy
        along = np.stack([(b - a) * (1 - fy) + (e - c) * fy, (c - a) * (1 - fx) + (e - b) * fx], 1)
        cos, sin = np.cos(self.geometry.origin[2]), np.sin(self.geometry.origin[2])
        gradient = along @ np.array([[cos, sin], [-sin, cos]]) / resolution
        outside = np.any((at < -0.5) | (at > limit + 1.5), axis=1, keepdims=True)
        return np.where(outside[:, 0], CAP, value), np.where(outside, 0.0, gradient)


CAP = 2.0
"""Farther walls [m] do not matter."""


def wall_distance(world: OccupancyMap) -> WallDistance:
    """Return the distance to the nearest wall of a map, on its own cells."""
    distance = distance_to_walls(world.is_wall, world.geometry.resolution)
    return WallDistance(world.geometry, np.minimum(distance, CAP).astype(np.float64))


def refine(
    map_from_base: NDArray[np.float64], ends_base: NDArray[np.float64], walls: WallDistance
) -> NDArray[np.float64]:
    """Return the pose (3,) near `map_from_base` (3,) that puts beam ends (n, 2) onto walls."""
    pose = map_from_base.copy()
    for _ in range(ITERATIONS):
        ends = se2.transform_points(pose, ends_base)
        distance, gradient = walls.sample(ends)
        lever = ends - pose[:2]
        turning = gradient[:, 1] * lever[:, 0] - gradient[:, 0] * lever[:, 1]
        jacobian = np.column_stack([gradient, turning])
        weight = 1.0 / (1.0 + (distance / REACH) ** 2) ** 2
        information = (jacobian * weight[:, None]).T @ jacobian + DAMPING * np.eye(3)
        step = -np.linalg.solve(information, jacobian.T @ (weight * distance))
        pose = pose + step
        if np.abs(step).max() < 1e-4:
            break
    return se2.compose(pose, np.zeros(3))


def matched_share(
    map_from_base: NDArray[np.float64], ends_base: NDArray[np.float64], walls: WallDistance
) -> float:
    """Return the share of beam ends (n, 2) that lie near a wall; 0 without any beam."""
    if not len(ends_base):
        return 0.0
    distance, _ = walls.sample(se2.transform_points(map_from_base, ends_base))
    return float(np.mean(distance <= NEAR))
