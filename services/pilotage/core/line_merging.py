"""Kernels that put the pieces of one wall together again, whatever stands in front of it."""

import math

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.core.line_fit import BeamNoise, Fit, fit_line, mahalanobis, misfit
from pilotage.core.line_splitting import FRAGMENTS, Straightness, distance_along, widest_opening

NOBODY = -1
BEHIND = 0.1
"""m: a beam that ends this far beyond a wall went through an opening in it."""


@kernel
def merge_pieces(
    scan: NDArray[np.float64],
    hits: NDArray[np.int64],
    pieces: NDArray[np.int64],
    rules: Straightness,
) -> NDArray[np.int64]:
    """Return for each hit (k,) the number of its wall, NOBODY if it is alone.

    Args:
        scan: (n, 3) all beams; a range is 0 where nothing came back.
        hits: (k,) the beams of the scan that hit something.
        pieces: (p, 2) straight pieces of the hits, in order.
        rules: what one wall is.
    """
    beams = scan[hits]
    count = len(pieces)
    owner = np.full(len(hits), NOBODY)
    for i in range(count):
        if pieces[i, 1] > pieces[i, 0]:
            owner[pieces[i, 0] : pieces[i, 1] + 1] = i
    span = pieces.copy()
    # Pieces of one beam are never asked for theirs.
    fits = [_fit_of(beams, piece, rules.noise) for piece in pieces]
    for i in range(count):
        reached = i
        for j in range(i + 1, count):
            # Ahead, or back over the seam where the scan begins and ends.
            if j - reached > FRAGMENTS and i + count - j > FRAGMENTS:
                continue
            if owner[pieces[i, 0]] != i or owner[pieces[j, 0]] != j:
                continue
            ends = (hits[span[i, 0]], hits[span[i, 1]], hits[pieces[j, 0]], hits[pieces[j, 1]])
            unsure = i if fits[i].var_alpha > fits[j].var_alpha else j
            middle = beams[(pieces[unsure, 0] + pieces[unsure, 1]) // 2]
            if mahalanobis(fits[i], fits[j], middle) > rules.merge_chi2:
                continue
            way = _goes_on(scan, ends, fits[i], rules)
            together = beams[(owner == i) | (owner == j)]
            fit = fit_line(together, rules.noise)
            if way == 0 or misfit(together, fit, rules.noise)[0] > rules.split_sigmas:
                continue
            fits[i] = fit
            owner[pieces[j, 0] : pieces[j, 1] + 1] = i
            if way > 0:
                span[i, 1], reached = pieces[j, 1], j
            else:
                span[i, 0] = pieces[j, 0]
    return owner


@kernel
def _fit_of(beams: NDArray[np.float64], piece: NDArray[np.int64], noise: BeamNoise) -> Fit:
    """Return the line through a piece (2,) of beams (n, 3)."""
    return fit_line(beams[piece[0] : piece[1] + 1], noise)


@kernel
def _goes_on(
    scan: NDArray[np.float64],
    ends: tuple[int, int, int, int],
    line: Fit,
    rules: Straightness,
) -> int:
    """Say whether another piece continues a wall: 1 beyond its end, -1 before its start, 0 not.

    Args:
        scan: (n, 3) all beams.
        ends: first and last beam of the wall, first and last of the piece.
        line: the wall's.
        rules: what one wall is.
    """
    start, end, first, last = ends
    apart = distance_along(line, scan[end], scan[first])
    if apart < 0.0:
        # Only over the seam of a full turn does what comes later lie before.
        apart = distance_along(line, scan[last], scan[start])
        return -1 if apart <= widest_opening(line, scan[start], rules) else 0
    if apart <= widest_opening(line, scan[end], rules):
        return 1
    for k in range(end + 1, first):
        cos = math.cos(line.alpha) * scan[k, 0] + math.sin(line.alpha) * scan[k, 1]
        if scan[k, 2] == 0.0 or scan[k, 2] * cos > line.distance + BEHIND:
            return 0
    return 1 if apart <= rules.hidden_gap else 0


@kernel
def is_round(beams: NDArray[np.float64], line: Fit, noise: BeamNoise, radius: float) -> bool:
    """Say whether beams (m, 3) bulge from their line more like a disc of a radius, m, than not.

    The bulge is fitted as a parabola over the line; it must be plain beyond the noise.
    """
    cos, sin = math.cos(line.alpha), math.sin(line.alpha)
    along = beams[:, 2] * (cos * beams[:, 1] - sin * beams[:, 0])
    middle = 0.5 * (along.min() + along.max())
    half = max(0.5 * (along.max() - along.min()), 1e-6)
    shape = ((along - middle) / half) ** 2
    shape -= shape.mean()
    off = beams[:, 2] * (cos * beams[:, 0] + sin * beams[:, 1]) - line.distance
    power = (shape**2).sum()
    if power < 1e-9:
        return False
    bulge = (shape * (off - off.mean())).sum() / power
    sigma = math.hypot(noise.range_sigma, noise.wall_sigma) / math.sqrt(power)
    return bool(abs(bulge) > 3.0 * sigma and half * half / (2.0 * abs(bulge)) < radius)
