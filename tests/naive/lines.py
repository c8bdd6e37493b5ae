"""Lines and contours by their definitions: likelihoods searched, cells looked at one by one."""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core.line_fit import BeamNoise

Side = tuple[tuple[int, int], tuple[int, int]]
"""A cell's side as the two grid corners (x, y) that it joins, free space on its left."""


def cost(line: tuple[float, float], beams: NDArray[np.float64], noise: BeamNoise) -> float:
    """Return half the squared misfit of beams (n, 2), bearing and range, from a line.

    The line is alpha and distance; where it meets each beam says how much that beam errs along
    the normal.
    """
    total = 0.0
    for bearing, measured in beams:
        turn = bearing - line[0]
        place = line[1] * math.tan(turn)
        variance = (noise.range_sigma * math.cos(turn)) ** 2
        variance += (noise.bearing_sigma * place) ** 2 + noise.wall_sigma**2
        total += 0.5 * (measured * math.cos(turn) - line[1]) ** 2 / variance
    return total


def likeliest(
    beams: NDArray[np.float64], start: tuple[float, float], noise: BeamNoise
) -> tuple[float, float]:
    """Return alpha and distance where the cost of beams (n, 2) is least: a search by halving."""
    line, step = list(start), [0.02, 0.02]
    least = cost((line[0], line[1]), beams, noise)
    while max(step) > 1e-7:
        better = False
        for turn in (-1, 0, 1):
            for push in (-1, 0, 1):
                tried = line[0] + turn * step[0], line[1] + push * step[1]
                value = cost(tried, beams, noise)
                if value < least:
                    least, best, better = value, tried, True
        if better:
            line = list(best)
        else:
            step = [step[0] / 2.0, step[1] / 2.0]
    return line[0], line[1]


def sides(is_wall: NDArray[np.bool_], is_free: NDArray[np.bool_]) -> set[Side]:
    """Return the sides of wall cells that free cells touch."""
    rows, cols = is_wall.shape
    found: set[Side] = set()
    for row, col in np.argwhere(is_wall).tolist():
        low, high, left, right = row, row + 1, col, col + 1
        around = {
            (row, col + 1): ((right, high), (right, low)),
            (row, col - 1): ((left, low), (left, high)),
            (row + 1, col): ((left, high), (right, high)),
            (row - 1, col): ((right, low), (left, low)),
        }
        for (r, c), side in around.items():
            if 0 <= r < rows and 0 <= c < cols and is_free[r, c]:
                found.add(side)
    return found


def near_pairs(
    ones: NDArray[np.float64], others: NDArray[np.float64], most_apart: float
) -> set[tuple[int, int]]:
    """Return the pairs of points (n, 2) and (m, 2) less than so far apart."""
    return {
        (i, j)
        for i, one in enumerate(ones)
        for j, other in enumerate(others)
        if math.hypot(*(one - other)) < most_apart
    }
