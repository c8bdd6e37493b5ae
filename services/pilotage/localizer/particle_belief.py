"""What a set of particles believes, gathered in bins: a single particle's weight says little.

After resampling all particles weigh the same; where they lie densely the belief is high.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.grid import GridGeometry
from pilotage.localizer.particle_resampling import bins_of

BIN_SIZE = 0.10
"""Width of a bin [m]: that of the Markov grid's cells, so that entropies can be compared."""

BIN_TURN = np.deg2rad(5.0)


@dataclass(frozen=True)
class ParticleBelief:
    """Bins that hold particles: mean `poses` (k, 3) of the map frame and shares `masses` (k,).

    `geometry`: cells to show the belief on.
    """

    poses: NDArray[np.float64]
    masses: NDArray[np.float64]
    geometry: GridGeometry

    def heaviest(self, most: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return poses (n, 3) and shares (n,) of the `most` heaviest bins."""
        if len(self.masses) <= most:
            return self.poses, self.masses
        best = np.argpartition(self.masses, -most)[-most:]
        return self.poses[best], self.masses[best]

    def marginal(self) -> NDArray[np.float32]:
        """Return the share (rows, cols) of the belief in each cell, whatever the heading."""
        cells = self.geometry.cells_of(self.poses[:, :2])
        inside = self.geometry.contains(cells)
        shares = np.zeros(self.geometry.shape)
        np.add.at(shares, tuple(cells[inside].T), self.masses[inside])
        return shares.astype(np.float32)

    def entropy(self) -> float:
        """Return H = -sum m log2 m over bins in bits; n particles cannot show more than log2 n."""
        held = self.masses[self.masses > 0.0]
        return max(0.0, -float(held @ np.log2(held)))


def particle_belief(
    poses: NDArray[np.float64], weights: NDArray[np.float64], map_geometry: GridGeometry
) -> ParticleBelief:
    """Return the belief of particles (n, 3) with weights (n,) that sum to one."""
    bins, bin_of = np.unique(bins_of(poses, BIN_SIZE, BIN_TURN), return_inverse=True)
    count = len(bins)
    masses = np.bincount(bin_of, weights, count).astype(np.float64)
    held = masses > 0.0
    share = np.divide(1.0, masses, out=np.zeros(count), where=held)
    means = np.empty((count, 3))
    for axis in (0, 1):
        means[:, axis] = share * np.bincount(bin_of, weights * poses[:, axis], count)
    # Headings of a bin lie within its width: their mean is taken about one of them.
    some = np.empty(count)
    some[bin_of] = poses[:, 2]
    off = wrap(poses[:, 2] - some[bin_of])
    means[:, 2] = wrap(some + share * np.bincount(bin_of, weights * off, count))
    return ParticleBelief(means[held], masses[held], _shown_on(map_geometry))


def _shown_on(geometry: GridGeometry) -> GridGeometry:
    """Return cells as wide as a bin (or the map's, if wider) over the same ground."""
    resolution = max(BIN_SIZE, geometry.resolution)
    cols, rows = (int(np.ceil(length / resolution - 1e-9)) for length in geometry.size_m)
    return GridGeometry(max(1, rows), max(1, cols), resolution, geometry.origin)
