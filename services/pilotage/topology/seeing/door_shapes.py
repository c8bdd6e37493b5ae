"""What a gap in a wall is by where the beams in it end: open, closed by a leaf, or a niche."""

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.seeing.door_gaps import Gap

FEWEST = 3
"""Beams in a gap that say anything about it."""
HALF, SOME, MOST = 0.5, 0.3, 0.75
"""Shares of its beams: some end on a jamb, some come back from nowhere."""
LEAF_ERROR, SLANT_ERROR, SIDE_ERROR = 0.03, 0.06, 0.06
"""m that beams may end beside a closed leaf, a slanting one, or what stands behind a jamb."""
AT_HINGE, LEAST_LEAF = 0.15, 0.5
"""m of depth at which a slanting leaf begins, and how long it is seen, in widths of its door."""


def is_open(gap: Gap, depth: float, room: float) -> bool:
    """Say whether most beams went on by `depth` m, and some of them by `room` m.

    Beams that meet the side of a jamb end earlier, those of a niche or of the wall behind two
    cupboards end before there is room to enter.
    """
    if len(gap.depths) < FEWEST:
        return False
    through = np.mean(gap.depths > depth) > HALF and np.mean(gap.depths > room) > SOME
    return bool(through or _shows_its_side(gap, room))


def _shows_its_side(gap: Gap, room: float) -> bool:
    """Say whether it is seen aslant: nothing but what leads from its farther jamb into the room."""
    for jamb in (gap.first, gap.second):
        at_jamb = np.abs(gap.ended - jamb.place) < SIDE_ERROR
        if at_jamb.mean() > MOST and gap.depths[at_jamb].max() > 0.75 * room:
            return True
    return False


def is_closed(gap: Gap, deepest: float) -> bool:
    """Say whether the beams end on a leaf that stands back from the wall by `deepest` m at most."""
    came_back = gap.depths[np.isfinite(gap.depths)]
    if len(came_back) < max(FEWEST, MOST * len(gap.depths)):
        return False
    middle = float(np.median(came_back))
    on_leaf = np.abs(came_back - middle) < LEAF_ERROR
    return bool(middle <= deepest and on_leaf.mean() > MOST)


def is_ajar(gap: Gap) -> bool:
    """Say whether half of the beams end on something straight that begins at a jamb: a leaf."""
    is_near = gap.depths < gap.width
    ended, depths = gap.ended[is_near], gap.depths[is_near]
    if len(depths) < max(FEWEST, HALF * len(gap.depths)):
        return False
    slope, base = _median_line(ended, depths)
    on_leaf = np.abs(slope * ended + base - depths) < SLANT_ERROR * np.hypot(1.0, slope)
    if on_leaf.sum() < max(FEWEST, HALF * len(gap.depths)):
        return False
    at_jambs = slope * np.array([gap.first.place, gap.second.place]) + base
    seen = np.hypot(np.ptp(ended[on_leaf]), np.ptp(depths[on_leaf]))
    return bool(np.abs(at_jambs).min() < AT_HINGE and seen > LEAST_LEAF * gap.width)


def _median_line(x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[float, float]:
    """Return slope and base of a line through points (n,) that a few strays do not turn.

    The median of the slopes between all pairs (Theil 1950).
    """
    one, other = np.triu_indices(len(x), 1)
    run = x[other] - x[one]
    apart = np.abs(run) > 1e-6
    if not apart.any():
        return 0.0, float(np.median(y))
    slope = float(np.median((y[other] - y[one])[apart] / run[apart]))
    return slope, float(np.median(y - slope * x))
