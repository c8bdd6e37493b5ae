"""The compass's last word, carried to the moment of a scan by odometry."""

from pilotage.core.angles import wrap

STALE_NS = 1_000_000_000
"""A heading measured longer ago than this says nothing about now."""


class CompassMemory:
    """The newest heading and the odometry's own heading when it was measured."""

    def __init__(self) -> None:
        self._stamp_ns = 0
        self._word: tuple[float, float] | None = None
        self._odom_yaw = 0.0

    def keep(self, stamp_ns: int, word: tuple[float, float], odom_yaw: float) -> None:
        """Keep a `word` (yaw in map, standard deviation) [rad] and the yaw in odom with it."""
        self._stamp_ns, self._word, self._odom_yaw = stamp_ns, word, odom_yaw

    def at(self, stamp_ns: int, odom_yaw: float) -> tuple[float, float] | None:
        """Return yaw and deviation when odometry's yaw is `odom_yaw`; None if it is too old."""
        if self._word is None or abs(stamp_ns - self._stamp_ns) > STALE_NS:
            return None
        yaw, sigma = self._word
        return wrap(yaw + odom_yaw - self._odom_yaw), sigma
