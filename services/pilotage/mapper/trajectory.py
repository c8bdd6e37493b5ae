"""The robot's way, pose by pose, in memory that grows by doubling."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

FIRST_SIZE = 1024


class Trajectory:
    """Stamps and poses in the order they came: 32 bytes each."""

    def __init__(self) -> None:
        self._rows = np.empty((FIRST_SIZE, 4))
        self._count = 0

    def add(self, stamp: float, pose: ArrayLike) -> None:
        """Add a pose (3,) at a time in s."""
        if self._count == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[self._count, 0] = stamp
        self._rows[self._count, 1:] = pose
        self._count += 1

    def __len__(self) -> int:
        return self._count

    def pose(self, index: int) -> NDArray[np.float64]:
        """Return one pose (3,)."""
        return self._rows[index, 1:].copy()

    @property
    def stamps(self) -> NDArray[np.float64]:
        """Return the times (n,) in s."""
        return self._rows[: self._count, 0].copy()

    @property
    def poses(self) -> NDArray[np.float64]:
        """Return the poses (n, 3)."""
        return self._rows[: self._count, 1:].copy()

    def restore(self, stamps: NDArray[np.float64], poses: NDArray[np.float64]) -> None:
        """Take over stamps (n,) and poses (n, 3); ValueError if they do not fit."""
        if poses.shape != (len(stamps), 3) or stamps.ndim != 1:
            raise ValueError(f"{poses.shape} poses do not fit {stamps.shape} stamps")
        self._rows = np.empty((max(FIRST_SIZE, 2 * len(stamps)), 4))
        self._count = len(stamps)
        self._rows[: self._count] = np.column_stack([stamps, poses])
