"""What an ideal laser at the origin measures among straight walls and round people."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2
from pilotage.core.scans import bearings_of

Wall = tuple[tuple[float, float], tuple[float, float]]
Disc = tuple[float, float, float]
"""x, y and radius, m."""

FULL_TURN = (-np.pi, float(np.deg2rad(0.5)))
"""First bearing and step of a laser that looks all about; it has 720 beams."""
AHEAD = (-np.pi / 2.0, float(np.deg2rad(0.5)))
"""The same of a laser with 361 beams over half a turn."""


def room(width: float, height: float) -> list[Wall]:
    """Return the walls of a room whose lower left corner is the origin, counter-clockwise."""
    corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    return [(corners[i], corners[(i + 1) % 4]) for i in range(4)]


def seen_from(pose: ArrayLike, walls: Sequence[Wall]) -> NDArray[np.float64]:
    """Return the ends (n, 2, 2) of walls in the frame of a laser at a pose (3,)."""
    points = np.asarray(walls, float).reshape(-1, 2)
    return se2.transform_points(se2.inverse(pose), points).reshape(-1, 2, 2)


def scan_of(
    walls: ArrayLike,
    angles: tuple[float, float] = FULL_TURN,
    discs: Sequence[Disc] = (),
    beams: int | None = None,
) -> NDArray[np.float64]:
    """Return the ranges (beams,) to walls (n, 2, 2) and discs, infinite where nothing is met.

    A laser of half a turn has 361 beams, one of a full turn 720, unless said otherwise.
    """
    count = beams or (361 if angles[0] == AHEAD[0] else 720)
    bearings = bearings_of(count, *angles)
    ways = np.column_stack([np.cos(bearings), np.sin(bearings)])
    ranges = np.full(count, np.inf)
    for first, second in np.asarray(walls, float).reshape(-1, 2, 2):
        ranges = np.minimum(ranges, _to_wall(ways, first, second - first))
    for x, y, radius in discs:
        ranges = np.minimum(ranges, _to_disc(ways, np.array([x, y]), radius))
    return ranges


def _to_wall(
    ways: NDArray[np.float64], first: NDArray[np.float64], along: NDArray[np.float64]
) -> NDArray[np.float64]:
    across = ways[:, 0] * along[1] - ways[:, 1] * along[0]
    across = np.where(np.abs(across) < 1e-12, np.nan, across)
    far = (first[0] * along[1] - first[1] * along[0]) / across
    share = (first[0] * ways[:, 1] - first[1] * ways[:, 0]) / across
    return np.where((far > 0.0) & (share >= 0.0) & (share <= 1.0), far, np.inf)


def _to_disc(
    ways: NDArray[np.float64], centre: NDArray[np.float64], radius: float
) -> NDArray[np.float64]:
    ahead = ways @ centre
    inside = radius**2 - (centre @ centre - ahead**2)
    return np.where((inside > 0.0) & (ahead > 0.0), ahead - np.sqrt(np.maximum(inside, 0)), np.inf)
