"""Kernels that cut the outlines of walls into straight faces.

An outline is seen as the middles of its cell sides: where a wall cell is one whose centre lies in
the wall, these scatter evenly about the true face. Their sums (x, y, xx, xy, yy) are added up
once, so that a line through any stretch costs the same.
"""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

BACK = 1.5
"""Cells that an outline may go back along its face: round the end of a thin wall it goes on."""
ACROSS = 0.9
"""Cosine between a side and a face's normal from which on the side is the face's end."""
TIGHT, LOOSER = 0.6, 0.05
"""Cells, and cells per cell of length, that the sides of a short face may lie off it."""


@kernel
def split_contours(
    corners: NDArray[np.float64], begins: NDArray[np.int64], tolerance: float
) -> NDArray[np.int64]:
    """Return straight pieces (p, 2) of outlines: first and last corner, in order.

    Args:
        corners: (n, 2) x, y in cells; a closed outline is turned in place to begin at a border.
        begins: (k + 1,) where each outline begins, and the end of the last.
        tolerance: how far the middle of a side may lie off its face, cells.
    """
    pieces = np.empty((len(corners), 2), np.int64)
    found = 0
    for k in range(len(begins) - 1):
        outline = corners[begins[k] : begins[k + 1]]
        here = pieces[found : found + len(outline)]
        count = _split_outline(outline, tolerance, here)
        if count > 2 and (outline[0] == outline[-1]).all():
            # It began wherever it was first met, most likely in the middle of a face.
            border = here[count // 2, 0]
            outline[:] = np.concatenate((outline[border:-1], outline[: border + 1]))
            count = _split_outline(outline, tolerance, here)
        here[:count] += begins[k]
        found += count
    return pieces[:found]


@kernel
def _split_outline(
    outline: NDArray[np.float64], tolerance: float, pieces: NDArray[np.int64]
) -> int:
    """Write the straight pieces of one outline (m, 2); return how many they are."""
    sums = _running_sums(outline)
    waiting = np.empty((len(outline) + 1, 2), np.int64)
    waiting[0, 0], waiting[0, 1] = 0, len(outline) - 1
    depth, found = 1, 0
    while depth > 0:
        depth -= 1
        first, last = waiting[depth, 0], waiting[depth, 1]
        at = _split_at(outline, sums, (first, last), tolerance)
        if at == 0:
            pieces[found, 0], pieces[found, 1] = first, last
            found += 1
            continue
        waiting[depth, 0], waiting[depth, 1] = at, last
        waiting[depth + 1, 0], waiting[depth + 1, 1] = first, at
        depth += 2
    _settle_borders(sums, pieces[:found])
    _trim(outline, sums, pieces[:found])
    return found


@kernel
def _settle_borders(sums: NDArray[np.float64], pieces: NDArray[np.int64]) -> None:
    """Move each border of two pieces (p, 2) to where both together are straightest."""
    for _ in range(2):
        for i in range(len(pieces) - 1):
            first, last = pieces[i, 0], pieces[i + 1, 1]
            best, least = pieces[i, 1], math.inf
            for at in range(first + 1, last):
                error = _error(sums, first, at) + _error(sums, at, last)
                if error < least:
                    best, least = at, error
            pieces[i, 1] = pieces[i + 1, 0] = best


@kernel
def _trim(
    outline: NDArray[np.float64], sums: NDArray[np.float64], pieces: NDArray[np.int64]
) -> None:
    """Take from the ends of pieces (p, 2) the sides that run across them: they are its ends."""
    for i in range(len(pieces)):
        for end in range(2):
            first, last = pieces[i]
            alpha, _, _ = line_of(sums[last] - sums[first])
            side = first if end == 0 else last - 1
            dx, dy = (
                outline[side + 1, 0] - outline[side, 0],
                outline[side + 1, 1] - outline[side, 1],
            )
            if last - first > 3 and abs(dx * math.cos(alpha) + dy * math.sin(alpha)) > ACROSS:
                pieces[i, end] += 1 - 2 * end


@kernel
def _error(sums: NDArray[np.float64], first: int, last: int) -> float:
    """Return the sum of squared distances of a piece's sides from its line, cells^2."""
    moments = sums[last] - sums[first]
    return float(moments[0] * line_of(moments)[2])


@kernel
def moments_of(corners: NDArray[np.float64], pieces: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return count and sums (p, 6) of x, y, xx, xy, yy of the sides' middles of pieces (p, 2)."""
    moments = np.zeros((len(pieces), 6))
    for i in range(len(pieces)):
        for k in range(pieces[i, 0], pieces[i, 1]):
            x = 0.5 * (corners[k, 0] + corners[k + 1, 0])
            y = 0.5 * (corners[k, 1] + corners[k + 1, 1])
            moments[i, 0] += 1.0
            moments[i, 1] += x
            moments[i, 2] += y
            moments[i, 3] += x * x
            moments[i, 4] += x * y
            moments[i, 5] += y * y
    return moments


@kernel
def line_of(moments: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return the line nearest to points with moments (6,).

    That is the direction of its normal, rad, up to half a turn, its distance from the origin
    along that, and the mean squared distance of the points from it.
    """
    count = moments[0]
    x, y = moments[1] / count, moments[2] / count
    xx = moments[3] / count - x * x
    xy = moments[4] / count - x * y
    yy = moments[5] / count - y * y
    alpha = 0.5 * math.atan2(-2.0 * xy, yy - xx)
    spread = 0.5 * (xx + yy) - math.hypot(0.5 * (xx - yy), xy)
    return alpha, x * math.cos(alpha) + y * math.sin(alpha), max(spread, 0.0)


@kernel
def lines_of(moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return what `line_of` says of each of moments (p, 6), as rows (p, 3)."""
    lines = np.empty((len(moments), 3))
    for i in range(len(moments)):
        lines[i, 0], lines[i, 1], lines[i, 2] = line_of(moments[i])
    return lines


@kernel
def _running_sums(outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the moments (m, 6) of the sides before each corner of an outline (m, 2)."""
    sums = np.zeros((len(outline), 6))
    for k in range(len(outline) - 1):
        # From the first corner, or the squares would lose their digits far from the origin.
        x = 0.5 * (outline[k, 0] + outline[k + 1, 0]) - outline[0, 0]
        y = 0.5 * (outline[k, 1] + outline[k + 1, 1]) - outline[0, 1]
        sums[k + 1, 0] = sums[k, 0] + 1.0
        sums[k + 1, 1] = sums[k, 1] + x
        sums[k + 1, 2] = sums[k, 2] + y
        sums[k + 1, 3] = sums[k, 3] + x * x
        sums[k + 1, 4] = sums[k, 4] + x * y
        sums[k + 1, 5] = sums[k, 5] + y * y
    return sums


@kernel
def _split_at(
    outline: NDArray[np.float64],
    sums: NDArray[np.float64],
    piece: tuple[int, int],
    tolerance: float,
) -> int:
    """Return the corner where a piece of an outline is no longer one face; 0 if it is one."""
    first, last = piece
    if last - first < 2:
        return 0
    alpha, distance, _ = line_of(sums[last] - sums[first])
    cos, sin = math.cos(alpha), math.sin(alpha)
    distance += outline[0, 0] * cos + outline[0, 1] * sin
    dx, dy = outline[last, 0] - outline[first, 0], outline[last, 1] - outline[first, 1]
    sign = 1.0 if dy * cos - dx * sin >= 0.0 else -1.0
    worst, ahead, turn = 0.0, -math.inf, first
    for k in range(first, last):
        x = 0.5 * (outline[k, 0] + outline[k + 1, 0])
        y = 0.5 * (outline[k, 1] + outline[k + 1, 1])
        worst = max(worst, abs(x * cos + y * sin - distance))
        along = sign * (y * cos - x * sin)
        if along > ahead:
            ahead, turn = along, k
        elif along < ahead - BACK and turn > first:
            return turn
    # In a short piece a corner would pass for raggedness.
    if worst <= min(tolerance, TIGHT + LOOSER * math.hypot(dx, dy)):
        return 0
    return _farthest_from_chord(outline, first, last)


@kernel
def _farthest_from_chord(outline: NDArray[np.float64], first: int, last: int) -> int:
    """Return the corner between two that lies farthest from their chord, or from the one point."""
    dx, dy = outline[last, 0] - outline[first, 0], outline[last, 1] - outline[first, 1]
    closed = dx == 0.0 and dy == 0.0
    farthest, most = first + 1, -1.0
    for k in range(first + 1, last):
        x, y = outline[k, 0] - outline[first, 0], outline[k, 1] - outline[first, 1]
        aside = x * x + y * y if closed else abs(dx * y - dy * x)
        if aside > most:
            farthest, most = k, aside
    return farthest
