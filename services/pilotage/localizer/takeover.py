"""Leaves the pose to the mapper while a map is made, and takes it over when it is finished.

What the mapper says last (a pose with its covariance on the finished map) becomes a belief like one
that outlived a crash: the first scan that agrees confirms it.
"""

import itertools

import numpy as np
from numpy.typing import NDArray

from pilotage.bus.fabric import RefusedError
from pilotage.core.angles import wrap
from pilotage.localizer.estimate import Memory
from pilotage.localizer.messages import pose_array
from pilotage_schemas.mapping import Handover, MappingStatus

LEAST_SIGMAS = (0.05, 0.05, np.deg2rad(2.0))
"""The localizer's states are no finer [m, m, rad]: a sharper belief would fall between them."""

STEPS = np.linspace(-2.0, 2.0, 9)
"""A belief is laid out at so many standard deviations along each axis."""


class Takeover:
    """Who owns the pose, as the mapper says it: `is_silent` while it is not the localizer."""

    def __init__(self) -> None:
        self.is_silent = False
        self.is_mapping = False
        self._handover: Handover | None = None

    def take(self, status: MappingStatus) -> None:
        """Note what the mapper says."""
        self.is_silent = status.mode != "idle"
        self.is_mapping = status.mode == "mapping"
        self._handover = status.handover if status.mode == "handing_over" else None

    def require_own_pose(self) -> None:
        """Refuse what only the owner of the pose can do (RefusedError)."""
        if self.is_silent:
            raise RefusedError("a map is being made: until that is finished the mapper says where")

    def memory_on(self, map_id: str) -> Memory | None:
        """Return what to begin with on a finished map, once; None if nothing was said of it."""
        handover = self._handover
        if handover is None or handover.map_id != map_id:
            return None
        self._handover = None
        return memory_of(handover)


def memory_of(handover: Handover) -> Memory:
    """Return the Gaussian of a hand-over as weighted poses."""
    pose = pose_array(handover.pose)
    offsets = np.array(list(itertools.product(STEPS, repeat=3)))
    poses = pose + offsets @ _root(handover.covariance).T
    poses[:, 2] = wrap(poses[:, 2])
    weights = np.exp(-0.5 * np.sum(offsets**2, axis=1))
    return Memory(
        poses=poses,
        weights=weights / weights.sum(),
        odom_from_base=pose_array(handover.odom_from_base),
        stamp_ns=handover.stamp_ns,
        was_localized=True,
    )


def _root(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a root (3, 3) of a covariance, nowhere sharper than a state is wide."""
    widths = np.diag(LEAST_SIGMAS)
    scaled = np.linalg.solve(widths, np.linalg.solve(widths, covariance).T)
    values, axes = np.linalg.eigh((scaled + scaled.T) / 2.0)
    root: NDArray[np.float64] = widths @ axes @ np.diag(np.sqrt(np.maximum(values, 1.0)))
    return root
