"""Puts the pieces of one wall's face together where a crack or a bump in the map parted them."""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.core.map_line_splitting import line_of
from pilotage.core.near_points import near_pairs

LEAST_SIDES = 3
"""Fewer sides of cells show no direction."""
SAME_WAY = 0.9
"""Least cosine between the pieces of one face and the whole."""

Faces = tuple[NDArray[np.float64], NDArray[np.float64]]
"""Ends (p, 2, 2) in cells, free space on the left, and moments (p, 6) of the sides between."""


def merge_faces(faces: Faces, gap: float, tolerance: float) -> Faces:
    """Return the faces with those joined that go on after a gap, cells, to within a tolerance."""
    ends, moments = faces
    shown = moments[:, 0] >= LEAST_SIDES
    ends, moments = ends[shown].copy(), moments[shown].copy()
    pairs = near_pairs(ends[:, 1], ends[:, 0], gap)
    apart = np.hypot(*(ends[pairs[:, 0], 1] - ends[pairs[:, 1], 0]).T)
    kept = _join(ends, moments, pairs[np.argsort(apart, kind="stable")], tolerance)
    return ends[kept], moments[kept]


@kernel
def _join(
    ends: NDArray[np.float64],
    moments: NDArray[np.float64],
    pairs: NDArray[np.int64],
    tolerance: float,
) -> NDArray[np.bool_]:
    """Join pairs (k, 2) in place, the nearest first; return which faces (p,) are still there.

    A face that was joined lives on as the first of its pieces.
    """
    count = len(ends)
    # Of a face, its first piece knows the last and the last knows the first.
    head, tail = np.arange(count), np.arange(count)
    is_tail = np.ones(count, np.bool_)
    kept = np.ones(count, np.bool_)
    for k in range(len(pairs)):
        before, after = pairs[k, 0], pairs[k, 1]
        # Each piece goes on once at most, and follows one piece at most.
        if not is_tail[before] or not kept[after] or head[before] == after:
            continue
        face = head[before]
        together = moments[face] + moments[after]
        if not _is_one_face(ends[face], ends[after], line_of(together), tolerance):
            continue
        moments[face] = together
        ends[face, 1] = ends[after, 1]
        kept[after], is_tail[before] = False, False
        head[tail[after]], tail[face] = face, tail[after]
    return kept


@kernel
def _length(ends: NDArray[np.float64]) -> float:
    """Return the distance of two ends (2, 2)."""
    return math.hypot(ends[1, 0] - ends[0, 0], ends[1, 1] - ends[0, 1])


@kernel
def _is_one_face(
    one: NDArray[np.float64],
    two: NDArray[np.float64],
    line: tuple[float, float, float],
    tolerance: float,
) -> bool:
    """Say whether two faces with ends (2, 2) run along one line the same way."""
    cos, sin = math.cos(line[0]), math.sin(line[0])
    along_x, along_y = two[1, 0] - one[0, 0], two[1, 1] - one[0, 1]
    length = math.hypot(along_x, along_y)
    # Specks in a row are no wall: what lies between two pieces is shorter than one of them.
    crack = math.hypot(two[0, 0] - one[1, 0], two[0, 1] - one[1, 1])
    if crack > max(_length(one), _length(two)):
        return False
    for ends in (one, two):
        dx, dy = ends[1, 0] - ends[0, 0], ends[1, 1] - ends[0, 1]
        if dx * along_x + dy * along_y <= SAME_WAY * length * math.hypot(dx, dy):
            return False
        for k in range(2):
            if abs(ends[k, 0] * cos + ends[k, 1] * sin - line[1]) > tolerance:
                return False
    return True
