"""The kernel that lays a line through laser beams: maximum likelihood, with its covariance.

Here a line is (alpha, d): the normal points away from the laser and d > 0 is its distance, so a
beam of bearing b meets it at range d / cos(b - alpha). Errors stand in ranges and bearings; the
residual along the normal, r cos(b - alpha) - d, therefore has its own variance at each beam.
Beams are (n, 3): cosine and sine of the bearing, and the range in m.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

ROUNDS = 3
"""Gauss-Newton steps after the first guess; a third changes what the fifth digit says."""


class BeamNoise(NamedTuple):
    """How much a laser's beam errs, and a wall with it; standard deviations.

    As recorded walls scatter: fr079 and Wean Hall about 1 cm, Aces 2 cm.
    """

    range_sigma: float = 0.015
    """m, along the beam."""
    bearing_sigma: float = 0.001
    """rad."""
    wall_sigma: float = 0.005
    """m along the wall's normal: plaster, and centimetres that the laser rounds to."""


class Fit(NamedTuple):
    """A line away from the laser, and its covariance."""

    alpha: float
    """rad, from the laser towards the wall."""
    distance: float
    """m, not negative."""
    var_alpha: float
    """rad^2."""
    cov: float
    """rad m."""
    var_distance: float
    """m^2."""


@kernel
def residual(
    normal: tuple[float, float], distance: float, beam: NDArray[np.float64], noise: BeamNoise
) -> tuple[float, float, float]:
    """Return how far a beam (3,) ends beyond a line, m; the variance; its place along, m."""
    measured = beam[2]
    cos, sin = normal[0] * beam[0] + normal[1] * beam[1], normal[0] * beam[1] - normal[1] * beam[0]
    # The range that the line foretells, not the measured one, or noise would bias the fit.
    foretold = distance / cos if cos > 1e-6 else measured
    foretold = min(max(foretold, 0.5 * measured), 2.0 * measured)
    along = foretold * sin
    variance = (noise.range_sigma * cos) ** 2 + (noise.bearing_sigma * along) ** 2
    # A grazing beam is never perfect, and two beams on one ray are no line.
    return measured * cos - distance, variance + noise.wall_sigma**2 + 1e-10, along


@kernel
def normal_of(line: Fit) -> tuple[float, float]:
    """Return the unit vector from the laser towards a line."""
    return math.cos(line.alpha), math.sin(line.alpha)


@kernel
def first_guess(beams: NDArray[np.float64]) -> tuple[float, float]:
    """Return alpha and distance of the line nearest to the ends of beams (n, 3), unweighted."""
    count = len(beams)
    x, y, xx, xy, yy = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(count):
        right, up = beams[i, 2] * beams[i, 0], beams[i, 2] * beams[i, 1]
        x, y = x + right, y + up
        xx, xy, yy = xx + right * right, xy + right * up, yy + up * up
    mean_x, mean_y = x / count, y / count
    xx, xy, yy = xx - x * mean_x, xy - x * mean_y, yy - y * mean_y
    alpha = 0.5 * math.atan2(-2.0 * xy, yy - xx)
    distance = mean_x * math.cos(alpha) + mean_y * math.sin(alpha)
    if distance < 0.0:
        return alpha + math.pi, -distance
    return alpha, distance


@kernel
def fit_line(beams: NDArray[np.float64], noise: BeamNoise) -> Fit:
    """Return the likeliest line through two or more beams (n, 3)."""
    alpha, distance = first_guess(beams)
    var_alpha, cov, var_distance = 0.0, 0.0, 0.0
    for _ in range(ROUNDS):
        normal = math.cos(alpha), math.sin(alpha)
        weight, first, second, torque, push = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(len(beams)):
            beyond, variance, along = residual(normal, distance, beams[i], noise)
            weight += 1.0 / variance
            first += along / variance
            second += along * along / variance
            torque += along * beyond / variance
            push += beyond / variance
        determinant = max(weight * second - first * first, 1e-9 * weight * weight)
        var_alpha = weight / determinant
        cov = first / determinant
        var_distance = second / determinant
        # The residual falls by `along` with alpha turning and by 1 with distance growing.
        alpha += -var_alpha * torque + cov * push
        distance += -cov * torque + var_distance * push
    if distance < 0.0:
        return Fit(alpha + math.pi, -distance, var_alpha, -cov, var_distance)
    return Fit(alpha, distance, var_alpha, cov, var_distance)


@kernel
def misfit(beams: NDArray[np.float64], line: Fit, noise: BeamNoise) -> tuple[float, float]:
    """Return the largest and the mean squared residual of beams (n, 3), in standard deviations."""
    normal = normal_of(line)
    worst, total = 0.0, 0.0
    for i in range(len(beams)):
        beyond, variance, _ = residual(normal, line.distance, beams[i], noise)
        squared = beyond * beyond / variance
        worst = max(worst, squared)
        total += squared
    return math.sqrt(worst), total / len(beams)


@kernel
def place_along(beam: NDArray[np.float64], alpha: float) -> float:
    """Return where a beam (3,) ends along a line, m to the left of the foot of its normal."""
    return float(beam[2] * (math.cos(alpha) * beam[1] - math.sin(alpha) * beam[0]))


@kernel
def mahalanobis(one: Fit, two: Fit, beam: NDArray[np.float64]) -> float:
    """Return the squared distance of two lines measured by both their covariances.

    They are compared by their directions and by where they pass the end of a beam (3,) on the
    one that is known worse: its distance from the far laser does not follow its direction
    linearly.
    """
    turn = (two.alpha - one.alpha + math.pi) % (2.0 * math.pi) - math.pi
    beyond, var_alpha, cov, var_beyond = 0.0, 0.0, 0.0, 0.0
    for line, sign in ((one, 1.0), (two, -1.0)):
        normal, along = normal_of(line), place_along(beam, line.alpha)
        depth = beam[2] * (normal[0] * beam[0] + normal[1] * beam[1])
        beyond += sign * (line.distance - depth)
        var_alpha += line.var_alpha
        cov += line.cov - along * line.var_alpha
        var_beyond += line.var_distance - 2.0 * along * line.cov + along**2 * line.var_alpha
    determinant = var_alpha * var_beyond - cov * cov
    # `beyond` is the first line's less the second's, `turn` the second's less the first's.
    weighed = turn**2 * var_beyond + 2.0 * turn * beyond * cov + beyond**2 * var_alpha
    return float(weighed / determinant) if determinant > 0.0 else math.inf
