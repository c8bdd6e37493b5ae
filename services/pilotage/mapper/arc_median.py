"""Where on its arc an echo came from: the arc-transversal median, plain and improved.

ATM (Choset et al. 2003; Li 2008, 4.3): the median of the crossings of 30 degrees and more. The
improved ATM (Li 2008, 4.4): crossings are weighed by their angle and by the lengths of their arcs,
the weak ones dropped, and the mean of the midpoints between neighbours taken. An arc without
crossings keeps its middle.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.mapper.sonar_arcs import (
    MOST_ON_ARC,
    ArcCrossings,
    all_crossings,
    arc_discs,
    crossings_on,
)

BINS = 12
"""Crossing angles from 30 to 90 degrees in steps of 5 (Li 2008, 4.4)."""
DEFAULT_WEIGHTS = (1.0,) * BINS


@dataclass(frozen=True)
class CrossingParams:
    """Which crossings place an obstacle."""

    least_angle: float = math.radians(30.0)
    """Flatter crossings say little (rad); the thesis's 30 degrees."""
    weights: tuple[float, ...] = DEFAULT_WEIGHTS
    """w_i of the improved method for each 5 degrees of angle from 30 on; the thesis leaves them,
    and the threshold, to the circumstances. Equal ones did as well in three halls as fitted ones:
    the score itself prefers near arcs, and 30 to 65 degrees to the crossings of two walls."""
    least_score: float = 0.03
    """Crossings of a smaller score (4-2) are dropped by the improved method, 1."""

    def __post_init__(self) -> None:
        """Refuse weights that do not fit the bins (ValueError)."""
        if len(self.weights) != BINS:
            raise ValueError(f"{BINS} weights are needed, not {len(self.weights)}")


@kernel
def crossing_score(
    angle: float, first_range: float, second_range: float, cone: float, weights: NDArray[np.float64]
) -> float:
    """Return the score 2 (AB + OB) w_i / (s1 + s2) of a crossing (4-2), lengths in cm.

    AB = 1 cm / sin(angle) and OB = 1 cm / tan(angle) span the patch about the crossing, s1 and s2
    are the lengths of the arcs. Angles below 30 degrees have the weight of the first bin.
    """
    step = min(len(weights) - 1, max(0, int((math.degrees(angle) - 30.0) / 5.0 + 1e-9)))
    patch = (1.0 + math.cos(angle)) / math.sin(angle)
    lengths_cm = 100.0 * cone * (first_range + second_range)
    return float(2.0 * patch * weights[step] / lengths_cm)


@kernel
def mean_of_midpoints(places: NDArray[np.float64]) -> float:
    """Return the mean of the midpoints between neighbours of sorted places (m,), m > 0.

    The perpendicular from the meeting point of two tangents of a circle to their chord cuts the
    arc in its midpoint (Li 2008, figure 4-5).
    """
    if len(places) == 1:
        return float(places[0])
    return float(((places[:-1] + places[1:]) / 2.0).mean())


@kernel
def place_echoes(
    arcs: NDArray[np.float64],
    first: int,
    last: int,
    cone: float,
    rule: tuple[bool, float, NDArray[np.float64], float],
) -> NDArray[np.float64]:
    """Return where on arcs `first` to `last` - 1 their echoes came from, and how it is known.

    (last - first, 2): angle from the axis in rad, and the number of crossings used (0: the
    middle). `rule` is: improved or not, least angle, weights, least score.
    """
    improved, least_angle, weights, least_score = rule
    found, discs = np.empty((MOST_ON_ARC, 3)), arc_discs(arcs, cone / 2.0)
    echoes = np.zeros((last - first, 2))
    for index in range(first, last):
        count = crossings_on(arcs, discs, index, cone / 2.0, least_angle, found)
        places = np.empty(count)
        used = 0
        for k in range(count):
            other = arcs[int(found[k, 2]), 3]
            score = crossing_score(found[k, 1], arcs[index, 3], other, cone, weights)
            if not improved or score >= least_score:
                places[used] = found[k, 0]
                used += 1
        if used > 0:
            places = np.sort(places[:used])
            middle = mean_of_midpoints(places) if improved else np.median(places)
            echoes[index - first, 0] = middle
            echoes[index - first, 1] = used
    return echoes


def find_crossings(
    arcs: NDArray[np.float64], cone: float, params: CrossingParams, *, improved: bool
) -> ArcCrossings:
    """Return all transversal crossings of arcs (n, 4), and which the method would use."""
    found = all_crossings(arcs, cone / 2.0, params.least_angle)
    pairs = found[:, 3:].astype(np.int64)
    is_used = np.ones(len(found), bool)
    if improved:
        weights = np.array(params.weights)
        scores = [
            crossing_score(angle, arcs[a, 3], arcs[b, 3], cone, weights)
            for angle, (a, b) in zip(found[:, 2], pairs, strict=True)
        ]
        is_used = np.array(scores, float) >= params.least_score
    return ArcCrossings(found[:, :2], found[:, 2], pairs, is_used)


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    arcs = np.array([[0.0, 0.0, 0.0, 1.0], [1.0, 1.0, -1.57, 1.0]])
    place_echoes(arcs, 0, 2, 0.4, (True, 0.5, np.ones(BINS), 0.0))
