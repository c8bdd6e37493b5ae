"""Kernels that vote for poses and settle them; their twins are in tests/naive/node_matching.py."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.jit import kernel

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

STEPS = 6
"""Rounds of choosing pairs and moving the pose; two or three settle it, as a rule."""


@kernel
def turn_between(seen: float, bound: float, period: float) -> float:
    """Return the turn (rad) from one direction to another that repeats after `period`."""
    return (bound - seen + 0.5 * period) % period - 0.5 * period


@kernel
def count_votes(
    poses: Array, places: Array, spreads: Array, members: Indices, counts: tuple[int, int]
) -> Array:
    """Return how many of the pairs agree with each pose, less what they miss each other by.

    Args:
        poses: (h, 3) of base_link in map.
        places: (p, 7) of each pair: seen x, y, direction (base_link), bound x, y, direction (map),
            period of the direction (rad).
        spreads: (p, 2) squared distance (m^2) and squared angle (rad^2) beyond which a pair fails.
        members: (p, 2) indices of the seen and the bound feature of each pair.
        counts: how many features are seen and bound.

    Returns:
        (h,): each seen feature votes with its best pair, and so does each bound one; the fewer
        votes count, so that nothing is matched twice.
    """
    votes = np.zeros(len(poses))
    by_seen, by_bound = np.zeros(counts[0]), np.zeros(counts[1])
    for h in range(len(poses)):
        cos, sin = np.cos(poses[h, 2]), np.sin(poses[h, 2])
        by_seen[:] = 0.0
        by_bound[:] = 0.0
        for p in range(len(places)):
            dx = poses[h, 0] + cos * places[p, 0] - sin * places[p, 1] - places[p, 3]
            dy = poses[h, 1] + sin * places[p, 0] + cos * places[p, 1] - places[p, 4]
            far = (dx * dx + dy * dy) / spreads[p, 0]
            if far >= 1.0:
                continue
            turn = turn_between(places[p, 2] + poses[h, 2], places[p, 5], places[p, 6])
            worth = 1.0 - far - turn * turn / spreads[p, 1]
            if worth > 0.0:
                i, j = members[p, 0], members[p, 1]
                by_seen[i] = max(by_seen[i], worth)
                by_bound[j] = max(by_bound[j], worth)
        votes[h] = min(by_seen.sum(), by_bound.sum())
    return votes


@kernel
def pair_residuals(
    pose: Array, places: Array, covariances: Array, direction_variance: float
) -> tuple[Array, Array, Array]:
    """Return by how much each pair misses at a pose.

    Args:
        pose: (3,) of base_link in map.
        places: (p, 7) as in count_votes.
        covariances: (p, 2, 2, 2) of the seen place (base_link) and of the bound place (map), m^2.
        direction_variance: of a direction seen against the bound one, rad^2.

    Returns:
        Residuals (p, 3) bound less seen in map (m, m, rad), weights (p, 2, 2) = inverse covariances
        of the first two, and squared Mahalanobis distances (p,) of all three.
    """
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    residuals = np.empty((len(places), 3))
    weights = np.empty((len(places), 2, 2))
    distances = np.empty(len(places))
    for p in range(len(places)):
        x, y = places[p, 0], places[p, 1]
        residuals[p, 0] = places[p, 3] - pose[0] - cos * x + sin * y
        residuals[p, 1] = places[p, 4] - pose[1] - sin * x - cos * y
        residuals[p, 2] = turn_between(places[p, 2] + pose[2], places[p, 5], places[p, 6])
        # The seen covariance turned into map, and the bound one.
        seen, spread = covariances[p, 0], covariances[p, 1].copy()
        mixed = 2.0 * cos * sin * seen[0, 1]
        spread[0, 0] += cos * cos * seen[0, 0] - mixed + sin * sin * seen[1, 1]
        spread[1, 1] += sin * sin * seen[0, 0] + mixed + cos * cos * seen[1, 1]
        spread[0, 1] += cos * sin * (seen[0, 0] - seen[1, 1]) + (cos**2 - sin**2) * seen[0, 1]
        determinant = spread[0, 0] * spread[1, 1] - spread[0, 1] ** 2
        weights[p, 0, 0], weights[p, 1, 1] = spread[1, 1] / determinant, spread[0, 0] / determinant
        weights[p, 0, 1] = weights[p, 1, 0] = -spread[0, 1] / determinant
        a, b = residuals[p, 0], residuals[p, 1]
        distances[p] = (
            weights[p, 0, 0] * a * a
            + 2.0 * weights[p, 0, 1] * a * b
            + weights[p, 1, 1] * b * b
            + residuals[p, 2] * residuals[p, 2] / direction_variance
        )
    return residuals, weights, distances


@kernel
def choose_pairs(distances: Array, members: Indices, counts: tuple[int, int], gate: float) -> Mask:
    """Return which pairs (p,) to keep: the nearest first, below the gate, each feature once."""
    chosen = np.zeros(len(distances), np.bool_)
    has_seen, has_bound = np.zeros(counts[0], np.bool_), np.zeros(counts[1], np.bool_)
    for p in np.argsort(distances):
        i, j = members[p, 0], members[p, 1]
        if distances[p] > gate:
            break
        if not has_seen[i] and not has_bound[j]:
            chosen[p] = has_seen[i] = has_bound[j] = True
    return chosen


@kernel
def normal_equations(
    pose: Array, places: Array, residuals: Array, weights: Array, direction_variance: float
) -> tuple[Array, Array]:
    """Return the information (3, 3) and the right hand side (3,) of a step of the pose."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    information, pull = np.zeros((3, 3)), np.zeros(3)
    # How the place of the pair in map moves with x, y and theta.
    jacobian = np.zeros((2, 3))
    jacobian[0, 0] = jacobian[1, 1] = 1.0
    for p in range(len(places)):
        jacobian[0, 2] = -sin * places[p, 0] - cos * places[p, 1]
        jacobian[1, 2] = cos * places[p, 0] - sin * places[p, 1]
        for a in range(3):
            for u in range(2):
                for v in range(2):
                    lever = jacobian[u, a] * weights[p, u, v]
                    pull[a] += lever * residuals[p, v]
                    for b in range(3):
                        information[a, b] += lever * jacobian[v, b]
        information[2, 2] += 1.0 / direction_variance
        pull[2] += residuals[p, 2] / direction_variance
    return information, pull


