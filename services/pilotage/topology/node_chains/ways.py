"""Directions and places along the edges of a topological map."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.topology.topological_map import Edge

DIRECTION_FROM = 1.0
"""m along an edge within which it takes its direction; beyond, it may bend."""

ALIKE = float(np.deg2rad(25.0))
"""Ways round a node that differ by less are one: an arrival varies by about as much."""

APART = 0.5
"""m between places along an edge, at most: an arrival varies by half as much."""


def leaving(edge: Edge) -> tuple[float, float]:
    """Return the directions in which an edge leaves its start and its end, rad."""
    return _leaving(edge.way), _leaving(edge.way[::-1])


def distinct(directions: list[float]) -> NDArray[np.float64]:
    """Return directions that differ, in [-pi, pi): the first two, then others round from there."""
    turns = wrap(np.array(directions) - directions[0])
    kept = list(turns[:2])
    for turn in np.sort(turns[2:]):
        if np.abs(wrap(np.array(kept) - turn)).min() >= ALIKE:
            kept.append(turn)
    return wrap(directions[0] + np.array(kept))


def places_along(edge: Edge) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return poses (2 k, 3) between the ends of an edge, both ways round.

    And whether each is nearer to the start than to the end.
    """
    steps = np.hypot(*np.diff(edge.way, axis=0).T)
    gone = np.concatenate([[0.0], np.cumsum(steps)])
    # An even number: one in the middle would be as near to either end.
    count = 2 * int(np.ceil(gone[-1] / APART) / 2.0)
    if count <= 0:
        return np.empty((0, 3)), np.empty(0, bool)
    at = gone[-1] * np.arange(1, count + 1) / (count + 1)
    x, y = _points(edge, gone, at)
    ahead, behind = _points(edge, gone, at + APART), _points(edge, gone, at - APART)
    heading = np.arctan2(ahead[1] - behind[1], ahead[0] - behind[0])
    poses = np.stack([np.tile(x, 2), np.tile(y, 2), np.concatenate([heading, heading + np.pi])])
    poses[2] = wrap(poses[2])
    return poses.T, np.tile(at < gone[-1] / 2.0, 2)


def _points(edge: Edge, gone: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (2, k) so many metres along a way."""
    return np.stack([np.interp(at, gone, edge.way[:, axis]) for axis in (0, 1)])


def _leaving(way: NDArray[np.float64]) -> float:
    gone = np.hypot(*(way - way[0]).T)
    far = np.flatnonzero(gone >= DIRECTION_FROM)
    x, y = way[far[0] if len(far) else -1] - way[0]
    return float(np.arctan2(y, x))
