"""Plain twins of the kernels that vote for poses and settle them."""

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def turn_between(seen: float, bound: float, period: float) -> float:
    """Return the shortest turn by searching it: the first of all equal turns that is shortest."""
    turns = [bound - seen + k * period for k in range(-8, 9)]
    return min(turns, key=abs)


def count_votes(
    poses: Array, places: Array, spreads: Array, members: Indices, counts: tuple[int, int]
) -> Array:
    """Return the votes (h,) with a table of all seen and bound features for each pose."""
    votes = []
    for pose in poses:
        table = np.zeros(counts)
        for place, spread, (i, j) in zip(places, spreads, members, strict=True):
            off = _in_map(pose, place) - place[3:5]
            turn = turn_between(place[2] + pose[2], place[5], place[6])
            worth = 1.0 - float(off @ off) / spread[0] - turn**2 / spread[1]
            table[i, j] = max(table[i, j], worth, 0.0)
        votes.append(min(table.max(axis=1).sum(), table.max(axis=0).sum()))
    return np.array(votes)


def pair_distances(
    pose: Array, places: Array, covariances: Array, direction_variance: float
) -> Array:
    """Return the squared Mahalanobis distances (p,) with matrices."""
    rotation = _rotation(pose[2])
    distances = []
    for place, (seen, bound) in zip(places, covariances, strict=True):
        off = place[3:5] - _in_map(pose, place)
        spread = rotation @ seen @ rotation.T + bound
        turn = turn_between(place[2] + pose[2], place[5], place[6])
        distances.append(off @ np.linalg.inv(spread) @ off + turn**2 / direction_variance)
    return np.array(distances)


def step(pose: Array, places: Array, covariances: Array, direction_variance: float) -> Array:
    """Return the pose after one step of least squares, whitened and solved at once.

    The Jacobian is numerical.
    """

    def whitened(at: Array) -> Array:
        rows: list[float] = []
        for place, (seen, bound) in zip(places, covariances, strict=True):
            # The weights stay those of the pose that the step begins at.
            rotation = _rotation(pose[2])
            root = np.linalg.cholesky(np.linalg.inv(rotation @ seen @ rotation.T + bound))
            rows.extend(root.T @ (place[3:5] - _in_map(at, place)))
            turn = turn_between(place[2] + at[2], place[5], place[6])
            rows.append(turn / math.sqrt(direction_variance))
        return np.array(rows)

    size = 1e-6
    columns = [
        (whitened(pose + size * axis) - whitened(pose - size * axis)) / (2.0 * size)
        for axis in np.eye(3)
    ]
    moved = np.linalg.lstsq(np.stack(columns, axis=1), -whitened(pose), rcond=None)[0]
    stepped: Array = pose + moved
    return stepped


def _rotation(theta: float) -> Array:
    cos, sin = math.cos(theta), math.sin(theta)
    return np.array([[cos, -sin], [sin, cos]])


def _in_map(pose: Array, place: Array) -> Array:
    moved: Array = pose[:2] + _rotation(pose[2]) @ place[:2]
    return moved
