"""Places that are followed: poses between the cells, and what is known of each."""

from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.localizer.evidence import Weighed

CORRELATED = 0.15
"""Share of a beam's evidence that counts: its neighbours meet the same wall."""

ODD_SCAN = -1.5
"""A scan speaks no louder [nat] against a place: now and then a crowd or an open door hides it."""

KEPT_SCANS = 12
"""Last scans that a new place is held against."""

SAME_WAY, SAME_TURN = 0.3, 0.15
"""Places nearer than this [m, rad] are one."""

RATE = 0.25
"""Share by which a new scan changes how well a place usually fits."""


@dataclass
class Places:
    """Poses (n, 3) in map and what is known of each.

    `log_share` (n,): log of the probability; `recent` (n, KEPT_SCANS): evidence of the last
    scans, newest first; `met` (n,): share of beams that usually meet what the map shows;
    `fit` (n,): usual mean evidence of a beam [nat]; `scans` (n,): how many it was followed for.
    """

    poses: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    log_share: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    recent: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, KEPT_SCANS)))
    met: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    fit: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    scans: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))

    def __len__(self) -> int:
        return len(self.poses)

    def chosen(self, which: NDArray[np.int64]) -> "Places":
        """Return some of the places."""
        return Places(*(getattr(self, part.name)[which] for part in fields(self)))

    def with_others(self, others: "Places") -> "Places":
        """Return these and others."""
        pairs = ((getattr(self, f.name), getattr(others, f.name)) for f in fields(self))
        return Places(*(np.concatenate(pair) for pair in pairs))

    def add(self, weighed: Weighed) -> None:
        """Take in what a scan says."""
        self.poses = weighed.poses
        self.recent = np.roll(self.recent, 1, axis=1)
        self.recent[:, 0] = np.logaddexp(CORRELATED * weighed.evidence, ODD_SCAN)
        self.met = self.met + RATE * (weighed.met - self.met)
        self.fit = self.fit + RATE * (weighed.fit - self.fit)
        self.scans = self.scans + 1.0


def apart_from(proposed: NDArray[np.float64], poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the proposed poses (k, 3) that are none of `poses` (n, 3)."""
    known = [bool(near(poses, pose, SAME_WAY, SAME_TURN).any()) for pose in proposed]
    apart: NDArray[np.float64] = proposed[~np.array(known, bool)]
    return apart


def near(
    poses: NDArray[np.float64], pose: NDArray[np.float64], way: float, turn: float
) -> NDArray[np.bool_]:
    """Say of poses (n, 3) whether they lie within `way` and `turn` of one (3,)."""
    away = np.hypot(poses[:, 0] - pose[0], poses[:, 1] - pose[1])
    are_near: NDArray[np.bool_] = (away <= way) & (np.abs(wrap(poses[:, 2] - pose[2])) <= turn)
    return are_near
