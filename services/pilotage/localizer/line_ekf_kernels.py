"""Which piece of the map's walls each piece is that a laser sees; plain twin in tests/naive.

A line is matched as its normal form says, by Mahalanobis distance, and as a piece: what is seen has
to lie along what the map shows. The pieces are taken in turn, the surest first, and each that is
matched corrects the pose that the next is expected from: so pairs fit each other, not only the
prediction, and a heading that one long wall has told no longer mixes up the short ones.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

Array = NDArray[np.float64]


class Pieces(NamedTuple):
    """Lines in one frame: `ends` (n, 2, 2), `polar` and `covariances` as in Lines."""

    ends: Array
    polar: Array
    covariances: Array


class Gate(NamedTuple):
    """What a seen piece and one of the map have to agree in.

    `squared`: most Mahalanobis distance squared. `facing` [rad]: most turn between the normals.
    `overlap`: least share of the seen piece that lies along the other. `slack` [m]: by which ends
    may be off, beside what the pose makes uncertain. `clutter`: log density of pieces that the map
    lacks, over alpha and rho.
    """

    squared: float
    facing: float
    overlap: float
    slack: float
    clutter: float


@kernel
def match_in_turn(
    pose: Array, covariance: Array, seen: Pieces, known: Pieces, gate: Gate
) -> tuple[NDArray[np.int64], float, Array, Array]:
    """Return for each seen piece (n,) the known one, -1 for none, and how likely that all is.

    And the pose (3,) and its covariance (3, 3) that they lead to.

    Args:
        pose: (3,) map_from_base, expected.
        covariance: (3, 3) of it.
        seen: in base_link, the surest first.
        known: in map.
        gate: what has to agree.

    The likelihood [nat] is that of the matched pieces over that of as many unmapped ones.
    """
    at, spread = pose.copy(), covariance.copy()
    partners = np.full(len(seen.polar), -1, np.int64)
    likelihood = 0.0
    for i in range(len(seen.polar)):
        best_gain = -np.inf
        for j in range(len(known.polar)):
            if abs(_turn(at, seen.polar[i], known.polar[j])) > gate.facing:
                continue
            squared, log_volume = _misfit(at, spread, (i, j), seen, known)
            gain = -0.5 * (squared + log_volume) - gate.clutter
            if squared > gate.squared or gain <= best_gain:
                continue
            if _overlap(at, spread, seen.ends[i], known.ends[j], gate.slack) >= gate.overlap:
                partners[i], best_gain = j, gain
        if partners[i] >= 0:
            likelihood += best_gain
            _correct(at, spread, (i, partners[i]), seen, known)
    return partners, likelihood, at, spread


@kernel
def _turn(at: Array, seen: Array, known: Array) -> float:
    """Return by how much a seen normal is turned from where it is expected [rad]."""
    off: float = (seen[0] - known[0] + at[2] + math.pi) % (2.0 * math.pi) - math.pi
    return off


@kernel
def _innovation(
    at: Array, spread: Array, pair: tuple[int, int], seen: Pieces, known: Pieces
) -> tuple[float, float, float]:
    """Return the innovation's covariance, s11, s12, s22: of pose, known line and seen line."""
    alpha = known.polar[pair[1], 0]
    c, s = math.cos(alpha), math.sin(alpha)
    lever = at[0] * s - at[1] * c
    C, R, P = known.covariances[pair[1]], seen.covariances[pair[0]], spread
    s11 = P[2, 2] + C[0, 0] + R[0, 0]
    s12 = c * P[0, 2] + s * P[1, 2] + lever * C[0, 0] + C[0, 1] + R[0, 1]
    s22 = c * c * P[0, 0] + 2.0 * c * s * P[0, 1] + s * s * P[1, 1] + R[1, 1]
    s22 += lever * lever * C[0, 0] + 2.0 * lever * C[0, 1] + C[1, 1]
    return s11, s12, s22


