"""Noticing that the robot is not where it should be: the innovation of a scan.

While the robot is localized its scans fit the map as well as they usually do. One that fits much
worse at the pose where odometry puts the robot says that it was carried off (or that the map has
changed): then the old belief deserves no more credit than the paper's floor gives to any other.
"""

from dataclasses import dataclass

WORSE = 0.7
"""A scan that fits less than this share of the usual is surprising."""

RATE = 0.1
"""Share by which a new scan changes what is usual: about ten scans of memory."""


@dataclass
class ScanFit:
    """How large a share of a scan's beams usually fits the map."""

    usual: float | None = None

    def is_surprising(self, share: float) -> bool:
        """Say whether a scan of which `share` fits is out of the usual."""
        return self.usual is not None and share < WORSE * self.usual

    def learn(self, share: float) -> None:
        """Take the share of a scan at a pose that is trusted."""
        self.usual = share if self.usual is None else self.usual + RATE * (share - self.usual)

    def forget(self) -> None:
        """Begin anew, as when the robot is lost."""
        self.usual = None
