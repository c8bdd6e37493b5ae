"""What a sensor is expected to tell, whatever it is: landmarks that it knows or walls; pure."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.laser_view import View
from pilotage.planner.expected_scans import ExpectedScans, SightParams
from pilotage.planner.information import LogLikelihoods
from pilotage.planner.map_potential import MapPotential, map_potential

Window = tuple[float, float]
"""Where a sensor points, off the robot's heading, and half of its field of view [rad]."""
FULL_TURN: Window = (0.0, float(np.pi))


class Potential(Protocol):
    """Where on the map much is to be told: `bits` (rows, cols) on `geometry`."""

    @property
    def geometry(self) -> GridGeometry:
        """The cells."""
        ...

    @property
    def bits(self) -> NDArray[np.float32]:
        """The environment potential of each cell."""
        ...

    def bits_at(self, points_map: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return it at points (n, 2) of the map frame, zero off the map."""
        ...

    def maxima(self) -> NDArray[np.float64]:
        """Return the places (k, 2), map frame, where it is highest; the highest first."""
        ...


class Sight(Protocol):
    """A sensor on a map."""

    @property
    def potential(self) -> Potential:
        """Where it is worth looking from."""
        ...

    @property
    def pointings(self) -> NDArray[np.float64]:
        """Where it can be pointed, off the robot's heading (k,) [rad]; none if it is fixed."""
        ...

    def window(self, view: View) -> Window:
        """Return what is seen without a turn or a pan, given what the laser sees."""
        ...

    def log_likelihoods(
        self, poses: NDArray[np.float64], truths: NDArray[np.int64], window: Window
    ) -> LogLikelihoods:
        """Return (m, n): how well what is expected at pose truths[i] fits each of n poses.

        Only what is seen through the window counts.
        """
        ...


class ScanSight:
    """A laser, and the walls of a map."""

    def __init__(self, world: OccupancyMap, params: SightParams, radius: float) -> None:
        self._scans = ExpectedScans(world, params)
        self._potential = map_potential(world, self._scans, radius)

    @property
    def potential(self) -> MapPotential:
        """How rare the look of each place is."""
        return self._potential

    @property
    def pointings(self) -> NDArray[np.float64]:
        """A laser is fixed."""
        return np.zeros(0)

    def window(self, view: View) -> Window:
        """Return the middle of the angle that the laser covers, and half of it."""
        if len(view.bearings) == 0:
            return 0.0, 0.0
        # All but the widest gap: bearings wrap where a laser looks all round, or backwards.
        angles = np.sort(view.bearings)
        gaps = np.diff(angles, append=angles[0] + 2.0 * np.pi)
        widest = int(np.argmax(gaps))
        half = float(np.pi - 0.5 * gaps[widest])
        return float(wrap(angles[(widest + 1) % len(angles)] + half)), half

    def log_likelihoods(
        self, poses: NDArray[np.float64], truths: NDArray[np.int64], window: Window
    ) -> LogLikelihoods:
        """Compare the scans, as far as they lie in the window."""
        scans = self._scans.at(poses, window)
        return self._scans.log_likelihoods(scans, truths)
