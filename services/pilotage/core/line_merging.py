"""Kernels that put the pieces of one wall together again, whatever stands in front of it."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel
from pilotage.core.line_fit import BeamNoise, Fit, fit_line, mahalanobis, misfit, normal_of
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
    hidden = not is_open(scan, (end, first), line)
    return 1 if hidden and apart <= rules.hidden_gap else 0


@kernel
def is_open(scan: NDArray[np.float64], between: tuple[int, int], line: Fit) -> bool:
    """Say whether one of the beams (n, 3) between two went through a line, or never came back."""
    normal = normal_of(line)
    for k in range(between[0] + 1, between[1]):
        depth = scan[k, 2] * (normal[0] * scan[k, 0] + normal[1] * scan[k, 1])
        if scan[k, 2] == 0.0 or depth > line.distance + BEHIND:
            return True
    return False
