"""What one measurement says of states, wherever these are kept: in the belief or in its rest."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pilotage.localizer import kernels
from pilotage.localizer.kernels import Area, Prior, Scan, Tiles


class StateLikelihood(Protocol):
    """A likelihood, at most 1, of each state of a belief (headings, rows, cols).

    Tiles as in `rest`; chosen ones (n, 3) as layer, tile row, tile column; `mask` (rows, cols) is
    1 where the robot may stand.
    """

    def weigh(self, belief: NDArray[np.float32], area: Area) -> None:
        """Multiply what the area holds by the likelihood."""
        ...

    def take_back(self, belief: NDArray[np.float32], area: Area) -> None:
        """Divide what the area holds by the likelihood."""
        ...

    def best_fits(
        self, tiles: Tiles, chosen: NDArray[np.int64], mask: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """Return the likelihood (n,) of the best state in each of the chosen tiles."""
        ...

    def wake(
        self,
        belief: NDArray[np.float32],
        tiles: Tiles,
        chosen: NDArray[np.int64],
        mask: NDArray[np.float32],
    ) -> None:
        """Give the chosen tiles' masses to their states, evenly, and weigh these."""
        ...


class TileLikelihood(StateLikelihood, Protocol):
    """One that bounds itself by tiles."""

    def bounds(self, tiles: Tiles) -> NDArray[np.float32]:
        """Return, in the shape of the masses, what no state of each tile can exceed."""
        ...


@dataclass(frozen=True)
class ScanLikelihood:
    """A laser scan's likelihood; its bounds by tiles come with the prior (`Rest.weigh`)."""

    scan: Scan

    def weigh(self, belief: NDArray[np.float32], area: Area) -> None:
        """See StateLikelihood."""
        unchanged = Prior(1.0, 0.0, np.ones(len(belief), np.float32))
        kernels.weigh_scan(belief, area, unchanged, self.scan)

    def take_back(self, belief: NDArray[np.float32], area: Area) -> None:
        """See StateLikelihood; what has become nothing stays so."""
        likelihood = self.scan.likelihood
        is_lost = likelihood < kernels.LEAST_FIT
        undo = np.where(is_lost, 0.0, 1.0 / np.maximum(likelihood, kernels.LEAST_FIT))
        ScanLikelihood(self.scan._replace(likelihood=undo.astype(np.float32))).weigh(belief, area)

    def best_fits(
        self, tiles: Tiles, chosen: NDArray[np.int64], mask: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """See StateLikelihood."""
        return kernels.best_fits(tiles, chosen, mask, self.scan)

    def wake(
        self,
        belief: NDArray[np.float32],
        tiles: Tiles,
        chosen: NDArray[np.int64],
        mask: NDArray[np.float32],
    ) -> None:
        """See StateLikelihood."""
        kernels.wake_tiles(belief, tiles, chosen, mask, self.scan)
