"""The robot's way, told at the rate of the odometry from the poses of the keyframes."""

from array import array

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.mapper.keyframes import KeyframeGraph

Arrays = NDArray[np.float64]


class Track:
    """Odometry (stamp, pose) and scans (stamp, odometry's pose, keyframe, pose seen from it).

    Numbers side by side: two hours of them are a few megabytes.
    """

    def __init__(self) -> None:
        self._odometry = array("d")
        self._scans = array("d")

    def add_odometry(self, stamp: float, odom_from_base: Arrays) -> None:
        """Note odometry (3,)."""
        self._odometry.extend((stamp, *odom_from_base.tolist()))

    def add_scan(self, stamp: float, odom_from_base: Arrays, keyframe: int, pose: Arrays) -> None:
        """Note that a scan was taken at `pose` (3,) seen from a keyframe."""
        self._scans.extend((stamp, *odom_from_base.tolist(), float(keyframe), *pose.tolist()))

    def poses(self, graph: KeyframeGraph) -> tuple[Arrays, Arrays]:
        """Return stamps (n,) and poses (n, 3) in the map of all odometry.

        Between two scans odometry is believed forth from the one and back from the other, each the
        more the nearer it is, so that the way never jumps.
        """
        scans, odometry = self._rows()
        if not len(scans):
            return odometry[:, 0], odometry[:, 1:]
        placed = _placed(scans, graph)
        stamps = odometry[:, 0]
        after = np.clip(np.searchsorted(scans[:, 0], stamps), 0, len(scans) - 1)
        before = np.maximum(after - 1, 0)
        before[stamps >= scans[-1, 0]] = len(scans) - 1
        forth = se2.compose(placed[before], se2.between(scans[before, 1:4], odometry[:, 1:]))
        back = se2.compose(placed[after], se2.between(scans[after, 1:4], odometry[:, 1:]))
        gap = scans[after, 0] - scans[before, 0]
        share = np.where(
            gap > 0.0, (stamps - scans[before, 0]) / np.where(gap > 0.0, gap, 1.0), 1.0
        )
        step = se2.between(forth, back) * np.clip(share, 0.0, 1.0)[:, None]
        return stamps, se2.compose(forth, step)

    def state(self) -> dict[str, Arrays]:
        """Return all of it, as arrays by name."""
        scans, odometry = self._rows()
        return {"scans": scans, "odometry": odometry}

    def resume(self, state: dict[str, Arrays]) -> None:
        """Go on from a state."""
        self._scans = array("d", state["scans"].ravel().tolist())
        self._odometry = array("d", state["odometry"].ravel().tolist())

    def _rows(self) -> tuple[Arrays, Arrays]:
        # Copied: an array that is looked into cannot grow.
        scans = np.array(self._scans, dtype=np.float64).reshape(-1, 8)
        return scans, np.array(self._odometry, dtype=np.float64).reshape(-1, 4)


def _placed(scans: Arrays, graph: KeyframeGraph) -> Arrays:
    """Return the poses (n, 3) of the scans in the map."""
    anchors = {int(number): graph.anchored(int(number)) for number in np.unique(scans[:, 4])}
    poses = {k: se2.compose(graph.poses[n], offset) for k, (n, offset) in anchors.items()}
    keyframes = np.array([poses[int(number)] for number in scans[:, 4]])
    return se2.compose(keyframes, scans[:, 5:8])
