"""Where the arcs of sonar echoes cross (Choset et al. 2003; Li 2008, 4.3).

An echo came from somewhere on its arc. Arcs of one obstacle, heard from different places, cross
at it; the larger the angle between them, the better the place is known. Arcs (n, 4) are x, y,
direction of the sonar's axis in the map, and range; all have the same cone.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

MOST_ON_ARC = 1024
"""More crossings than this on one arc say nothing new."""


@dataclass(frozen=True, eq=False)
class ArcCrossings:
    """Points where two arcs cross: (m, 2) in the map, with the angle (m,) between them in rad.

    `pairs` (m, 2) are the arcs, the smaller index first; `is_used` (m,) says which crossings the
    method that asked would let place an obstacle.
    """

    points: NDArray[np.float64]
    angles: NDArray[np.float64]
    pairs: NDArray[np.int64]
    is_used: NDArray[np.bool_]


@kernel
def circle_crossings(
    first: NDArray[np.float64], second: NDArray[np.float64]
) -> tuple[float, float, float]:
    """Return how the circles of two arcs (4,) cross, seen from the first centre.

    The direction of the second centre, and the half angles between that and the crossings as seen
    from the first and from the second centre; these are NaN if the circles do not cross.
    """
    dx, dy = second[0] - first[0], second[1] - first[1]
    apart = math.sqrt(dx * dx + dy * dy)
    if apart > first[3] + second[3] or apart < abs(first[3] - second[3]) or apart < 1e-9:
        return math.nan, math.nan, math.nan
    near = (first[3] * first[3] - second[3] * second[3] + apart * apart) / (2.0 * apart)
    up = math.sqrt(max(0.0, first[3] * first[3] - near * near))
    return math.atan2(dy, dx), math.atan2(up, near), math.atan2(up, near - apart)


@kernel
def turn(target: float, origin: float) -> float:
    """Return the shortest turn from `origin` to `target`, rad."""
    return (target - origin + math.pi) % (2.0 * math.pi) - math.pi


@kernel
def crossing_angle(first: float, second: float) -> float:
    """Return the angle in [0, pi/2] between two arcs whose radii point to these directions."""
    between = abs(turn(first, second))
    return min(between, math.pi - between)


@kernel
def arc_discs(arcs: NDArray[np.float64], half_cone: float) -> NDArray[np.float64]:
    """Return discs (n, 3) about arcs (n, 4): x, y of the middle of the arc, and radius."""
    discs = np.empty((len(arcs), 3))
    for index in range(len(arcs)):
        discs[index, 0] = arcs[index, 0] + arcs[index, 3] * math.cos(arcs[index, 2])
        discs[index, 1] = arcs[index, 1] + arcs[index, 3] * math.sin(arcs[index, 2])
        # A bit more than the chord from the middle to the end, for what rounding takes away.
        discs[index, 2] = 2.0001 * math.sin(half_cone / 2.0) * arcs[index, 3]
    return discs


@kernel
def crossings_on(  # noqa: PLR0913, PLR0917  - compiled: plain numbers and arrays
    arcs: NDArray[np.float64],
    discs: NDArray[np.float64],
    index: int,
    half_cone: float,
    least_angle: float,
    found: NDArray[np.float64],
) -> int:
    """Write the crossings on one arc into `found` (m, 3) and return their number.

    A row is the place on the arc as an angle from its axis, the angle of the crossing, and the
    index of the other arc. Crossings flatter than `least_angle` are left out. `discs` (n, 3)
    are about the arcs: where two are apart, so are their arcs.
    """
    count = 0
    mine = arcs[index]
    for other in range(len(arcs)):
        dx, dy = discs[other, 0] - discs[index, 0], discs[other, 1] - discs[index, 1]
        most = discs[other, 2] + discs[index, 2]
        if other == index or dx * dx + dy * dy > most * most:
            continue
        towards, half_here, half_there = circle_crossings(mine, arcs[other])
        if math.isnan(towards):
            continue
        for side in range(2):
            sign = 1.0 if side == 0 else -1.0
            here, there = towards + sign * half_here, towards + sign * half_there
            place = turn(here, mine[2])
            if abs(place) > half_cone or abs(turn(there, arcs[other, 2])) > half_cone:
                continue
            angle = crossing_angle(here, there)
            if angle >= least_angle and count < len(found):
                found[count, 0], found[count, 1], found[count, 2] = place, angle, other
                count += 1
    return count


@kernel
def all_crossings(
    arcs: NDArray[np.float64], half_cone: float, least_angle: float
) -> NDArray[np.float64]:
    """Return all crossings (m, 5) of arcs, each once: x, y, angle, smaller and larger index."""
    crossings = np.empty((64, 5))
    found = np.empty((2 * len(arcs) + 1, 3))
    discs = arc_discs(arcs, half_cone)
    total = 0
    for index in range(len(arcs)):
        count = crossings_on(arcs[index:], discs[index:], 0, half_cone, least_angle, found)
        while total + count > len(crossings):
            crossings = np.concatenate((crossings, np.empty_like(crossings)))
        for k in range(count):
            direction = arcs[index, 2] + found[k, 0]
            crossings[total, 0] = arcs[index, 0] + arcs[index, 3] * math.cos(direction)
            crossings[total, 1] = arcs[index, 1] + arcs[index, 3] * math.sin(direction)
            crossings[total, 2] = found[k, 1]
            crossings[total, 3], crossings[total, 4] = index, index + found[k, 2]
            total += 1
    return crossings[:total]


def are_on_surface(
    distances_to_surface: NDArray[np.float64], tolerance: float
) -> NDArray[np.bool_]:
    """Say which crossings are valid: so near (m) to a true obstacle that they lie on it.

    `distances_to_surface` (m,) is the true distance of each crossing from the nearest obstacle;
    the tolerance is of the order of a cell and the noise of the sonar.
    """
    valid: NDArray[np.bool_] = np.abs(distances_to_surface) <= tolerance
    return valid


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    all_crossings(np.array([[0.0, 0.0, 0.0, 1.0], [1.0, 1.0, -1.57, 1.0]]), 0.2, 0.5)
