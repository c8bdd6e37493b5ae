"""Ways drawn with few points."""

import numpy as np
from numpy.typing import NDArray


def simplified(way: NDArray[np.float64], tolerance: float) -> NDArray[np.float64]:
    """Return the points (k, 2) of a way (n, 2) from which no other is farther than this, m.

    First and last point stay (Ramer 1972, Douglas & Peucker 1973).
    """
    keeps = np.zeros(len(way), np.bool_)
    keeps[[0, -1]] = True
    spans = [(0, len(way) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        off = _distances(way[first + 1 : last], way[first], way[last])
        farthest = first + 1 + int(np.argmax(off))
        if off.max() > tolerance:
            keeps[farthest] = True
            spans += [(first, farthest), (farthest, last)]
    return way[keeps]


def _distances(
    points: NDArray[np.float64], start: NDArray[np.float64], end: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return how far points (n, 2) lie from a stretch, m."""
    run = end - start
    share = (points - start) @ run / max(float(run @ run), 1e-12)
    nearest = start + np.clip(share, 0.0, 1.0)[:, None] * run
    off = points - nearest
    distance: NDArray[np.float64] = np.hypot(off[:, 0], off[:, 1])
    return distance
