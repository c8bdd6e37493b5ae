"""Matching walls in turn as the matrices say it, in plain numpy.

The twin that the kernel is compared with in the tests and measured against.
"""

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.angles import wrap
from pilotage.localizer.line_ekf_kernels import Gate, Pieces

Array = NDArray[np.float64]


def plain_match(
    pose: Array, covariance: Array, seen: Pieces, known: Pieces, gate: Gate
) -> tuple[list[int], float, Array, Array]:
    """Return partners, log likelihood, and the pose and covariance that they lead to."""
    at, spread = pose.copy(), covariance.copy()
    partners, likelihood = [], 0.0
    for i in range(len(seen.polar)):
        gains = [_gain(at, spread, (seen, i), (known, j), gate) for j in range(len(known.polar))]
        best = int(np.argmax(gains)) if gains else 0
        if not gains or gains[best] == -np.inf:
            partners.append(-1)
            continue
        partners.append(best)
        likelihood += gains[best]
        residual, H, S = _innovation(at, spread, (seen, i), (known, best))
        K = spread @ H.T @ np.linalg.inv(S)
        at, spread = at + K @ residual, spread - K @ S @ K.T
    return partners, likelihood, at, spread


def _innovation(
    at: Array, spread: Array, seen: tuple[Pieces, int], known: tuple[Pieces, int]
) -> tuple[Array, Array, Array]:
    """Return residual (2,), jacobian (2, 3) of the measurement, and covariance (2, 2)."""
    (alpha, rho), wall = known[0].polar[known[1]], known[0].covariances[known[1]]
    normal = np.array([np.cos(alpha), np.sin(alpha)])
    expected = np.array([alpha - at[2], rho - normal @ at[:2]])
    residual = seen[0].polar[seen[1]] - expected
    residual[0] = wrap(float(residual[0]))
    H = np.array([[0.0, 0.0, -1.0], [-normal[0], -normal[1], 0.0]])
    # How the expected line moves with the wall of the map.
    J = np.array([[1.0, 0.0], [at[0] * np.sin(alpha) - at[1] * np.cos(alpha), 1.0]])
    S = H @ spread @ H.T + J @ wall @ J.T + seen[0].covariances[seen[1]]
    return residual, H, S


def _gain(
    at: Array, spread: Array, seen: tuple[Pieces, int], known: tuple[Pieces, int], gate: Gate
) -> float:
    """Return the log likelihood of a pair over that of an unmapped line, -inf if it is none."""
    residual, _, S = _innovation(at, spread, seen, known)
    squared = float(residual @ np.linalg.solve(S, residual))
    if abs(residual[0]) > gate.facing or squared > gate.squared:
        return -np.inf
    if _overlap(at, spread, seen[0].ends[seen[1]], known[0].ends[known[1]], gate) < gate.overlap:
        return -np.inf
    return -0.5 * (squared + float(np.log(np.linalg.det(2.0 * np.pi * S)))) - gate.clutter


def _overlap(at: Array, spread: Array, seen: Array, known: Array, gate: Gate) -> float:
    """Return the share of a seen piece, ends (2, 2) in base_link, along one of the map."""
    along = (known[1] - known[0]) / np.hypot(*(known[1] - known[0]))
    in_map = se2.transform_points(at, seen)
    low, high = sorted((in_map - known[0]) @ along)
    away = in_map.mean(axis=0) - at[:2]
    H = np.array([along[0], along[1], along @ np.array([-away[1], away[0]])])
    reach = gate.slack + 2.0 * np.sqrt(H @ spread @ H)
    length = float(np.hypot(*(known[1] - known[0])))
    return float((min(high, length + reach) - max(low, -reach)) / (high - low))
