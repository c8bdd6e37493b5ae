"""A path as a line that one goes along; pure."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Track:
    """Straight pieces between `corners` (n, 2), n >= 2, in m."""

    corners: NDArray[np.float64]

    @cached_property
    def ways(self) -> NDArray[np.float64]:
        """How far along each corner (n,) lies, m."""
        pieces = np.hypot(*np.diff(self.corners, axis=0).T)
        return np.concatenate([[0.0], np.cumsum(pieces)])

    @property
    def length(self) -> float:
        """Length in m."""
        return float(self.ways[-1])

    def at(self, ways: ArrayLike) -> NDArray[np.float64]:
        """Return the points (m, 2) so far (m,) along; before and beyond the ends: the ends."""
        along = np.atleast_1d(np.asarray(ways, float))
        x, y = (np.interp(along, self.ways, self.corners[:, axis]) for axis in (0, 1))
        return np.stack([x, y], axis=1)

    def nearest(self, point: ArrayLike, begin: float, end: float) -> tuple[float, float]:
        """Return how far along the nearest point to `point` (2,) lies, and its distance, m.

        Only the part from `begin` to `end` m along is looked at: a path may come by twice.
        """
        inside = self.ways[(self.ways > begin) & (self.ways < end)]
        ways = np.concatenate([[max(begin, 0.0)], inside, [min(end, self.length)]])
        ends = self.at(ways)
        starts, steps = ends[:-1], np.diff(ends, axis=0)
        squares = np.maximum((steps**2).sum(axis=1), 1e-12)
        offsets = np.asarray(point, float) - starts
        shares = np.clip((offsets * steps).sum(axis=1) / squares, 0.0, 1.0)
        distances = np.hypot(*(offsets - shares[:, None] * steps).T)
        best = int(np.argmin(distances))
        way = ways[best] + shares[best] * (ways[best + 1] - ways[best])
        return float(way), float(distances[best])


def distances_to_line(
    points: NDArray[np.float64], start: ArrayLike, end: ArrayLike
) -> NDArray[np.float64]:
    """Return how far (n,) in m points (n, 2) lie from the line between two points (2,)."""
    a = np.asarray(start, float)
    step = np.asarray(end, float) - a
    square = max(float(step @ step), 1e-12)
    shares = np.clip((points - a) @ step / square, 0.0, 1.0)
    distances: NDArray[np.float64] = np.hypot(*(points - a - shares[:, None] * step).T)
    return distances
