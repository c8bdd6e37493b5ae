"""The pairs of one cycle as they are shown: what is seen, beside what the map has there."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.localizer.ekf_walls import Walls
from pilotage.localizer.line_ekf import EkfStep

Array = NDArray[np.float64]


def _none() -> Array:
    return np.empty((0, 2, 2))


@dataclass(frozen=True)
class MatchedWalls:
    """Pairs in map: of each its ends as seen and as expected, both (n, 2, 2) [m].

    The first `lines` of them are lines, the others corners, both of whose ends are the tip.
    """

    seen: Array = field(default_factory=_none)
    expected: Array = field(default_factory=_none)
    lines: int = 0

    def __len__(self) -> int:
        return len(self.seen)


def matched_walls(step: EkfStep, seen: Walls) -> MatchedWalls:
    """Return the pairs of a cycle as its belief puts them in the map."""
    pose, (ours, theirs) = step.belief.mean, step.pairs.lines.T
    lines = se2.transform_points(pose, seen.lines.ends[ours].reshape(-1, 2)).reshape(-1, 2, 2)
    expected = _beside(lines, step.near.lines.ends[theirs])
    ours, theirs = step.pairs.corners.T
    tips = se2.transform_points(pose, seen.corners.poses[ours, :2])
    return MatchedWalls(
        np.concatenate([lines, _doubled(tips)]),
        np.concatenate([expected, _doubled(step.near.corners.poses[theirs, :2])]),
        len(lines),
    )


def _beside(pieces: Array, walls: Array) -> Array:
    """Return the parts (n, 2, 2) of walls that lie beside pieces of them (n, 2, 2)."""
    begin, along = walls[:, :1], walls[:, 1:] - walls[:, :1]
    length = np.maximum(np.sum(along**2, axis=-1, keepdims=True), 1e-12)
    share = np.sum((pieces - begin) * along, axis=-1, keepdims=True) / length
    beside: Array = begin + np.clip(share, 0.0, 1.0) * along
    return beside


def _doubled(tips: Array) -> Array:
    return np.repeat(tips[:, None], 2, axis=1)
