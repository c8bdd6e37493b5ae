"""What the filter believes, as other methods show theirs: one Gaussian, or that nobody knows."""

import itertools
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry
from pilotage.localizer.line_ekf import GaussianPose
from pilotage.localizer.particle_belief import BIN_SIZE, BIN_TURN
from pilotage.localizer.particle_start import FreeSpace

Array = NDArray[np.float64]

STEPS = 9
"""Most samples along each axis of a Gaussian, from -2 to 2 standard deviations."""

HEADINGS = 8
"""Of the samples of a belief that knows nothing; they are spread over the free space."""

REACH = 4.0
"""Standard deviations beyond which a cell holds nothing of a Gaussian."""


@dataclass(frozen=True)
class GaussianBelief:
    """A Gaussian over poses; `geometry`: cells to show it on."""

    pose: GaussianPose
    geometry: GridGeometry

    def heaviest(self, most: int) -> tuple[Array, Array]:
        """Return samples (n, 3), always the same ones, and their shares (n,) of the belief.

        Mean and covariance of three and more along each axis are those of the Gaussian.
        """
        count = min(STEPS, max(1, int(most ** (1.0 / 3.0) + 1e-9)))
        offsets, weights = _samples(count)
        poses = self.pose.mean + offsets @ root(self.pose.covariance).T
        poses[:, 2] = wrap(poses[:, 2])
        return poses, weights

    def marginal(self) -> NDArray[np.float32]:
        """Return the share (rows, cols) of the belief in each cell, whatever the heading."""
        corner = se2.compose(se2.inverse(self.geometry.origin), self.pose.mean)
        cos, sin = np.cos(self.geometry.origin[2]), np.sin(self.geometry.origin[2])
        turned = np.array([[cos, sin], [-sin, cos]])
        spread = turned @ self.pose.covariance[:2, :2] @ turned.T
        spread += np.eye(2) * self.geometry.resolution**2 / 12.0
        cols, dx = _near(corner[0], spread[0, 0], self.geometry.cols, self.geometry.resolution)
        rows, dy = _near(corner[1], spread[1, 1], self.geometry.rows, self.geometry.resolution)
        shares = np.zeros(self.geometry.shape, np.float32)
        away = np.stack(np.broadcast_arrays(dx, dy[:, None]), axis=-1)
        density = np.exp(-0.5 * np.einsum("...i,...i", away @ np.linalg.inv(spread), away))
        shares[rows, cols] = density / max(float(density.sum()), 1e-300)
        return shares

    def entropy(self) -> float:
        """Return H in bits over bins as wide as the particles', nothing if it is narrower."""
        _, log_det = np.linalg.slogdet(2.0 * np.pi * np.e * self.pose.covariance)
        return max(0.0, float(0.5 * log_det / np.log(2.0)) - _log_bin())


@dataclass(frozen=True)
class NoBelief:
    """The robot may be anywhere in the free space."""

    free: FreeSpace

    @property
    def geometry(self) -> GridGeometry:
        """The cells of `marginal`."""
        return self.free.geometry

    def heaviest(self, most: int) -> tuple[Array, Array]:
        """Return poses (n, 3) spread evenly, and their shares (n,): each that of its own bin."""
        count = min(len(self.free.cells), max(1, most // HEADINGS))
        chosen = np.linspace(0, len(self.free.cells) - 1, count).astype(np.int64)
        places = self.geometry.centres_of(self.free.cells[chosen])
        turns = wrap(np.arange(HEADINGS) * 2.0 * np.pi / HEADINGS)
        poses = np.column_stack([np.repeat(places, HEADINGS, 0), np.tile(turns, count)])
        return poses, np.full(len(poses), min(2.0 ** -self.entropy(), 0.4 / len(poses)))

    def marginal(self) -> NDArray[np.float32]:
        """Return the share (rows, cols) of the belief in each cell, whatever the heading."""
        return (self.free.mask / len(self.free.cells)).astype(np.float32)

    def entropy(self) -> float:
        """Return H in bits over bins as wide as the particles'."""
        floor = len(self.free.cells) * self.geometry.resolution**2
        return max(0.0, float(np.log2(floor * 2.0 * np.pi)) - _log_bin())


def root(covariance: Array) -> Array:
    """Return a root (3, 3) of a covariance, which may be singular."""
    values, axes = np.linalg.eigh((covariance + covariance.T) / 2.0)
    rooted: Array = axes * np.sqrt(np.maximum(values, 0.0))
    return rooted


@cache
def _samples(count: int) -> tuple[Array, Array]:
    """Return offsets (n, 3) in standard deviations and weights (n,) that sum to one."""
    steps = np.linspace(-2.0, 2.0, count) if count > 1 else np.zeros(1)
    weights = np.exp(-0.5 * steps**2)
    weights /= weights.sum()
    variance = float(weights @ steps**2)
    steps = steps / np.sqrt(variance) if count > 1 else steps
    offsets = np.array(list(itertools.product(steps, repeat=3)))
    return offsets, np.prod(list(itertools.product(weights, repeat=3)), axis=1)


def _near(middle: float, variance: float, count: int, cell: float) -> tuple[slice, Array]:
    """Return the cells of one axis within reach of `middle` [m], at least one, and how far off."""
    bounds = (middle + np.array([-REACH, REACH]) * np.sqrt(variance)) / cell
    first = int(np.clip(np.floor(bounds[0]), 0, count - 1))
    end = int(np.clip(np.ceil(bounds[1]), first + 1, count))
    cells = np.arange(first, end, dtype=np.float64)
    return slice(first, end), (cells + 0.5) * cell - middle


def _log_bin() -> float:
    return float(np.log2(BIN_SIZE**2 * BIN_TURN))
