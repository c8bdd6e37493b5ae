"""The joint correction of a pose by pairs of walls, in the form that keeps covariances positive."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.corners import Corners
from pilotage.core.lines import Lines
from pilotage.localizer.ekf_walls import Walls

Array = NDArray[np.float64]

ITERATIONS = 3
"""Of the linearisation: lines are nearly linear, corners under a large turn are not."""


def no_pairs() -> NDArray[np.int64]:
    """Return no pairs (0, 2)."""
    return np.empty((0, 2), np.int64)


def _none_new() -> NDArray[np.bool_]:
    return np.empty(0, bool)


@dataclass(frozen=True)
class Pairs:
    """Pairs of walls: `lines` (k, 2) and `corners` (m, 2) as indices of seen and known.

    `is_new` (m,): whether a corner says more than the lines that it is made of.
    """

    lines: NDArray[np.int64] = field(default_factory=no_pairs)
    corners: NDArray[np.int64] = field(default_factory=no_pairs)
    is_new: NDArray[np.bool_] = field(default_factory=_none_new)

    def __len__(self) -> int:
        return len(self.lines) + len(self.corners)

    def matched_share(self, seen: Walls) -> float:
        """Return how much of the length of the lines seen is matched; all of none is 1."""
        lengths = seen.lines.lengths
        return float(lengths[self.lines[:, 0]].sum() / lengths.sum()) if len(lengths) else 1.0


@dataclass(frozen=True)
class Linear:
    """Innovations (n,) about a pose, their jacobian (n, 3) and the noise (n, n) in them."""

    innovation: Array
    jacobian: Array
    noise: Array


def corrected(
    mean: Array, covariance: Array, walls: tuple[Walls, Walls], pairs: Pairs
) -> tuple[Array, Array]:
    """Return a pose (3,) and its covariance (3, 3) corrected by pairs of seen and known walls.

    Iterated: the measurement is linearised anew about each result. The noise of a wall of the
    map is shared by all pieces that are matched with it, so that many do not sharpen it.
    """
    seen, known = walls
    corners = pairs.corners[pairs.is_new]
    if len(pairs.lines) + len(corners) == 0:
        return mean, covariance
    at = mean
    for _ in range(ITERATIONS if len(corners) else 1):
        linear = _joined(
            _of_lines(at, seen.lines, known.lines, pairs.lines),
            _of_corners(at, seen.corners, known.corners, corners),
        )
        noise = linear.noise / seen.newness
        H = linear.jacobian
        gain = np.linalg.solve(H @ covariance @ H.T + noise, H @ covariance).T
        from_here = mean - at
        from_here[2] = wrap(float(from_here[2]))
        at = mean + gain @ (linear.innovation - H @ from_here)
        at[2] = wrap(float(at[2]))
    kept = np.eye(3) - gain @ H
    joseph = kept @ covariance @ kept.T + gain @ noise @ gain.T
    return at, (joseph + joseph.T) / 2.0


def _of_lines(at: Array, seen: Lines, known: Lines, pairs: NDArray[np.int64]) -> Linear:
    """Return what pairs of lines (k, 2) say about a pose (3,)."""
    ours, theirs = pairs.T
    (alpha, rho), count = known.polar[theirs].T, len(pairs)
    cos, sin = np.cos(alpha), np.sin(alpha)
    innovation = np.empty((count, 2))
    innovation[:, 0] = wrap(seen.polar[ours, 0] - alpha + at[2])
    innovation[:, 1] = seen.polar[ours, 1] - rho + at[0] * cos + at[1] * sin
    jacobian = np.zeros((count, 2, 3))
    jacobian[:, 0, 2] = -1.0
    jacobian[:, 1, 0], jacobian[:, 1, 1] = -cos, -sin
    shift = np.zeros((count, 2, 2))
    shift[:, 0, 0] = shift[:, 1, 1] = 1.0
    shift[:, 1, 0] = at[0] * sin - at[1] * cos
    of_map = shift @ known.covariances[theirs] @ shift.transpose(0, 2, 1)
    return _linear(innovation, jacobian, _noise(seen.covariances[ours], of_map, theirs))


def _of_corners(at: Array, seen: Corners, known: Corners, pairs: NDArray[np.int64]) -> Linear:
    """Return what pairs of corners (k, 2) say about a pose (3,)."""
    ours, theirs = pairs.T
    cos, sin = np.cos(at[2]), np.sin(at[2])
    base_from_map = np.array([[cos, sin], [-sin, cos]])
    expected = (known.poses[theirs, :2] - at[:2]) @ base_from_map.T
    jacobian = np.zeros((len(pairs), 2, 3))
    jacobian[:, :, :2] = -base_from_map
    jacobian[:, 0, 2], jacobian[:, 1, 2] = expected[:, 1], -expected[:, 0]
    of_map = base_from_map @ known.covariances[theirs] @ base_from_map.T
    noise = _noise(seen.covariances[ours], of_map, theirs)
    return _linear(seen.poses[ours, :2] - expected, jacobian, noise)


def _noise(of_seen: Array, of_known: Array, which: NDArray[np.int64]) -> Array:
    """Return the noise (2k, 2k) of k pairs, shared where `which` (k,) of the map is the same."""
    count = len(which)
    is_same = (which[:, None] == which[None]).astype(float)
    noise = is_same[:, None, :, None] * of_known[:, :, None, :]
    noise += np.eye(count)[:, None, :, None] * of_seen[:, :, None, :]
    joint: Array = noise.reshape(2 * count, 2 * count)
    return joint


def _linear(innovation: Array, jacobian: Array, noise: Array) -> Linear:
    return Linear(innovation.reshape(-1), jacobian.reshape(-1, 3), noise)


def _joined(one: Linear, other: Linear) -> Linear:
    """Return what both say, each with noise of its own."""
    count = len(one.innovation)
    noise = np.zeros((count + len(other.innovation),) * 2)
    noise[:count, :count], noise[count:, count:] = one.noise, other.noise
    return Linear(
        np.concatenate([one.innovation, other.innovation]),
        np.concatenate([one.jacobian, other.jacobian]),
        noise,
    )
