"""Lines in a laser scan: split and merge, then the likeliest line through each wall's beams.

A scan is cut where neighbouring hits lie too far apart, each chain is split at the beam farthest
from its chord until every piece is straight to within the noise (iterative end point fit), beams
near corners choose the wall they fit better, and pieces of one wall are merged across dust,
people and lost beams, not across openings. What is short, round or rough is no wall.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.jit import kernel
from pilotage.core.line_fit import BeamNoise, fit_line, misfit, place_along
from pilotage.core.line_merging import is_round, merge_pieces
from pilotage.core.line_splitting import Straightness, refine_borders, split_scan
from pilotage.core.lines import Lines
from pilotage.core.scans import Ranges, bearings_of

USUAL_LASER = BeamNoise()


@dataclass(frozen=True)
class LineParams:
    """How the laser errs, and what counts as a wall."""

    noise: BeamNoise = USUAL_LASER
    split_sigmas: float = 4.0
    """A beam more standard deviations off than this lies on another wall."""
    merge_chi2: float = 18.4
    """Most squared Mahalanobis distance of two pieces of a wall: one in 10,000 is farther."""
    least_length: float = 0.3
    """m; what is shorter is furniture or a leg."""
    least_beams: int = 5
    gap: float = 0.3
    """m: a wall with a wider opening is two walls."""
    hidden_gap: float = 1.2
    """m: a wall hidden along more than this is two walls."""
    most_rough: float = 2.5
    """Largest mean squared residual of a wall's beams, in variances."""
    round_radius: float = 1.0
    """m: what plainly bulges like a disc smaller than this is a person or a pillar."""


def extract_lines(
    ranges: Ranges, angles: tuple[float, float], params: LineParams = LineParams()
) -> Lines:
    """Return the walls in a scan, in the laser's frame.

    Args:
        ranges: (n,) m; infinite, NaN or not positive where nothing came back.
        angles: bearing of the first beam and the step from beam to beam, rad (either sign).
        params: noise of the laser, and what a wall is.
    """
    scan = _in_order(np.asarray(ranges, np.float64), *angles)
    hits = np.flatnonzero(scan[:, 2] > 0.0)
    if len(hits) < 2:
        return Lines.none()
    rules = Straightness(
        params.noise,
        params.split_sigmas,
        params.merge_chi2,
        params.gap,
        params.hidden_gap,
        abs(angles[1]),
    )
    walls = (params.least_length, float(params.least_beams), params.most_rough, params.round_radius)
    return _as_lines(find_walls(scan, hits, rules, walls))


def _in_order(ranges: NDArray[np.float64], first: float, step: float) -> NDArray[np.float64]:
    """Return beams (n, 3), bearings rising; ranges are 0 where nothing came back."""
    bearings = bearings_of(len(ranges), first, step)
    usable = np.isfinite(ranges) & (ranges > 0.0)
    known = np.where(usable, ranges, 0.0)
    scan = np.stack([np.cos(bearings), np.sin(bearings), known], axis=1)
    if step < 0.0:
        scan = scan[::-1]
    return np.ascontiguousarray(scan)


@kernel
def find_walls(
    scan: NDArray[np.float64],
    hits: NDArray[np.int64],
    rules: Straightness,
    least: tuple[float, float, float, float],
) -> NDArray[np.float64]:
    """Return walls (w, 7): alpha and distance away from the laser, their covariance, two ends.

    Args:
        scan: (n, 3) beams, bearings rising; their range is 0 where nothing came back.
        hits: (k,) those of the scan that hit something.
        rules: what one wall is.
        least: length in m, beams, roughness, radius in m.
    """
    beams = scan[hits]
    pieces = split_scan(beams, rules)
    refine_borders(beams, pieces, rules)
    owner = merge_pieces(scan, hits, pieces, rules)
    walls = np.empty((len(pieces), 7))
    found = 0
    for i in range(len(pieces)):
        members = beams[owner == i]
        if len(members) < least[1]:
            continue
        line = fit_line(members, rules.noise)
        begin, end = math.inf, -math.inf
        for k in range(len(members)):
            place = place_along(members[k], line.alpha)
            begin, end = min(begin, place), max(end, place)
        _, rough = misfit(members, line, rules.noise)
        if end - begin < least[0] or rough > least[2]:
            continue
        if is_round(members, line, rules.noise, least[3]):
            continue
        walls[found, 0], walls[found, 1] = line.alpha, line.distance
        walls[found, 2], walls[found, 3] = line.var_alpha, line.cov
        walls[found, 4] = line.var_distance
        walls[found, 5], walls[found, 6] = begin, end
        found += 1
    return walls[:found]


def _as_lines(walls: NDArray[np.float64]) -> Lines:
    """Turn the normals of walls (w, 7) towards the laser, which stands in free space."""
    alpha, distance = walls[:, 0], walls[:, 1]
    normals = np.stack([np.cos(alpha), np.sin(alpha)], axis=1)
    along = np.stack([-normals[:, 1], normals[:, 0]], axis=1)
    foot = distance[:, None] * normals
    ends = foot[:, None] + walls[:, 5:7, None] * along[:, None]
    polar = np.stack([np.asarray(wrap(alpha + math.pi)), -distance], axis=1)
    covariances = np.empty((len(walls), 2, 2))
    covariances[:, 0, 0], covariances[:, 1, 1] = walls[:, 2], walls[:, 4]
    covariances[:, 0, 1] = covariances[:, 1, 0] = -walls[:, 3]
    return Lines(ends, polar, covariances)


def warm_up() -> None:
    """Compile the kernels for the types met in service."""
    extract_lines(np.ones(8), (-1.0, 0.1))
