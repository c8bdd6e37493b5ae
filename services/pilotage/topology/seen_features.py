"""The corners, doors and passages of one scan."""

from dataclasses import dataclass, field

import numpy as np

from pilotage.core.corners import CornerParams, find_corners
from pilotage.topology.door_edges import SeenEdges
from pilotage.topology.features import KINDS, Features
from pilotage.topology.scan_view import ScanView
from pilotage.topology.seen_doors import DoorParams, seen_doors
from pilotage.topology.seen_features_mouths import MouthParams, seen_mouths

CORNER = KINDS.index("corner")


@dataclass(frozen=True)
class SeenParams:
    """What counts as a feature of a scan; lengths in m."""

    corners: CornerParams = field(default_factory=CornerParams)
    doors: DoorParams = field(default_factory=DoorParams)
    mouths: MouthParams = field(default_factory=MouthParams)
    least_line: float = 0.4
    """Shorter lines make no corner: chairs and boxes have them."""
    corner_reach: float = 8.0
    """Farther corners are seen too thinly."""


def seen_features(
    view: ScanView, edges: SeenEdges | None = None, params: SeenParams | None = None
) -> Features:
    """Return what one scan shows, in base_link.

    `edges` of a camera in base_link at the time of the scan; None without one.
    """
    chosen = params or SeenParams()
    openings = seen_doors(view, edges, chosen.doors)
    mouths = without_same_place(seen_mouths(view, chosen.mouths), openings)
    return Features.joined([seen_corners(view, chosen), openings, mouths])


def seen_corners(view: ScanView, params: SeenParams) -> Features:
    """Return the corners of the longer lines of a scan, in base_link."""
    lines = view.lines.chosen(view.lines.lengths >= params.least_line)
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


def without_same_place(features: Features, others: Features) -> Features:
    """Return the features that lie at least half an opening's width from all others."""
    off = features.poses[:, None, :2] - others.poses[None, :, :2]
    room = 0.5 * np.maximum(features.widths[:, None], others.widths[None])
    same = np.hypot(off[..., 0], off[..., 1]) < room
    is_alone = np.logical_not(same.any(axis=1))
    return features.chosen(np.asarray(is_alone))
