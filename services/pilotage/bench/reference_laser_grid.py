"""The laser's grid in plain numpy: log-odds along exact rays, a beam at a time, no compiled code.

The twin that the product is measured against (and, in the tests, compared with). It draws what
every such grid draws and no more: nothing waits until it lasted, grazing beams count in full, the
grid does not grow. All that is in its favour.
"""

import numpy as np
from numpy.typing import NDArray

HIT, MISS, LIMIT = 0.85, 0.3, 2.5


class PlainLaserGrid:
    """Log-odds (rows, cols) of cells of `resolution` m, the first one's corner at `corner` (2,)."""

    def __init__(
        self, shape: tuple[int, int], resolution: float, corner: NDArray[np.float64]
    ) -> None:
        self.log_odds = np.full(shape, np.nan)
        self._resolution, self._corner = resolution, corner

    def insert(
        self,
        origin: NDArray[np.float64],
        ends: NDArray[np.float64],
        is_hit: NDArray[np.bool_],
    ) -> None:
        """Draw a scan: a cell learns once, and a hit counts more than what passes."""
        start, stops = (self._in_cells(points) for points in (origin, ends))
        hit = np.zeros(self.log_odds.shape, bool)
        passed = np.zeros_like(hit)
        for stop in stops:
            passed[crossed_cells(start, stop)] = True
        cells = np.floor(stops[is_hit]).astype(np.int64)
        hit[cells[:, 1], cells[:, 0]] = True
        passed &= ~hit
        self.log_odds[np.isnan(self.log_odds) & (hit | passed)] = 0.0
        self.log_odds[hit] = np.minimum(self.log_odds[hit] + HIT, LIMIT)
        self.log_odds[passed] = np.maximum(self.log_odds[passed] - MISS, -LIMIT)

    def _in_cells(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (..., 2) in cells from the corner."""
        return (points - self._corner) / self._resolution


def crossed_cells(
    start: NDArray[np.float64], stop: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return rows and cols of the cells between two points (2,), given in cells.

    A cell lies between two crossings of the raster's lines, so it holds the middle of the two.
    """
    shares = [np.array([0.0, 1.0])]
    for a, b in zip(start, stop, strict=True):
        lines = np.arange(np.floor(min(a, b)) + 1.0, np.ceil(max(a, b)))
        if len(lines):
            shares.append((lines - a) / (b - a))
    crossings = np.sort(np.concatenate(shares))
    middles = (crossings[:-1] + crossings[1:]) / 2.0
    cells = np.floor(start + middles[:, None] * (stop - start)).astype(np.int64)
    return cells[:, 1], cells[:, 0]
