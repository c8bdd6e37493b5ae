"""Beams and edges against a wall, one at a time, by the intersection of two lines."""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.seeing.door_walls import Wall


def crossing(origin: tuple[float, float], bearing: float, wall: Wall) -> tuple[float, float] | None:
    """Distance to where a ray meets the wall's line, and the place along it; None if behind."""
    direction = np.array([math.cos(bearing), math.sin(bearing)])
    matrix = np.stack([direction, -wall.tangent], axis=1)
    if abs(np.linalg.det(matrix)) < math.sin(math.radians(4.0)):
        return None
    distance, place = np.linalg.solve(matrix, wall.rho * wall.normal - np.array(origin))
    return (float(distance), float(place)) if distance > 0.0 else None


def depth(measured: float, bearing: float, wall: Wall) -> float:
    """By how much a beam from the origin ended beyond the wall, along its normal."""
    point = measured * np.array([math.cos(bearing), math.sin(bearing)])
    return float(wall.rho - wall.normal @ point)


def places(
    origin: tuple[float, float], bearings: NDArray[np.float64], wall: Wall, reach: float
) -> list[float]:
    """Places along a wall that rays within `reach` m meet, in order."""
    met = [crossing(origin, float(bearing), wall) for bearing in bearings]
    return sorted(one[1] for one in met if one is not None and one[0] <= reach)
