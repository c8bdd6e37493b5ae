"""What every way of localizing offers, so that service, commands and messages can use any.

`markov` keeps the exact belief over a grid of poses (MarkovLocalizer), `mcl` a set of particles
(ParticleLocalizer), `ekf` one Gaussian that follows the walls (EkfLocalizer) and finds no start.
"""

from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.localizer.estimate import Estimate, Memory
from pilotage.localizer.measurement import Measurement
from pilotage.localizer.range_model import RangeTable

MethodName = Literal["markov", "mcl", "ekf"]


class Belief(Protocol):
    """A distribution over poses, as far as it can be shown."""

    @property
    def geometry(self) -> GridGeometry:
        """The cells of `marginal`."""
        ...

    def heaviest(self, most: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return at most about `most` poses (n, 3) and their shares (n,) of the whole belief."""
        ...

    def marginal(self) -> NDArray[np.float32]:
        """Return the share (rows, cols) of the belief in each cell, whatever the heading."""
        ...

    def entropy(self) -> float:
        """Return H = -sum Bel log2 Bel in bits (Liu et al. 2008, eq. 5)."""
        ...


class MethodParams(Protocol):
    """What is asked of the parameters of any method."""

    @property
    def beams(self) -> int:
        """How many beams of a scan weigh the belief."""
        ...


class LocalizationMethod(Protocol):
    """A localizer over one map: measurements with their stamps and odometry in, estimates out."""

    @property
    def estimate(self) -> Estimate:
        """What was last said."""
        ...

    @property
    def name(self) -> MethodName:
        """The name of the method."""
        ...

    @property
    def world(self) -> OccupancyMap:
        """The map."""
        ...

    @property
    def params(self) -> MethodParams:
        """The parameters it was made with."""
        ...

    @property
    def belief(self) -> Belief:
        """What is believed now."""
        ...

    @property
    def sight(self) -> RangeTable | None:
        """The map's table of optimistic ranges, which takes longest to make; None if unused."""
        ...

    def start_anywhere(self) -> None:
        """Forget everything: the robot may be in any free place."""
        ...

    def start_at(self, map_from_base: ArrayLike, covariance: NDArray[np.float64]) -> None:
        """Begin near a pose (3,); ValueError if it is not in free space."""
        ...

    def resume(self, memory: Memory) -> None:
        """Go on from what an earlier run remembered."""
        ...

    def remember(self) -> Memory | None:
        """Return what `resume` needs, or None before the first measurement."""
        ...

    def restart_odometry(self) -> None:
        """Odometry counts from a new origin; the belief stays where it is."""
        ...

    def wants(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], measurement: Measurement
    ) -> bool:
        """Say whether a measurement tells more than the last one did."""
        ...

    def update(
        self, stamp_ns: int, odom_from_base: NDArray[np.float64], measurement: Measurement
    ) -> Estimate:
        """Predict up to `odom_from_base` (3,), correct by the measurement, judge the belief."""
        ...

    def pose_at(self, odom_from_base: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last estimated pose (3,) moved on by odometry since."""
        ...

    def choose_algorithm(self, algorithm: Literal["m1", "m2"], recovery_weight: float) -> None:
        """Recover from a kidnapping (m2) or believe in nothing but the past (m1)."""
        ...
