"""Kernels of split and merge: which beams of a scan lie on one wall.

Beams are (n, 3): cosine and sine of the bearing, range in m; in the order of their bearings. A
piece is a row of beams (first, last), both inclusive.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.core.line_fit import (
    BeamNoise,
    Fit,
    fit_line,
    mahalanobis,
    misfit,
    normal_of,
    place_along,
    residual,
)

GRAZING = 0.2
"""rad: where a wall is seen at a smaller angle, its beams may lie too far apart to be chained."""
REFINED = 5
"""Beams to either side of a corner that may change walls after the first split."""
LOST = 3.0
"""Spacings between two beams on a wall that is not open there: two beams may be lost."""
FRAGMENTS = 12
"""So many pieces ahead a wall may go on: a person is a few, dust is one."""


class Straightness(NamedTuple):
    """When beams lie on one wall."""

    noise: BeamNoise
    split_sigmas: float
    """A beam this many standard deviations off does not belong to the wall."""
    merge_chi2: float
    """Most squared Mahalanobis distance of two pieces of one wall (two degrees of freedom)."""
    gap: float
    """m: longest opening in a wall, or jump in depth, that does not end it."""
    hidden_gap: float
    """m: longest stretch of a wall hidden by something nearer that does not end it."""
    step: float
    """rad between neighbouring beams, positive."""


@kernel
def split_scan(beams: NDArray[np.float64], rules: Straightness) -> NDArray[np.int64]:
    """Return the straight pieces (p, 2) of beams (n, 3) that all hit something, in order."""
    count = len(beams)
    pieces = np.empty((count, 2), np.int64)
    waiting = np.empty((count + 1, 2), np.int64)
    found, start = 0, 0
    for end in range(count):
        if end + 1 < count and not _breaks(beams[end], beams[end + 1], rules):
            continue
        waiting[0, 0], waiting[0, 1] = start, end
        depth, start = 1, end + 1
        while depth > 0:
            depth -= 1
            first, last = waiting[depth, 0], waiting[depth, 1]
            at = _split_at(beams[first : last + 1], rules)
            if at == 0:
                pieces[found, 0], pieces[found, 1] = first, last
                found += 1
                continue
            waiting[depth, 0], waiting[depth, 1] = first + at, last
            waiting[depth + 1, 0], waiting[depth + 1, 1] = first, first + at - 1
            depth += 2
    return pieces[:found]


@kernel
def _breaks(one: NDArray[np.float64], two: NDArray[np.float64], rules: Straightness) -> bool:
    """Say whether two successive hits (3,) lie too far apart for one wall."""
    cos, sin = one[0] * two[0] + one[1] * two[1], one[0] * two[1] - one[1] * two[0]
    squared = one[2] ** 2 + two[2] ** 2 - 2.0 * one[2] * two[2] * cos
    turn = 2.0 * rules.step
    if cos > 0.0:
        turn = min(math.asin(min(sin, 1.0)), turn)
    allowed = rules.gap + turn * min(one[2], two[2]) / math.tan(GRAZING)
    return bool(squared > allowed * allowed)


@kernel
def _split_at(beams: NDArray[np.float64], rules: Straightness) -> int:
    """Return which of the beams begins another piece; 0 if all lie on one wall."""
    if len(beams) < 3:
        return 0
    line = fit_line(beams, rules.noise)
    worst, _ = misfit(beams, line, rules.noise)
    if worst > rules.split_sigmas:
        return _farthest_from_chord(beams)
    return _opening(beams, line, rules)


@kernel
def _farthest_from_chord(beams: NDArray[np.float64]) -> int:
    """Return the beam, neither first nor last, that ends farthest from the chord of the two."""
    x = beams[:, 2] * beams[:, 0]
    y = beams[:, 2] * beams[:, 1]
    dx, dy = x[-1] - x[0], y[-1] - y[0]
    farthest, most = 1, -1.0
    for i in range(1, len(beams) - 1):
        aside = abs(dx * (y[i] - y[0]) - dy * (x[i] - x[0]))
        if aside > most:
            farthest, most = i, aside
    return farthest


@kernel
def _opening(beams: NDArray[np.float64], line: Fit, rules: Straightness) -> int:
    """Return the beam after the first opening in a wall; 0 if there is none."""
    for i in range(1, len(beams)):
        if distance_along(line, beams[i - 1], beams[i]) > widest_opening(line, beams[i - 1], rules):
            return i
    return 0


@kernel
def distance_along(line: Fit, one: NDArray[np.float64], two: NDArray[np.float64]) -> float:
    """Return how far apart two beams (3,) end along a line, m; positive in their order."""
    return place_along(two, line.alpha) - place_along(one, line.alpha)


@kernel
def widest_opening(line: Fit, beam: NDArray[np.float64], rules: Straightness) -> float:
    """Return how far the next hit may lie along a wall at a beam (3,), m."""
    return max(rules.gap, LOST * spacing(line, beam, rules.step))


@kernel
def spacing(line: Fit, beam: NDArray[np.float64], step: float) -> float:
    """Return how far apart beams that differ by a step, rad, meet a line near a beam (3,), m."""
    cos = max(math.cos(line.alpha) * beam[0] + math.sin(line.alpha) * beam[1], 0.05)
    return float(step * beam[2] / cos)


@kernel
def refine_borders(
    beams: NDArray[np.float64], pieces: NDArray[np.int64], rules: Straightness
) -> None:
    """Let each beam near a corner join the wall that it fits better; changes pieces (p, 2)."""
    noise = rules.noise
    for i in range(len(pieces) - 1):
        first, last = pieces[i, 0], pieces[i + 1, 1]
        border = pieces[i + 1, 0]
        if border - first < 3 or last + 1 - border < 3:
            continue
        one = fit_line(beams[first:border], noise)
        two = fit_line(beams[border : last + 1], noise)
        at_corner = mahalanobis(one, two, beams[border]) > rules.merge_chi2
        if not at_corner or _breaks(beams[border - 1], beams[border], rules):
            continue
        low = max(first + 2, border - REFINED)
        high = min(last - 1, border + REFINED)
        # What it costs, or saves, to give the beams from here to the next border to the other.
        cost, least, best = 0.0, 0.0, border
        for at in range(border, high):
            cost += _preference(beams[at], one, two, noise)
            if cost < least:
                least, best = cost, at + 1
        cost = 0.0
        for at in range(border - 1, low - 1, -1):
            cost -= _preference(beams[at], one, two, noise)
            if cost < least:
                least, best = cost, at
        pieces[i, 1], pieces[i + 1, 0] = best - 1, best


@kernel
def _preference(beam: NDArray[np.float64], one: Fit, two: Fit, noise: BeamNoise) -> float:
    """Return how much worse a beam (3,) fits the first line than the second."""
    off_one, variance_one, _ = residual(normal_of(one), one.distance, beam, noise)
    off_two, variance_two, _ = residual(normal_of(two), two.distance, beam, noise)
    return off_one**2 / variance_one - off_two**2 / variance_two
