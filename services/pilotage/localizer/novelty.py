"""How new what a beam sees is: the same wall, seen again, says nothing new about the place.

Neighbouring scans see the same walls and the same unmapped furniture. Were each counted
afresh, a chair would speak against the right room with every scan, and of two like rooms one
would win by small errors of the map, repeated. So each piece of surface counts by
1 / (1 + how often it was seen already)^2, by where odometry puts it.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.localizer.measurement import Beams

PIECE = 0.25
"""Side of a piece of surface [m]."""

SILENT_RANGE = 3.0
"""A beam without a return is known by where it points: its end is put here [m]."""

REMEMBERED = 60
"""Scans after which a surface counts as new again: odometry has drifted."""

Key = tuple[int, int, bool]


class SeenSurfaces:
    """Which pieces of surface the last scans saw, in the odometry frame."""

    def __init__(self) -> None:
        self._scans: deque[set[Key]] = deque()
        self._seen: dict[Key, int] = {}

    def novelty(self, odom_from_base: NDArray[np.float64], beams: Beams) -> NDArray[np.float64]:
        """Return how new (n,) each beam of a scan is, 0 to 1."""
        counts = [self._seen.get(key, 0) for key in _pieces(odom_from_base, beams)]
        novelty = 1.0 / (1.0 + np.array(counts, float)) ** 2
        silent = ~np.isfinite(beams.ranges)
        if not silent.all():
            novelty[silent] = novelty[~silent].mean()
        return novelty

    def keep(self, odom_from_base: NDArray[np.float64], beams: Beams) -> None:
        """Take a scan's surfaces as seen once more."""
        pieces = set(_pieces(odom_from_base, beams))
        self._scans.append(pieces)
        for key in pieces:
            self._seen[key] = self._seen.get(key, 0) + 1
        if len(self._scans) > REMEMBERED:
            self._forget(self._scans.popleft())

    def _forget(self, pieces: set[Key]) -> None:
        for key in pieces:
            left = self._seen.pop(key) - 1
            if left:
                self._seen[key] = left


def _pieces(odom_from_base: NDArray[np.float64], beams: Beams) -> list[Key]:
    silent = ~np.isfinite(beams.ranges)
    ranges = np.where(silent, SILENT_RANGE, beams.ranges)
    ends = np.stack([ranges * np.cos(beams.bearings), ranges * np.sin(beams.bearings)], axis=1)
    odom_from_laser = se2.compose(odom_from_base, beams.base_from_laser)
    cells = np.floor(se2.transform_points(odom_from_laser, ends) / PIECE).astype(int)
    return list(zip(cells[:, 0].tolist(), cells[:, 1].tolist(), silent.tolist(), strict=True))
