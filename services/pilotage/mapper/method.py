"""What every way of mapping offers, so that service and commands can use any.

`laser` matches scans into a graph of poses (LaserSlam), `sonar` corrects dead reckoning and draws a
grid from the cones of a sonar ring (SonarMapping, Li 2008).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import OccupancyMap
from pilotage.core.logs import Record


@dataclass(frozen=True, eq=False)
class MappingStep:
    """Where the robot is after a measurement that changed the map.

    `covariance` (3, 3) over x, y, theta of the map frame; `redrawn` says that poses of the past
    moved, so that the whole map was drawn anew.
    """

    stamp: float
    map_from_base: NDArray[np.float64]
    covariance: NDArray[np.float64]
    redrawn: bool = False


@dataclass(frozen=True, eq=False)
class PoseGraph:
    """Poses and what is known of them pairwise, as a file or a page shows it.

    `poses` (n, 3) in the map with `stamps` (n,) in s; `edges` (m, 2) name the poses that a
    measurement of `relative` (m, 3), the second seen from the first, with `information` (m, 3, 3)
    ties together; `is_closure` (m,) marks loops.
    """

    stamps: NDArray[np.float64]
    poses: NDArray[np.float64]
    edges: NDArray[np.int64]
    relative: NDArray[np.float64]
    information: NDArray[np.float64]
    is_closure: NDArray[np.bool_]


class MappingMethod(Protocol):
    """Measurements in the order of their stamps in, a map and the robot's way out."""

    @property
    def name(self) -> str:
        """The name of the method, as `--sensor` takes it."""
        ...

    def process(self, record: Record) -> MappingStep | None:
        """Take in a measurement; return a step if it moved the pose by more than odometry."""
        ...

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last pose (3,) in the map, moved on by odometry since."""
        ...

    def settle(self) -> None:
        """Work off what waits for more measurements: there will be none before the map is used."""
        ...

    def map(self) -> OccupancyMap:
        """Return the map as it is now: unknown cells stay unknown."""
        ...

    def trajectory(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return stamps (n,) in s and poses (n, 3) in the map, at the rate of the odometry."""
        ...

    def pose_graph(self) -> PoseGraph:
        """Return the poses that the map is drawn from; empty edges where there is no graph."""
        ...

    def remember(self) -> dict[str, NDArray[np.generic]]:
        """Return all that `resume` needs, as arrays by name."""
        ...

    def resume(self, memory: dict[str, NDArray[np.generic]]) -> None:
        """Go on from what an earlier run remembered; ValueError if it does not fit."""
        ...
