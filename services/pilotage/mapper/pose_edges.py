"""What is known of two poses relative to each other, and how such knowledge is joined.

Errors are small motions of the second pose in its own frame (x, y, theta), as GTSAM has them:
the true second pose is `first . relative . error`.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2

CLOSURE_LENGTH = 0.3
"""m that a closure counts on the way between two keyframes."""
TURN_LENGTH = 0.3
"""m of way that a turn by one rad is worth: it costs as much certainty."""


@dataclass(frozen=True, eq=False)
class Edge:
    """Pose `second` seen from pose `first`: `relative` (3,) and `covariance` (3, 3) of its error.

    `is_closure`: not odometry's or the tracker's word but a place known again.
    """

    first: int
    second: int
    relative: NDArray[np.float64]
    covariance: NDArray[np.float64]
    is_closure: bool = False

    @cached_property
    def length(self) -> float:
        """The way in m along it, as far as doubt grows with the way."""
        if self.is_closure:
            return CLOSURE_LENGTH
        x, y, theta = (float(value) for value in self.relative)
        return math.hypot(x, y) + TURN_LENGTH * abs(theta)

    @property
    def ends(self) -> tuple[int, int]:
        """The poses that it ties together."""
        return self.first, self.second


def reversed_edge(edge: Edge) -> Edge:
    """Return the same knowledge told from the other end."""
    A = adjoint(edge.relative)
    covariance = A @ edge.covariance @ A.T
    back = se2.inverse(edge.relative)
    return Edge(edge.second, edge.first, back, covariance, edge.is_closure)


def joined(one: Edge, two: Edge) -> Edge:
    """Return what two edges, the second beginning where the first ends, say together."""
    A = adjoint(se2.inverse(two.relative))
    covariance = A @ one.covariance @ A.T + two.covariance
    relative = se2.compose(one.relative, two.relative)
    is_closure = one.is_closure or two.is_closure
    return Edge(one.first, two.second, relative, covariance, is_closure)


def mismatch(edge: Edge, first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """Return by how many standard deviations (Mahalanobis) two poses (3,) contradict an edge."""
    error = se2.between(edge.relative, se2.between(first, second))
    return float(np.sqrt(error @ np.linalg.solve(edge.covariance, error)))


def adjoint(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrix (3, 3) that takes a small motion in the frame of a pose to the outer one.

    `pose . motion = (adjoint motion) . pose` to first order.
    """
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[cos, -sin, pose[1]], [sin, cos, -pose[0]], [0.0, 0.0, 1.0]])


def inverted(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the information (3, 3) of a covariance, or the other way round."""
    return np.linalg.inv(matrix).astype(np.float64, copy=False)
