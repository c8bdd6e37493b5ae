"""The recent poses of the odometry, so that any sensor can ask where the robot was just then."""

from bisect import bisect_left
from collections import deque

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pilotage.core import se2


class OdometryBuffer:
    """The last `capacity` poses of base_link in odom with their stamps, in order of time."""

    def __init__(self, capacity: int = 1000) -> None:
        self._stamps: deque[int] = deque(maxlen=capacity)
        self._poses: deque[NDArray[np.float64]] = deque(maxlen=capacity)

    def __len__(self) -> int:
        return len(self._stamps)

    def append(self, stamp_ns: int, pose: ArrayLike) -> bool:
        """Keep a pose (3,); say whether it was newer than all before (else it is refused)."""
        if self._stamps and stamp_ns <= self._stamps[-1]:
            return False
        self._stamps.append(stamp_ns)
        self._poses.append(np.array(pose, float))
        return True

    def pose_at(self, stamp_ns: int, extrapolation_ns: int = 0) -> NDArray[np.float64] | None:
        """Return the pose (3,) at a time, between its neighbours; None outside the buffer.

        Up to `extrapolation_ns` after the newest sample the last motion is taken to go on.
        """
        if not self._stamps or stamp_ns < self._stamps[0]:
            return None
        if stamp_ns > self._stamps[-1] + extrapolation_ns:
            return None
        after = bisect_left(self._stamps, stamp_ns)
        if after < len(self._stamps) and self._stamps[after] == stamp_ns:
            return self._poses[after].copy()
        if len(self._stamps) == 1:
            return self._poses[0].copy()
        after = min(after, len(self._stamps) - 1)
        return self._interpolate(after, stamp_ns)

    def latest(self) -> tuple[int, NDArray[np.float64]] | None:
        """Return the newest stamp and pose (3,), or None while the buffer is empty."""
        return (self._stamps[-1], self._poses[-1].copy()) if self._stamps else None

    def clear(self) -> None:
        """Forget everything: the odometry has started anew."""
        self._stamps.clear()
        self._poses.clear()

    def _interpolate(self, after: int, stamp_ns: int) -> NDArray[np.float64]:
        """The pose at a time on the line through the samples `after` - 1 and `after`."""
        start, end = self._stamps[after - 1], self._stamps[after]
        fraction = (stamp_ns - start) / (end - start)
        return se2.interpolate(self._poses[after - 1], self._poses[after], fraction)
