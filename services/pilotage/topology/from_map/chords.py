"""Chords across the free space of a map: the narrow places where a door or a passage may be.

A chord joins two walls that are nearest to the same free cell from opposite sides. It lies in an
opening where the space widens beyond it, on one side at least (Thrun 1998 looks for the least
clearance along the Voronoi diagram; that finds doors, but no mouth of an even corridor).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.topology.from_map.space import Space


@dataclass(frozen=True)
class ChordParams:
    """Which chords are openings."""

    widest: float = 4.0
    """m between the walls."""
    narrowest: float = 0.55
    """m: nothing drives through less."""
    opposite: float = float(np.deg2rad(140.0))
    """Angle between the directions to both walls, rad, at least."""
    reach: float = 0.8
    """m beyond half the chord's length in which the space has to widen."""
    widening: float = 1.4
    """To so many times its width."""
    askew: float = 0.5
    """m to the side per m ahead: so it looks aside from a door in a corner, where the space does
    not widen straight ahead,"""
    widest_in_corner: float = 1.25
    """if it is no wider than this, m, and if the space then widens on both sides of it."""
    apart: float = 0.5
    """m from a better chord that a worse one must keep, or three quarters of the shorter one."""


@dataclass(frozen=True)
class Chords:
    """Chords across a space.

    `ends` (n, 2, 2) in map, on the walls' faces. `widening` (n, 2): to how many times its width
    the space widens on either side, to the left first.
    """

    ends: NDArray[np.float64]
    widening: NDArray[np.float64]

    @property
    def salience(self) -> NDArray[np.float64]:
        """How much (n,) a chord stands out as narrow."""
        return np.asarray(self.widening.prod(axis=1))

    @property
    def framing(self) -> NDArray[np.float64]:
        """How much (n,) the space widens on the side where it widens less."""
        return np.asarray(self.widening.min(axis=1, initial=np.inf))

    @property
    def widths(self) -> NDArray[np.float64]:
        """Lengths (n,), m."""
        return np.asarray(np.hypot(*(self.ends[:, 1] - self.ends[:, 0]).T))

    @property
    def middles(self) -> NDArray[np.float64]:
        """Points (n, 2) half way."""
        return np.asarray(self.ends.mean(axis=1))

    @property
    def along(self) -> NDArray[np.float64]:
        """Unit vectors (n, 2) from the first end to the second."""
        step = self.ends[:, 1] - self.ends[:, 0]
        return np.asarray(step / np.maximum(np.hypot(*step.T), 1e-9)[:, None])

    @property
    def across(self) -> NDArray[np.float64]:
        """Unit vectors (n, 2) of walking through, to the left of `along`."""
        return np.stack([-self.along[:, 1], self.along[:, 0]], axis=1)

    def chosen(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> "Chords":
        """Return those that a mask (n,) or indices (k,) choose."""
        return Chords(self.ends[which], self.widening[which])


def find_chords(space: Space, params: ChordParams) -> Chords:
    """Return the chords of a space that may be openings, the most salient first."""
    walls = _opposite_walls(space, params)
    widening = _widening(space, walls, params)
    is_open = (widening.max(axis=1) > params.widening) & (widening.min(axis=1) > 0.9)
    chords = Chords(_ends_in_map(space, walls[is_open]), widening[is_open])
    return _thinned(chords, params.apart)


def medial_cells(space: Space, least: float) -> NDArray[np.int64]:
    """Return the cells half way between walls, `least` m and more from them, and both walls.

    As (n, 6): row and col of the cell, of the nearest wall and of the one opposite.
    """
    limits = np.array([least / space.resolution, np.inf, np.cos(np.deg2rad(110.0))])
    return opposite_walls(space.is_free, space.nearest, limits)


def _opposite_walls(space: Space, params: ChordParams) -> NDArray[np.int64]:
    """Return pairs of wall cells (n, 4) that face each other across a narrow place."""
    narrowest, widest = params.narrowest / space.resolution, params.widest / space.resolution
    limits = np.array([narrowest / 2.0, widest / 2.0 + 1.0, np.cos(params.opposite)])
    pairs = opposite_walls(space.is_free, space.nearest, limits)[:, 2:]
    # The walls' faces are half a cell before their centres, at both ends.
    width = np.hypot(pairs[:, 2] - pairs[:, 0], pairs[:, 3] - pairs[:, 1]) - 1.0
    fits = (width >= narrowest) & (width <= widest)
    return np.asarray(np.unique(pairs[fits], axis=0))


def _widening(space: Space, walls: NDArray[np.int64], params: ChordParams) -> NDArray[np.float64]:
    """Return how many times as wide the space gets on either side (n, 2), straight ahead.

    Doors in a corner of both their rooms get just as much as it takes.
    """
    scale = np.array([params.reach / space.resolution, space.resolution])
    ahead = widenings(space.clearance, walls, scale, 0.0)
    aside = widenings(space.clearance, walls, scale, params.askew)
    width = np.hypot(walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1]) - 1.0
    is_narrow = width * space.resolution <= params.widest_in_corner + 1e-9
    is_in_corner = is_narrow & (aside.min(axis=1) > params.widening)
    enough = np.nextafter(params.widening, np.inf)
    return np.where(is_in_corner[:, None], np.maximum(ahead, enough), ahead)


