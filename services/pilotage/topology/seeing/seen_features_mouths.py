"""Mouths of corridors in one scan: where two walls that face each other end and the space goes on.

Gaps within one wall are found as doors are (`seen_doors`). A mouth is seen by those who stand in
the corridor that ends, or look into one: its two walls are parallel, not in line with each other.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.topology.features import KINDS, Features
from pilotage.topology.seeing.scan_view import ScanView

PASSAGE = KINDS.index("passage")


@dataclass(frozen=True)
class MouthParams:
    """What counts as a mouth; lengths in m, angles in rad."""

    widths: tuple[float, float] = (0.7, 3.0)
    """Least and greatest distance between the two walls."""
    least_wall: float = 0.8
    """Shorter lines are no walls of a corridor."""
    parallel: float = 0.14
    """By how much the walls may differ in direction."""
    skew: float = 0.5
    """By how far one wall may end before the other."""
    depth: float = 1.0
    """How far beams must go on beyond the mouth."""
    widening: float = 0.6
    """By how much the space beyond must be wider, at either side."""
    goes_on: float = 4.0
    """If a wall continues in line within this, the corridor does, and what is there is a door."""
    reach: float = 6.0
    """Farther walls are seen too thinly."""
    sigma: float = 0.1
    """The end of a wall is seen this exactly, where its last beam ended."""


def seen_mouths(view: ScanView, params: MouthParams) -> Features:
    """Return the mouths of corridors seen, in base_link, walked through along the corridor."""
    walls = view.lines.chosen(view.lines.lengths >= params.least_wall)
    found = [
        mouth
        for one in range(len(walls))
        for other in range(one + 1, len(walls))
        for mouth in _between(view, (walls.ends[one], walls.ends[other]), params)
    ]
    if not found:
        return Features.none()
    poses = np.array([pose for pose, _ in found])
    widths = np.array([width for _, width in found])
    spread = np.tile(params.sigma**2 * np.eye(2), (len(found), 1, 1))
    return Features(np.full(len(found), PASSAGE), poses, widths, spread).moved(view.mount)


def _between(
    view: ScanView, walls: tuple[NDArray[np.float64], NDArray[np.float64]], params: MouthParams
) -> list[tuple[NDArray[np.float64], float]]:
    """Return pose (3,) in the laser's frame and width of the mouths of two walls (2, 2) each."""
    one, other = walls
    along, across = _direction(one), _direction(other)
    # Free space lies on the left of both, so walls that face each other run against each other.
    if along @ across > -np.cos(params.parallel):
        return []
    normal = np.array([-along[1], along[0]])
    width = float((other.mean(axis=0) - one.mean(axis=0)) @ normal)
    if not params.widths[0] <= width <= params.widths[1]:
        return []
    ends = ((one[1], other[0], 1.0), (one[0], other[1], -1.0))
    mouths = [_mouth(view, (a, b), sign * along, params) for a, b, sign in ends]
    return [(mouth, width) for mouth in mouths if mouth is not None]


def _direction(wall: NDArray[np.float64]) -> NDArray[np.float64]:
    run = wall[1] - wall[0]
    direction: NDArray[np.float64] = run / np.hypot(*run)
    return direction


def _mouth(
    view: ScanView,
    jambs: tuple[NDArray[np.float64], NDArray[np.float64]],
    outward: NDArray[np.float64],
    params: MouthParams,
) -> NDArray[np.float64] | None:
    """Return the pose (3,) of a mouth between two ends of walls, None if the space ends there."""
    middle = (jambs[0] + jambs[1]) / 2.0
    apart = jambs[1] - jambs[0]
    if np.hypot(*middle) > params.reach or abs(apart @ outward) > params.skew:
        return None
    mouth = np.array([*middle, np.arctan2(outward[1], outward[0])])
    half = abs(float(apart @ (-outward[1], outward[0]))) / 2.0
    if not _goes_on(view, mouth, half, params.depth):
        return None
    is_hit = np.isfinite(view.ranges)
    hits = view.directions[is_hit] * view.ranges[is_hit, None]
    beyond, aside = se2.transform_points(se2.inverse(mouth), hits).T
    widens = [_widens(beyond, side * aside - half, params) for side in (1.0, -1.0)]
    return mouth if any(widens) else None


def _goes_on(view: ScanView, mouth: NDArray[np.float64], half: float, depth: float) -> bool:
    """Say whether the beams between the jambs, which are `half` m from the middle, go on beyond."""
    start = se2.inverse(mouth)
    cos, sin = np.cos(start[2]), np.sin(start[2])
    ahead = view.directions @ (cos, -sin)
    aside = view.directions @ (sin, cos)
    if start[0] >= 0.0:
        return False
    distances = -start[0] / np.where(ahead > 0.05, ahead, np.nan)
    between = np.abs(start[1] + aside * distances) < 0.8 * half
    further = ((view.ranges - distances) * ahead)[between]
    return len(further) >= 5 and bool(np.median(further) >= depth)


def _widens(beyond: NDArray[np.float64], outside: NDArray[np.float64], params: MouthParams) -> bool:
    """Say whether hits, by how far beyond and how far outside the walls' line, show more room.

    A door in the wall of a corridor lets beams out, too, but behind it the wall goes on.
    """
    wider = (outside > params.widening) & (beyond > 0.1)
    on_wall = (np.abs(outside) < 0.25) & (beyond > 0.3) & (beyond < params.goes_on)
    return bool(wider.sum() >= 3 and _extent(beyond[on_wall]) < 0.5)


def _extent(values: NDArray[np.float64]) -> float:
    return float(np.ptp(values)) if len(values) else 0.0
