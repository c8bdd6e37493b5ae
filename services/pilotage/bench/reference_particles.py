"""The particle filter in plain numpy: move, look every beam's end up, draw anew."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.distance_field import distance_to_walls
from pilotage.core.grid import OccupancyMap
from pilotage.localizer.markov_grid import MotionSpread
from pilotage.localizer.particle_field import BeamModel
from pilotage.localizer.particle_motion import standard_deviations


class PlainParticles:
    """Particles `poses` (n, 3), all of the same weight after each update."""

    def __init__(
        self, world: OccupancyMap, model: BeamModel, poses: NDArray[np.float64], tempering: float
    ) -> None:
        self.poses = poses
        self._geometry = world.geometry
        self._model = model
        self._tempering = tempering
        self._margin = int(np.ceil(model.reach / world.geometry.resolution)) + 2
        distance = distance_to_walls(np.pad(world.is_wall, self._margin), world.geometry.resolution)
        hit = (1.0 - model.outlier) * np.exp(-0.5 * (distance / model.sigma) ** 2)
        self._logs = np.log(hit + model.outlier).astype(np.float32)

    def update(
        self,
        increment: NDArray[np.float64],
        ends_base: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> None:
        """Predict by odometry's increment (3,), weigh by beams (m, 2), draw anew."""
        self._move(increment, rng)
        logs = self._tempering * self.log_likelihoods(ends_base)
        weights = np.exp(logs - logs.max())
        teeth = (np.arange(len(weights)) + rng.random()) / len(weights)
        chosen = np.searchsorted(np.cumsum(weights / weights.sum()), teeth)
        self.poses = self.poses[np.minimum(chosen, len(weights) - 1)]

    def log_likelihoods(self, ends_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return log p (n,) of the beams that are not too long."""
        x, y = ends_base[np.hypot(*ends_base.T) <= self._model.reach].T
        origin_x, origin_y, turn = self._geometry.origin
        dx, dy = self.poses[:, 0] - origin_x, self.poses[:, 1] - origin_y
        theta = self.poses[:, 2] - turn
        across = np.cos(turn) * dx + np.sin(turn) * dy
        up = -np.sin(turn) * dx + np.cos(turn) * dy
        cos, sin = np.cos(theta)[:, None], np.sin(theta)[:, None]
        cell = self._geometry.resolution
        cols = np.floor((across[:, None] + cos * x - sin * y) / cell).astype(int) + self._margin
        rows = np.floor((up[:, None] + sin * x + cos * y) / cell).astype(int) + self._margin
        height, width = self._logs.shape
        looked_up = self._logs[rows.clip(0, height - 1), cols.clip(0, width - 1)]
        summed: NDArray[np.float64] = looked_up.sum(axis=1, dtype=np.float64)
        return summed

    def _move(self, increment: NDArray[np.float64], rng: np.random.Generator) -> None:
        sigmas = standard_deviations(increment, MotionSpread())
        dx, dy, turn = (increment + sigmas * rng.standard_normal((len(self.poses), 3))).T
        x, y, theta = self.poses.T
        cos, sin = np.cos(theta), np.sin(theta)
        headings = (theta + turn + np.pi) % (2.0 * np.pi) - np.pi
        self.poses = np.column_stack([x + cos * dx - sin * dy, y + sin * dx + cos * dy, headings])
