"""What rides along the corridor show, in figures for `report.json`; pure."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pilotage.experiments.hybrid_trial import Ride

FOUND = 0.25, float(np.deg2rad(5.0))
"""m and rad within which the robot knows where it is."""
NORMAL_PAIRS = 2
"""Pairs in the cycle after a node from which on tracking goes on."""


def ride_figures(rides: Sequence[Ride]) -> dict[str, object]:
    """Return pairs a cycle and errors of the pose, with their spread over the rides."""
    pairs = np.array([ride.pairs for ride in rides])
    corners = np.array([[cycle.tracked.corners for cycle in ride.cycles] for ride in rides])
    errors = np.array([ride.errors for ride in rides])
    at_nodes = [
        cycle.correction.features
        for ride in rides
        for cycle in ride.cycles
        if cycle.tracked.node >= 0
    ]
    return {
        "mean_matched_pairs": float(pairs.mean()),
        "mean_matched_pairs_std": float(pairs.mean(axis=1).std()),
        "mean_matched_pairs_of_each_run": _rounded(pairs.mean(axis=1)),
        "matched_pairs_by_cycle": _rounded(pairs.mean(axis=0)),
        "mean_matched_corners": float(corners.mean()),
        "matched_features_at_a_node": float(np.mean(at_nodes)) if at_nodes else None,
        "error_m": _spread(errors[..., 0]),
        "error_rad": _spread(errors[..., 1]),
    }


def collision_figures(rides: Sequence[Ride]) -> dict[str, object]:
    """Return what becomes of the pairs after a collision, and whether the next node helps."""
    after = [ride.pairs[ride.collision : _until(ride)] for ride in rides]
    later = [ride.pairs[_until(ride) :] for ride in rides]
    recovered = [recovered_at_next_node(ride) for ride in rides]
    return {
        "pairs_before_collision": float(np.mean([_mean(r.pairs[: r.collision]) for r in rides])),
        "pairs_from_collision_to_next_node": float(np.mean([_mean(part) for part in after])),
        "pairs_after_next_node": float(np.mean([_mean(part) for part in later])),
        "recovered_at_next_node": float(np.mean(recovered)),
        "lost_at_the_end": float(np.mean([not is_found(ride, -1) for ride in rides])),
        "error_at_the_end_m": _rounded(np.array([ride.errors[-1, 0] for ride in rides])),
    }


def recovered_at_next_node(ride: Ride) -> bool:
    """Say whether the pose is right from the first node after the collision, and pairs are back."""
    node = ride.next_node
    if node is None or node + 1 >= len(ride.cycles):
        return False
    is_back = bool(ride.pairs[node + 1] >= NORMAL_PAIRS)
    return is_found(ride, node) and is_found(ride, node + 1) and is_back


def is_found(ride: Ride, cycle: int) -> bool:
    """Say whether the pose is right after a cycle."""
    metres, radians = ride.errors[cycle]
    return bool(metres <= FOUND[0] and radians <= FOUND[1])


def _until(ride: Ride) -> int:
    """Return the cycle after the one in which the next node was reached, or the last."""
    return len(ride.cycles) - 1 if ride.next_node is None else ride.next_node + 1


def _mean(pairs: NDArray[np.int64]) -> float:
    return float(pairs.mean()) if len(pairs) else 0.0


def _spread(values: NDArray[np.float64]) -> dict[str, float]:
    return {
        "median": float(np.median(values)),
        "p95": float(np.percentile(values, 95.0)),
        "max": float(values.max()),
    }


def _rounded(values: NDArray[np.float64]) -> list[float]:
    return [round(float(value), 3) for value in values]
