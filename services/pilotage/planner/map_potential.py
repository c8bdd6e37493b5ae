"""How much the look of a place says, in a building without landmarks; pure.

Liu et al. 2008 let landmarks make the environment potential: high is where one sees much that is
seen from few places. A map makes one too. A place looks by the ranges all round it; whichever
way the robot points, the magnitudes of their Fourier terms stay. The potential of a place is the
information in bits of meeting that look among all places of the building: rare corners, openings
and asymmetries stand out, corridors and alike rooms do not.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.grid import GridGeometry, OccupancyMap
from pilotage.core.jit import kernel, reduction
from pilotage.planner.common_ground import Clearance
from pilotage.planner.expected_scans import ExpectedScans

RESOLUTION = 0.5
"""m between places that are compared."""
TERMS = 10
"""Fourier terms of a look."""
WIDTH = 0.35
"""m: looks whose ranges differ by less (root mean square) are alike."""
MOST = 6000
"""Places that one is compared with: drawn evenly where a building has more."""


@dataclass(frozen=True)
class MapPotential:
    """The environment potential: `bits` (rows, cols) on `geometry`, zero where nobody can stand."""

    geometry: GridGeometry
    bits: NDArray[np.float32]

    def bits_at(self, points_map: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return it at points (n, 2) of the map frame, zero off the map."""
        return bits_at(self.geometry, self.bits, points_map)

    def maxima(self) -> NDArray[np.float64]:
        """Return the places (n, 2), map frame, that no neighbour tops; the richest first."""
        padded = np.pad(self.bits, 1)
        rows, cols = self.bits.shape
        around = [
            padded[r : r + rows, c : c + cols]
            for r in range(3)
            for c in range(3)
            if (r, c) != (1, 1)
        ]
        tops = np.argwhere((self.bits > 0.0) & (self.bits >= np.max(around, axis=0)))
        order = np.argsort(-self.bits[tops[:, 0], tops[:, 1]], kind="stable")
        return self.geometry.centres_of(tops[order])


def bits_at(
    geometry: GridGeometry, bits: NDArray[np.float32], points_map: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the cells' values (rows, cols) at points (n, 2) of the map frame, zero outside."""
    cells = geometry.cells_of(points_map)
    inside = geometry.contains(cells)
    found = np.zeros(len(cells))
    found[inside] = bits[cells[inside, 0], cells[inside, 1]]
    return found


def map_potential(world: OccupancyMap, scans: ExpectedScans, radius: float) -> MapPotential:
    """Return the potential of a map for a robot of this body radius [m]."""
    geometry = _coarse(world.geometry)
    clearance = Clearance(world)
    centres = geometry.centres_of(np.argwhere(np.ones(geometry.shape, bool)))
    cells = np.clip(world.geometry.cells_of(centres), 0, np.array(world.geometry.shape) - 1)
    stands = np.flatnonzero(clearance.metres[cells[:, 0], cells[:, 1]] > radius)
    bits = np.zeros(len(centres), np.float32)
    if len(stands):
        poses = np.column_stack([centres[stands], np.zeros(len(stands))])
        looks = _looks(scans.at(poses))
        others = looks[:: -(-len(looks) // MOST)]
        bits[stands] = _information(looks, np.ascontiguousarray(others), WIDTH)
    return MapPotential(geometry, bits.reshape(geometry.shape))


def _coarse(fine: GridGeometry) -> GridGeometry:
    ratio = max(1, round(RESOLUTION / fine.resolution))
    rows, cols = -(-fine.rows // ratio), -(-fine.cols // ratio)
    return GridGeometry(rows, cols, ratio * fine.resolution, fine.origin)


def _looks(scans: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return what does not turn with the robot (n, terms) of scans (beams, n), in m."""
    terms = np.abs(np.fft.rfft(scans, axis=0)[:TERMS]) / len(scans)
    terms[1:] *= np.sqrt(2.0)
    return np.ascontiguousarray(terms.T, np.float32)


@kernel
def _information(
    looks: NDArray[np.float32], others: NDArray[np.float32], width: float
) -> NDArray[np.float32]:
    """Return -log2 of the share of the others (m, terms) that look like each of (n, terms)."""
    bits = np.empty(len(looks), np.float32)
    for i in range(len(looks)):
        alike = 1.0
        for other in others:
            alike += np.exp(-_squared(looks[i], other) / (2.0 * width * width))
        bits[i] = np.log2((len(others) + 1.0) / alike)
    return bits


@reduction
def _squared(one: NDArray[np.float32], other: NDArray[np.float32]) -> float:
    total = np.float32(0.0)
    for k in range(len(one)):
        total += (one[k] - other[k]) ** 2
    return float(total)


def warm_up() -> None:
    """Compile the kernels."""
    looks = np.zeros((1, 1), np.float32)
    _information(looks, looks, 1.0)
