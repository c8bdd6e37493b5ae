"""Sightings of landmarks as a likelihood of the Markov grid's states, and of its tiles."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer import landmark_kernels, landmark_tile_kernels
from pilotage.localizer.kernels import Area, Tiles
from pilotage.localizer.landmark_kernels import KnownSightings
from pilotage.localizer.landmark_tile_kernels import Layers, Said


@dataclass(frozen=True)
class SightingsLikelihood:
    """P(sightings | l)^exponent, a TileLikelihood.

    `layers`: where they lie in the grid's frame, as the landmarks of `sightings`.
    """

    layers: Layers
    sightings: KnownSightings
    exponent: float

    @property
    def _said(self) -> Said:
        return self.layers, self.sightings, self.exponent

    def weigh(self, belief: NDArray[np.float32], area: Area) -> None:
        """See StateLikelihood."""
        landmark_kernels.weigh_landmarks(belief, area, self.layers, self.sightings, self.exponent)

    def take_back(self, belief: NDArray[np.float32], area: Area) -> None:
        """See StateLikelihood."""
        landmark_kernels.weigh_landmarks(belief, area, self.layers, self.sightings, -self.exponent)

    def bounds(self, tiles: Tiles) -> NDArray[np.float32]:
        """See TileLikelihood."""
        return landmark_tile_kernels.bound_tiles(tiles, self._said)

    def best_fits(
        self, tiles: Tiles, chosen: NDArray[np.int64], mask: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """See StateLikelihood."""
        return landmark_tile_kernels.best_fits(tiles, chosen, mask, self._said)

    def wake(
        self,
        belief: NDArray[np.float32],
        tiles: Tiles,
        chosen: NDArray[np.int64],
        mask: NDArray[np.float32],
    ) -> None:
        """See StateLikelihood."""
        landmark_tile_kernels.wake_tiles(belief, tiles, chosen, mask, self._said)
