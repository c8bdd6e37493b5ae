"""Straight pieces of wall, whether a laser saw them or a map shows them.

A line is known by its normal form `cos(alpha) x + sin(alpha) y = rho`. The normal points from the
wall into the free space that it was seen from, so `rho` has a sign and the two faces of a thin
wall are two lines; walking from the first end to the second, free space lies on the left.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap


@dataclass(frozen=True)
class Lines:
    """Pieces of wall in one frame.

    `ends` (n, 2, 2): first and second end, x and y, m. `polar` (n, 2): alpha in rad, in
    [-pi, pi), and rho in m. `covariances` (n, 2, 2) of alpha and rho.
    """

    ends: NDArray[np.float64]
    polar: NDArray[np.float64]
    covariances: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.polar)

    @classmethod
    def none(cls) -> "Lines":
        """Return no lines."""
        return cls(np.empty((0, 2, 2)), np.empty((0, 2)), np.empty((0, 2, 2)))

    @property
    def lengths(self) -> NDArray[np.float64]:
        """How long they are (n,), m."""
        length: NDArray[np.float64] = np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T)
        return length

    def chosen(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> "Lines":
        """Return those that a mask (n,) or indices (k,) choose."""
        return Lines(self.ends[which], self.polar[which], self.covariances[which])

    def moved(self, outer_from_inner: ArrayLike) -> "Lines":
        """Return the same lines in the outer frame of a pose (3,) that is known exactly."""
        x, y, theta = np.asarray(outer_from_inner, float)
        alpha = np.asarray(wrap(self.polar[:, 0] + theta))
        slope = -x * np.sin(alpha) + y * np.cos(alpha)
        rho = self.polar[:, 1] + x * np.cos(alpha) + y * np.sin(alpha)
        jacobian = np.zeros((len(self), 2, 2))
        jacobian[:, 0, 0] = jacobian[:, 1, 1] = 1.0
        jacobian[:, 1, 0] = slope
        ends = se2.transform_points(outer_from_inner, self.ends.reshape(-1, 2)).reshape(-1, 2, 2)
        covariances = jacobian @ self.covariances @ jacobian.transpose(0, 2, 1)
        return Lines(ends, np.stack([alpha, rho], axis=1), covariances)