@kernel
def triple(a: Array, b: Array, c: Array) -> float:
    """Return the volume spanned by three vectors (3,)."""
    volume: float = (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
    return volume


@kernel
def solve_three(matrix: Array, right: Array) -> Array:
    """Return x (3,) with `matrix` (3, 3) x = `right` (3,), by cross products (Cramer's rule)."""
    first, second, third = matrix[:, 0], matrix[:, 1], matrix[:, 2]
    volume = triple(first, second, third)
    return (
        np.array(
            [
                triple(right, second, third),
                triple(first, right, third),
                triple(first, second, right),
            ]
        )
        / volume
    )


@kernel
def settle(
    pose: Array,
    pairs: tuple[Array, Array, Indices],
    counts: tuple[int, int],
    direction_variance: float,
    gates: tuple[float, float],
) -> tuple[Array, Array, Mask, Array]:
    """Choose pairs and move the pose by weighted least squares until the choice stands.

    Args:
        pose: (3,) of base_link in map, to begin with.
        pairs: places (p, 7), covariances (p, 2, 2, 2) and members (p, 2) of the pairs.
        counts: how many features are seen and bound.
        direction_variance: rad^2.
        gates: squared Mahalanobis distance up to which a pair is kept, at first and at last.

    Returns:
        The pose (3,), its information (3, 3), which pairs are kept (p,) and their distances (p,).
    """
    places, covariances, members = pairs
    settled = pose.copy()
    gate = gates[0]
    residuals, weights, distances = pair_residuals(settled, places, covariances, direction_variance)
    chosen = choose_pairs(distances, members, counts, gate)
    information = np.zeros((3, 3))
    for step in range(STEPS):
        if not chosen.any():
            break
        information, pull = normal_equations(
            settled, places[chosen], residuals[chosen], weights[chosen], direction_variance
        )
        settled += solve_three(information, pull)
        residuals, weights, distances = pair_residuals(
            settled, places, covariances, direction_variance
        )
        last, gate = chosen, gates[1] if step > 0 else gate
        chosen = choose_pairs(distances, members, counts, gate)
        if step > 1 and (chosen == last).all():
            break
    settled[2] = (settled[2] + np.pi) % (2.0 * np.pi) - np.pi
    return settled, information, chosen, distances
