"""The features of a map, and which of them can be seen from a node."""

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.corners import Corners
from pilotage.core.grid import OccupancyMap
from pilotage.core.raycast import cast_rays
from pilotage.topology.features import KINDS, Features
from pilotage.topology.from_map.openings import Openings

FAR = 6.0
"""m: farther features are too coarse in a laser to be matched."""
NEAR_WALL = 0.3
"""m before a feature at which a beam may end: features lie on walls."""
MOST = 40
"""Features bound to one node, the nearest first."""


def opening_features(openings: Openings, resolution: float) -> Features:
    """Return doors and passages as features; a map shows them to half a cell."""
    across = openings.chords.across
    poses = np.column_stack(
        [openings.chords.middles, np.asarray(wrap(np.arctan2(across[:, 1], across[:, 0])))]
    )
    kinds = np.where(openings.is_door, KINDS.index("door"), KINDS.index("passage"))
    covariances = np.tile(np.eye(2) * resolution**2 / 2.0, (len(openings), 1, 1))
    return Features(kinds.astype(np.int64), poses, openings.chords.widths, covariances)


def corner_features(corners: Corners) -> Features:
    """Return corners as features."""
    kinds = np.full(len(corners), KINDS.index("corner"), np.int64)
    return Features(kinds, corners.poses, np.full(len(corners), np.nan), corners.covariances)


def seen_from(world: OccupancyMap, place: NDArray[np.float64], features: Features) -> Features:
    """Return the features that can be seen from a place (3,), the nearest first."""
    away = features.poses[:, :2] - place[:2]
    distances = np.hypot(*away.T)
    near = np.flatnonzero(distances <= FAR)
    near = near[np.argsort(distances[near], kind="stable")]
    directions = np.asarray(wrap(np.arctan2(away[near, 1], away[near, 0])))
    rays = np.column_stack([np.tile(place[:2], (len(near), 1)), directions])
    ranges = cast_rays(world, rays, FAR)
    return features.chosen(near[ranges >= distances[near] - NEAR_WALL][:MOST])
