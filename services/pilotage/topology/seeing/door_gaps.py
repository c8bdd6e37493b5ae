"""Gaps in a wall: where beams went on beyond it between two pieces of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.topology.seeing.door_walls import Crossings

FEWEST = 5
"""Beams that a wall with a gap needs: two at each jamb, one through the gap."""
JAMB_BEAMS = 2
"""Beams of the first three beside a gap that must end on the wall: its jamb."""
THINNEST_WALL = 0.10
"""m: a beam that ends nearer behind the face of a wall ended between its jambs."""
NARROWEST = 0.4
"""m: narrower gaps are no way."""
BESIDE_BEAMS, BESIDE_ERROR, BESIDE_DEPTH = 3, 0.04, 0.5
"""So many beams next to a gap end within so much of its jamb, m, the first so near the wall, m:
on a leaf that stands open before the wall, or on a side wall that the jamb is flush with."""
HIDDEN = 0.5
"""m of wall that may be hidden in one piece beside a gap; what is farther is another wall."""


@dataclass(frozen=True)
class Jamb:
    """An end of a gap: `place` along the wall and its `variance`, m and m^2."""

    place: float
    variance: float


@dataclass(frozen=True)
class Gap:
    """A gap between two jambs.

    Its beams ended beside the places `ended` (k,) along the wall, `depths` (k,) m beyond it.
    `sides`: how much wall is seen before the first and after the second, m.
    """

    first: Jamb
    second: Jamb
    ended: NDArray[np.float64]
    depths: NDArray[np.float64]
    sides: tuple[float, float] = (np.inf, np.inf)

    @property
    def width(self) -> float:
        """Distance between its jambs, m."""
        return self.second.place - self.first.place


def gaps_in(met: Crossings, tolerance: float, widest: float) -> list[Gap]:
    """Return the gaps of at most `widest` m; a beam within `tolerance` m of the wall ended on it.

    Other beams that ended before the wall (people, furniture) tell nothing.
    """
    tells = (met.depths > -tolerance) | _beside_a_gap(met, tolerance)
    places, ended = met.places[tells], met.ended[tells]
    depths, steps = met.depths[tells], met.steps[tells]
    if len(places) < FEWEST:
        return []
    is_beyond = _without_strays(depths > tolerance)
    before, after = _wall_beside(places, is_beyond)
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
        sides = float(before[begin]), float(after[end + 1])
        gap = Gap(first, second, ended[inside], depths[inside], sides)
        if NARROWEST <= gap.width <= widest:
            gaps.append(gap)
    return gaps


def _wall_beside(
    places: NDArray[np.float64], is_beyond: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how much wall, m, leads up to each beam (n,) and on from it, without a break."""
    follows = ~is_beyond[1:] & ~is_beyond[:-1] & (np.diff(places) < HIDDEN)
    run = np.concatenate([[0], np.cumsum(~follows)])
    _, starts, counts = np.unique(run, return_index=True, return_counts=True)
    low, high = places[starts][run], places[starts + counts - 1][run]
    return places - low, high - places


def _beside_a_gap(met: Crossings, tolerance: float) -> NDArray[np.bool_]:
    """Find beams (n,) that end before the wall, but on what begins at the jamb of a gap."""
    beside = np.zeros(len(met.places), bool)
    is_beyond = met.depths > tolerance
    for along in (slice(None), slice(None, None, -1)):
        beyond, ended = is_beyond[along], met.ended[along]
        for last in np.flatnonzero(beyond[:-BESIDE_BEAMS] & ~beyond[1 : 1 - BESIDE_BEAMS]):
            run = slice(last + 1, last + 1 + BESIDE_BEAMS)
            starts_there = met.depths[along][last + 1] > -BESIDE_DEPTH
            if starts_there and not beyond[run].any() and np.ptp(ended[run]) < BESIDE_ERROR:
                beside[along][run] = True
    return beside


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
