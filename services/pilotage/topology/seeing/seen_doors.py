"""Doors and passages in one scan, and in the vertical edges that a camera sees with it.

A door is a gap in a wall of the laser, or a leaf a little behind it, between two vertical edges of
its frame, which say more exactly than the beams where the jambs are (Zhuang et al. 2005, 2.2). Of
a closed door that is flush with its wall the laser sees nothing: its frame, seen by the camera, is
all there is. Without a camera a gap or a leaf alone is a door, less exactly.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.topology.features import KINDS, Features
from pilotage.topology.seeing.door_edges import SeenEdges
from pilotage.topology.seeing.door_frames import framed_doors, sharpened
from pilotage.topology.seeing.door_gaps import Gap, gaps_in
from pilotage.topology.seeing.door_shapes import is_ajar, is_closed, is_open
from pilotage.topology.seeing.door_walls import Wall, crossings, edges_on, walls_of
from pilotage.topology.seeing.scan_view import ScanView

DOOR, PASSAGE = KINDS.index("door"), KINDS.index("passage")


@dataclass(frozen=True)
class DoorParams:
    """What counts as a door; lengths in m."""

    widths: tuple[tuple[float, float], ...] = ((0.6, 1.3), (1.6, 2.05))
    """Least and greatest width of a door, and of a double door."""
    widest_passage: float = 3.5
    """Wider openings are rooms."""
    reach: float = 6.0
    """Farther walls are seen too thinly."""
    least_wall: float = 0.6
    """Wall that must be seen beside a gap, in all."""
    side: float = 0.5
    """Of it on the better side of a gap, or on either side of one wider than a door."""
    on_wall: float = 0.04
    """A beam that ends this near a wall ended on it: four sigma of a laser's range."""
    open_depth: float = 0.35
    """Beams that go on this far beyond a wall are through it."""
    room_depth: float = 0.9
    """Some beams through an opening go on this far: there is room to enter."""
    deepest_leaf: float = 0.25
    """How far behind the face of a wall a closed leaf is looked for."""
    along_sigma: float = 0.01
    """How far jambs are rounded, bowed and out of plumb."""
    behind: float = 0.07
    """How far behind the face that is seen the middle of a door lies: half of a usual wall."""
    across_sigma: float = 0.05
    """By how much walls differ from that."""
    jamb_sigma_max: float = 0.12
    """A jamb that is known worse is none: its gap is seen too thinly."""


def seen_doors(
    view: ScanView, edges: SeenEdges | None = None, params: DoorParams | None = None
) -> Features:
    """Return doors and passages seen, in base_link, in the middle of their wall's thickness.

    `edges` are in base_link at the time of the scan; None without a camera.
    """
    chosen = params or DoorParams()
    seen = None if edges is None else edges.moved(se2.inverse(view.mount))
    parts = [
        _on_wall(view, wall, seen, chosen)
        for wall in walls_of(view, chosen.least_wall)
        if -chosen.reach < wall.rho < 0.0
    ]
    return Features.joined(parts).moved(view.mount)


def _on_wall(view: ScanView, wall: Wall, edges: SeenEdges | None, params: DoorParams) -> Features:
    """Return what one wall holds, in the laser's frame."""
    met = crossings(view, wall, params.reach)
    gaps = gaps_in(met, params.on_wall, params.widest_passage)
    if edges is None:
        return _features(wall, gaps, params)
    placed = edges_on(edges, wall, params.reach)
    found = [sharpened(gap, placed) for gap in gaps]
    flush = framed_doors(met, placed, params.on_wall, params.widths[0])
    elsewhere = [one for one in flush if not any(_overlap(one, other) for other in found)]
    return _features(wall, [*found, *elsewhere], params)


def _features(wall: Wall, gaps: list[Gap], params: DoorParams) -> Features:
    """Return those gaps that are doors or passages."""
    kinds = [_kind(gap, params) for gap in gaps]
    named = [(kind, gap) for kind, gap in zip(kinds, gaps, strict=True) if kind is not None]
    if not named:
        return Features.none()
    middles = [(gap.first.place + gap.second.place) / 2.0 for _, gap in named]
    heading = float(np.arctan2(-wall.normal[1], -wall.normal[0]))
    inwards = params.behind * wall.normal
    return Features(
        np.array([kind for kind, _ in named], np.int64),
        np.array([(*(wall.point(place) - inwards), heading) for place in middles]),
        np.array([gap.width for _, gap in named]),
        np.array([_covariance(wall, gap, params) for _, gap in named]),
    )


def _kind(gap: Gap, params: DoorParams) -> int | None:
    """Return DOOR, PASSAGE, or None for a niche, a shadow or a gap seen too thinly."""
    if max(gap.first.variance, gap.second.variance) > params.jamb_sigma_max**2:
        return None
    is_wide = gap.width > params.widths[0][1]
    if (min if is_wide else max)(gap.sides) < params.side:
        return None
    has_width = any(least <= gap.width <= most for least, most in params.widths)
    if is_open(gap, params.open_depth, params.room_depth):
        return DOOR if has_width else PASSAGE
    has_leaf = has_width and (is_closed(gap, params.deepest_leaf) or is_ajar(gap))
    return DOOR if has_leaf else None


def _covariance(wall: Wall, gap: Gap, params: DoorParams) -> NDArray[np.float64]:
    along = (gap.first.variance + gap.second.variance) / 4.0 + params.along_sigma**2
    across = wall.sigma**2 + params.across_sigma**2
    return along * np.outer(wall.tangent, wall.tangent) + across * np.outer(
        wall.normal, wall.normal
    )


def _overlap(one: Gap, other: Gap) -> bool:
    return one.first.place < other.second.place and other.first.place < one.second.place