@kernel
def _residual(at: Array, seen: Array, known: Array) -> tuple[float, float]:
    """Return seen less expected, alpha [rad] and rho [m]."""
    expected = known[1] - at[0] * math.cos(known[0]) - at[1] * math.sin(known[0])
    return _turn(at, seen, known), seen[1] - expected


@kernel
def _misfit(
    at: Array, spread: Array, pair: tuple[int, int], seen: Pieces, known: Pieces
) -> tuple[float, float]:
    """Return the Mahalanobis distance squared, and the log of the innovation's volume."""
    turn, off = _residual(at, seen.polar[pair[0]], known.polar[pair[1]])
    s11, s12, s22 = _innovation(at, spread, pair, seen, known)
    determinant = s11 * s22 - s12 * s12
    squared = (s22 * turn * turn - 2.0 * s12 * turn * off + s11 * off * off) / determinant
    return squared, math.log(4.0 * math.pi**2 * determinant)


@kernel
def _overlap(at: Array, spread: Array, seen: Array, known: Array, slack: float) -> float:
    """Return the share of a seen piece, ends (2, 2) in base_link, along a known one in map."""
    along_x, along_y = known[1, 0] - known[0, 0], known[1, 1] - known[0, 1]
    length = math.hypot(along_x, along_y)
    along_x, along_y = along_x / length, along_y / length
    c, s = math.cos(at[2]), math.sin(at[2])
    low, high = np.inf, -np.inf
    lever = 0.0
    for x, y in seen:
        away_x, away_y = c * x - s * y, s * x + c * y
        way = (at[0] + away_x - known[0, 0]) * along_x + (at[1] + away_y - known[0, 1]) * along_y
        low, high = min(low, way), max(high, way)
        lever += 0.5 * (away_x * along_y - away_y * along_x)
    P = spread
    variance = along_x * along_x * P[0, 0] + 2.0 * along_x * along_y * P[0, 1]
    variance += along_y * along_y * P[1, 1] + lever * lever * P[2, 2]
    variance += 2.0 * lever * (along_x * P[0, 2] + along_y * P[1, 2])
    reach = slack + 2.0 * math.sqrt(max(variance, 0.0))
    shared = min(high, length + reach) - max(low, -reach)
    return shared / max(high - low, 1e-9)


@kernel
def _correct(at: Array, spread: Array, pair: tuple[int, int], seen: Pieces, known: Pieces) -> None:
    """Correct a pose (3,) and its covariance (3, 3) in place by one matched pair."""
    turn, off = _residual(at, seen.polar[pair[0]], known.polar[pair[1]])
    s11, s12, s22 = _innovation(at, spread, pair, seen, known)
    determinant = s11 * s22 - s12 * s12
    alpha = known.polar[pair[1], 0]
    c, s = math.cos(alpha), math.sin(alpha)
    gain = np.empty((3, 2))
    for k in range(3):
        to_turn, to_off = -spread[k, 2], -c * spread[k, 0] - s * spread[k, 1]
        gain[k, 0] = (to_turn * s22 - to_off * s12) / determinant
        gain[k, 1] = (to_off * s11 - to_turn * s12) / determinant
    for k in range(3):
        at[k] += gain[k, 0] * turn + gain[k, 1] * off
        for m in range(3):
            spread[k, m] -= gain[k, 0] * (s11 * gain[m, 0] + s12 * gain[m, 1]) + gain[k, 1] * (
                s12 * gain[m, 0] + s22 * gain[m, 1]
            )


def warm_up() -> None:
    """Compile the kernels on the smallest input."""
    one = Pieces(np.array([[[0.0, 0.0], [1.0, 0.0]]]), np.zeros((1, 2)), np.eye(2)[None])
    match_in_turn(np.zeros(3), np.eye(3), one, one, Gate(9.0, 0.5, 0.5, 0.1, -4.0))
