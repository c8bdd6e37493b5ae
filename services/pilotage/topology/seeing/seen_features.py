"""The corners, doors and passages of one scan."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.core.corners import CornerParams, find_corners
from pilotage.core.line_extraction import LineParams, extract_lines
from pilotage.topology.features import KINDS, Features
from pilotage.topology.seeing.door_edges import SeenEdges
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.seeing.seen_doors import DoorParams, seen_doors
from pilotage.topology.seeing.seen_features_mouths import MouthParams, seen_mouths

CORNER, PASSAGE = KINDS.index("corner"), KINDS.index("passage")

THICKEST, NEAR = 0.3, 3.0
"""m from a passage between which walls along its way are looked for: beyond its own jambs."""
SHORT_LINES = LineParams(least_length=0.25, least_beams=5)
STRETCH, WALL = 0.2, 0.7
"""m of wall that a hit stands for, and that makes a corridor."""


@dataclass(frozen=True)
class SeenParams:
    """What counts as a feature of a scan; lengths in m."""

    corners: CornerParams = field(default_factory=CornerParams)
    doors: DoorParams = field(default_factory=DoorParams)
    mouths: MouthParams = field(default_factory=MouthParams)
    corner_lines: LineParams = SHORT_LINES
    """Lines of corners may be shorter than walls: the reveals of doors have the best corners."""
    corner_reach: float = 8.0
    """Farther corners are seen too thinly."""
    flush: float = 0.3
    """Walls along the way through a passage, so near to both its jambs, are a corridor's own."""


def seen_features(
    view: ScanView, edges: SeenEdges | None = None, params: SeenParams | None = None
) -> Features:
    """Return what one scan shows, in base_link.

    `edges` of a camera in base_link at the time of the scan; None without one.
    """
    chosen = params or SeenParams()
    openings = narrow_ones(seen_doors(view, edges, chosen.doors), view, chosen)
    mouths = without_same_place(seen_mouths(view, chosen.mouths), openings)
    return Features.joined([seen_corners(view, chosen), openings, mouths])


def seen_corners(view: ScanView, params: SeenParams) -> Features:
    """Return the corners of a scan, in base_link."""
    lines = extract_lines(view.ranges, view.angles, params.corner_lines)
    corners = find_corners(lines, params.corners)
    near = np.hypot(corners.poses[:, 0], corners.poses[:, 1]) <= params.corner_reach
    count = int(near.sum())
    found = Features(
        np.full(count, CORNER),
        corners.poses[near],
        np.full(count, np.nan),
        corners.covariances[near],
    )
    return found.moved(view.mount)


def narrow_ones(openings: Features, view: ScanView, params: SeenParams) -> Features:
    """Return the openings without passages that are no narrower than the way through them.

    Standing in a corridor, one sees walls of the rooms at both sides through their doors; where
    they are in line they look like a wall with an opening as wide as the corridor.
    """
    is_hit = np.isfinite(view.ranges)
    hits = se2.transform_points(view.mount, view.directions[is_hit] * view.ranges[is_hit, None])
    is_way = [
        kind == PASSAGE and _is_corridor(pose, width, hits, params.flush)
        for kind, pose, width in zip(openings.kinds, openings.poses, openings.widths, strict=True)
    ]
    return openings.chosen(~np.array(is_way, np.bool_))


def _is_corridor(
    pose: NDArray[np.float64], width: float, hits: NDArray[np.float64], flush: float
) -> bool:
    """Say whether walls run along a way of this width through a pose (3,) at both sides."""
    along, beside = se2.transform_points(se2.inverse(pose), hits).T
    is_near = (np.abs(along) > THICKEST) & (np.abs(along) < NEAR)
    return all(
        _length_of(along[is_near & (np.abs(side * beside - width / 2.0) < flush)]) > WALL
        for side in (1.0, -1.0)
    )


def _length_of(places: NDArray[np.float64]) -> float:
    """Return how much of a wall hits at places (n,) along it cover, m."""
    return STRETCH * len(np.unique(np.floor(places / STRETCH)))


def without_same_place(features: Features, others: Features) -> Features:
    """Return the features that lie at least half an opening's width from all others."""
    off = features.poses[:, None, :2] - others.poses[None, :, :2]
    room = 0.5 * np.maximum(features.widths[:, None], others.widths[None])
    same = np.hypot(off[..., 0], off[..., 1]) < room
    is_alone = np.logical_not(same.any(axis=1))
    return features.chosen(np.asarray(is_alone))
