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
from pilotage.core.line_fit import BeamNoise, fit_line
from pilotage.core.line_merging import merge_pieces
from pilotage.core.line_splitting import Straightness, refine_borders, split_scan
from pilotage.core.line_verdict import Demands, extent, is_wall
from pilotage.core.lines import Lines
from pilotage.core.scans import Ranges, bearings_of

USUAL_LASER = BeamNoise()
FARTHEST = 1e5
"""m: no laser of a robot measures this."""


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
    open_share: float = 0.25
    """Of a wall's length, beams may go through so much: two legs are straight, but no wall."""


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
    return _as_lines(find_walls(scan, hits, rules, _demands(params)))


def _demands(params: LineParams) -> Demands:
    """Return what the verdict's kernel needs to know."""
    return Demands(
        params.least_length,
        float(params.least_beams),
        params.most_rough,
        params.round_radius,
        params.open_share,
    )


def _in_order(ranges: NDArray[np.float64], first: float, step: float) -> NDArray[np.float64]:
    """Return beams (n, 3), bearings rising; ranges are 0 where nothing came back."""
    bearings = bearings_of(len(ranges), first, step)
    usable = (ranges > 0.0) & (ranges < FARTHEST)
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
    demands: Demands,
) -> NDArray[np.float64]:
    """Return walls (w, 7): alpha and distance away from the laser, their covariance, two ends.

    Args:
        scan: (n, 3) beams, bearings rising; their range is 0 where nothing came back.
        hits: (k,) those of the scan that hit something.
        rules: what one wall is.
        demands: what a wall must be.
    """
    beams = scan[hits]
    pieces = split_scan(beams, rules)
    refine_borders(beams, pieces, rules)
    owner = merge_pieces(scan, hits, pieces, rules)
    walls = np.empty((len(pieces), 7))
    found = 0
    for i in range(len(pieces)):
        numbers = hits[owner == i]
        if len(numbers) < 2:
            continue
        line = fit_line(scan[numbers], rules.noise)
        if not is_wall(scan, numbers, line, rules, demands):
            continue
        begin, end = extent(scan[numbers], line)
        row = (line.alpha, line.distance, line.var_alpha, line.cov, line.var_distance, begin, end)
        walls[found] = np.array(row)
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
