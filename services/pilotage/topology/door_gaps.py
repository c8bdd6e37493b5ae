"""Gaps in a wall: where beams went on beyond it between two pieces of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.door_walls import Crossings

JAMB_BEAMS = 2
"""Beams of the first three beside a gap that must end on the wall: its jamb."""
THINNEST_WALL = 0.10
"""m: a beam that ends nearer behind the face of a wall ended between its jambs."""
NARROWEST = 0.4
"""m: narrower gaps are no way."""
MOST = 0.75
"""Share of a leaf's beams that must agree; some end on a jamb, some come back from nowhere."""
LEAF_ERROR = 0.03
"""m that beams on a leaf may lie off a straight line."""


@dataclass(frozen=True)
class Jamb:
    """An end of a gap: `place` along the wall and its `variance`, m and m^2."""

    place: float
    variance: float


@dataclass(frozen=True)
class Gap:
    """A gap between two jambs.

    `depths` (k,) m beyond the wall at which its beams ended, at `places` (k,) along the wall.
    """

    first: Jamb
    second: Jamb
    places: NDArray[np.float64]
    depths: NDArray[np.float64]

    @property
    def width(self) -> float:
        """Distance between its jambs, m."""
        return self.second.place - self.first.place

    def is_open(self, depth: float) -> bool:
        """Say whether most of its beams went on by `depth` m, the thickness of the wall and more.

        Beams that meet the side of a jamb end earlier, those of a leaf all do.
        """
        return bool(np.mean(self.depths > depth) > 0.5)

    def has_leaf(self, shallowest: float, deepest: float) -> bool:
        """Say whether its beams end on something straight, between these depths (m) on average.

        A leaf that is closed lies at one depth; one that is ajar begins at a jamb.
        """
        came_back = np.isfinite(self.depths)
        if came_back.sum() < 3 or came_back.mean() < MOST:
            return False
        places, depths = self.places[came_back], self.depths[came_back]
        middle = float(np.median(depths))
        if not shallowest <= middle <= deepest:
            return False
        if np.mean(np.abs(depths - middle) < LEAF_ERROR) > MOST:
            return True
        slope, base = np.polyfit(places, depths, 1)
        off = np.abs(slope * places + base - depths)
        at_jambs = slope * np.array([self.first.place, self.second.place]) + base
        return bool(np.mean(off < LEAF_ERROR) > MOST and np.abs(at_jambs).min() < 0.15)


def gaps_in(met: Crossings, tolerance: float, widest: float) -> list[Gap]:
    """Return the gaps of at most `widest` m; a beam within `tolerance` m of the wall ended on it.

    Beams that ended before the wall (people, furniture) tell nothing.
    """
    tells = met.depths > -tolerance
    places, ended = met.places[tells], met.ended[tells]
    depths, steps = met.depths[tells], met.steps[tells]
    is_beyond = _without_strays(depths > tolerance)
    begins = np.flatnonzero(~is_beyond[:-1] & is_beyond[1:])
    ends = np.flatnonzero(is_beyond[:-1] & ~is_beyond[1:])
    gaps = []
    for begin in begins:
        later = ends[ends > begin]
        if len(later) == 0 or not _has_jambs(is_beyond, int(begin), int(later[0])):
            continue
        end = int(later[0])
        inside = slice(begin + 1, end + 1)
        shallow = depths[inside] < THINNEST_WALL
        reached = np.concatenate([places[inside], ended[inside][shallow]])
        first = _jamb(ended[begin], float(reached.min()), steps[begin])
        second = _jamb(ended[end + 1], float(reached.max()), steps[end])
        gap = Gap(first, second, places[begin + 1 : end + 1], depths[begin + 1 : end + 1])
        if NARROWEST <= gap.width <= widest:
            gaps.append(gap)
    return gaps


def _without_strays(is_beyond: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the mask (n,) with single beams that differ from both neighbours turned over."""
    if len(is_beyond) < 3:
        return is_beyond
    alone = np.zeros_like(is_beyond)
    alone[1:-1] = (is_beyond[1:-1] != is_beyond[:-2]) & (is_beyond[1:-1] != is_beyond[2:])
    # Of a run like 0101 only every other one is a stray: turn over none that a stray decided.
    alone[1:] &= ~alone[:-1]
    return is_beyond ^ alone


def _has_jambs(is_beyond: NDArray[np.bool_], begin: int, end: int) -> bool:
    before = ~is_beyond[max(begin - 2, 0) : begin + 1]
    after = ~is_beyond[end + 1 : end + 4]
    return bool(before.sum() >= JAMB_BEAMS and after.sum() >= JAMB_BEAMS)


def _jamb(on_wall: float, reached: float, step: float) -> Jamb:
    """Return the jamb between where a beam ended on the wall and what a beam in the gap reached.

    It lies anywhere between them with equal probability.
    """
    spread = max(abs(reached - on_wall), float(step) / 2.0)
    return Jamb(float(on_wall + reached) / 2.0, spread**2 / 12.0)