def _ends_in_map(space: Space, walls: NDArray[np.int64]) -> NDArray[np.float64]:
    first = space.geometry.centres_of(walls[:, :2])
    second = space.geometry.centres_of(walls[:, 2:])
    step = second - first
    face = 0.5 * space.resolution * step / np.hypot(*step.T)[:, None]
    return np.stack([first + face, second - face], axis=1)


def _thinned(chords: Chords, apart: float) -> Chords:
    """Return the most salient chords, without those beside a better one."""
    order = np.argsort(-chords.salience, kind="stable")
    middles, widths = chords.middles, chords.widths
    kept: list[int] = []
    for i in order:
        distance = np.hypot(*(middles[kept] - middles[i]).T)
        clear = np.maximum(apart, 0.75 * np.minimum(widths[kept], widths[i]))
        if np.all(distance > clear):
            kept.append(int(i))
    return chords.chosen(np.array(kept, np.int64))


@kernel
def opposite_walls(
    is_free: NDArray[np.bool_], nearest: NDArray[np.int32], limits: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Return free cells with two opposite nearest walls: row, col and both walls' (n, 6).

    The second wall is that of a neighbouring cell whose direction differs most.

    Args:
        is_free: (rows, cols).
        nearest: the nearest wall cell (rows, cols, 2) of each cell.
        limits: least and greatest distance to the wall, in cells; greatest cosine of the angle.
    """
    rows, cols = is_free.shape
    # Few cells lie half way between walls: room for more is made when it is needed.
    found = np.empty((1024, 6), np.int64)
    count = 0
    for row in range(1, rows - 1):
        for col in range(1, cols - 1):
            if not is_free[row, col]:
                continue
            up, right = nearest[row, col, 0] - row, nearest[row, col, 1] - col
            far = np.hypot(up, right)
            if far < limits[0] or far > limits[1]:
                continue
            least = 2.0
            for i in range(-1, 2):
                for j in range(-1, 2):
                    wall = nearest[row + i, col + j]
                    dy, dx = wall[0] - row, wall[1] - col
                    cosine = (up * dy + right * dx) / (far * np.hypot(dy, dx) + 1e-9)
                    if cosine < least:
                        least = cosine
                        found[count, 4], found[count, 5] = wall[0], wall[1]
            if least <= limits[2]:
                if count + 1 == len(found):
                    found = np.concatenate((found, np.empty_like(found)))
                found[count, 0], found[count, 1] = row, col
                found[count, 2], found[count, 3] = nearest[row, col, 0], nearest[row, col, 1]
                count += 1
    return found[:count].copy()


@kernel
def widenings(
    clearance: NDArray[np.float32],
    walls: NDArray[np.int64],
    scale: NDArray[np.float64],
    askew: float,
) -> NDArray[np.float64]:
    """Return how many times as wide the space gets on either side (n, 2) of chords.

    Args:
        clearance: (rows, cols), m; 0 on walls, where looking ends.
        walls: pairs of wall cells (n, 4).
        scale: how far beyond half the chord's length to look, in cells; width of a cell, m.
        askew: how far to look aside, to the left and to the right, per cell ahead.
    """
    widening = np.zeros((len(walls), 2))
    for i in range(len(walls)):
        up, right = walls[i, 2] - walls[i, 0], walls[i, 3] - walls[i, 1]
        length = np.hypot(up, right)
        row, col = (walls[i, 0] + walls[i, 2]) / 2.0, (walls[i, 1] + walls[i, 3]) / 2.0
        for side in range(2):
            sign = (1.0 - 2.0 * side) / length
            most = 0.0
            for aside in (-askew / length, askew / length):
                over, along = sign * right + aside * up, -sign * up + aside * right
                for step in range(1, int(scale[0] + 0.5 * length)):
                    there = round(row + step * over), round(col + step * along)
                    if not (0 <= there[0] < len(clearance) and 0 <= there[1] < clearance.shape[1]):
                        break
                    here = clearance[there]
                    if here <= 0.0:
                        break
                    most = max(most, here)
            widening[i, side] = most / (0.5 * length * scale[1])
    return widening
