"""Where the robot has been in the last minute, as far as it knew."""

import math
from collections import deque
from dataclasses import dataclass

from pilotage_schemas.localization import PoseEstimate

WINDOW_S = 60.0
JUMP_M = 0.5
GAP_S = 2.0


@dataclass(frozen=True)
class TrajectoryPoint:
    """One pose of base_link in `map`; `is_break`: not joined to the point before it."""

    stamp_ns: int
    x: float
    y: float
    theta: float
    is_break: bool


class Trajectory:
    """Poses by their stamps; broken where the estimate jumps or was missing.

    Only localized poses count: the best of several guesses is no trace of the robot.
    """

    def __init__(self) -> None:
        self._points: deque[TrajectoryPoint] = deque()

    def add(self, estimate: PoseEstimate) -> None:
        """Append an estimate and forget what is older than a minute before it."""
        newest_ns = estimate.stamp_ns
        if self._points and newest_ns < self._points[-1].stamp_ns:
            self._points.clear()  # a log that begins anew
        while self._points and newest_ns - self._points[0].stamp_ns > WINDOW_S * 1e9:
            self._points.popleft()
        if estimate.state != "localized":
            return
        pose = estimate.pose
        is_break = self._is_break(newest_ns, pose.x, pose.y)
        self._points.append(TrajectoryPoint(newest_ns, pose.x, pose.y, pose.theta, is_break))

    def poses(self) -> list[tuple[float, float, float, float]]:
        """Return stamp in s, x, y in m and theta in rad of each point, oldest first."""
        return [(p.stamp_ns / 1e9, p.x, p.y, p.theta) for p in self._points]

    def breaks(self) -> list[int]:
        """Return the indices of the points that are not joined to the one before."""
        return [i for i, p in enumerate(self._points) if p.is_break and i > 0]

    def _is_break(self, stamp_ns: int, x: float, y: float) -> bool:
        if not self._points:
            return False
        last = self._points[-1]
        is_gap = stamp_ns - last.stamp_ns > GAP_S * 1e9
        return is_gap or math.hypot(x - last.x, y - last.y) > JUMP_M
