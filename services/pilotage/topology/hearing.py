"""What the topology service hears, put together: at a scan, what is seen and where from."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.bus.node import Node
from pilotage.core import se2
from pilotage.core.odometry_buffer import OdometryBuffer
from pilotage.core.odometry_watch import OdometrySample, restart_between
from pilotage.topology.features import Features
from pilotage.topology.finding import Sight
from pilotage.topology.messages import pose_array
from pilotage.topology.seeing.door_edges import SeenEdges
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.seeing.seen_features import seen_features
from pilotage_schemas.localization import PoseEstimate, State
from pilotage_schemas.sensors import LaserScan, Odometry, RobotDescription, VerticalEdges

EXTRAPOLATION_NS = 100_000_000
FRESH_EDGES_NS = 500_000_000
"""A picture older than this shows another place."""

FRESH_POSE_NS = 1_000_000_000
"""A pose older than this, carried on by odometry, is nobody's word any more."""

EARLY_NS = 10_000_000
"""Scans come a little early now and then; that must not halve their rate."""


@dataclass(frozen=True)
class Glance:
    """One scan, `view`: what is `seen` in base_link, and where from.

    `odom_from_base` (3,) and, as the pose's owner says it, `map_from_base` (3,) with its
    covariance (3, 3) and `state`; `unknown` if nobody has said anything lately.
    """

    stamp_ns: int
    view: ScanView
    seen: Features
    odom_from_base: NDArray[np.float64]
    map_from_base: NDArray[np.float64]
    covariance: NDArray[np.float64]
    state: State

    @property
    def sight(self) -> Sight:
        """The glance as the mathematics takes it: the pose only where its owner is sure."""
        is_sure = self.state == "localized"
        return Sight(
            self.stamp_ns / 1e9,
            self.view,
            self.seen,
            self.odom_from_base,
            self.map_from_base if is_sure else None,
            self.covariance if is_sure else None,
        )


class Hearing:
    """Listens to the robot and to the pose; hands each glance to `take`, if anybody wants one.

    `wants()` is asked first: to seek features takes a few milliseconds. `restarted()` is told that
    odometry is counted anew.
    """

    def __init__(
        self,
        node: Node,
        period: float,
        wants: Callable[[], bool],
        take: Callable[[Glance], None],
        restarted: Callable[[], None],
    ) -> None:
        self._node = node
        self._period_ns = round(period * 1e9) - EARLY_NS
        self._wants, self._take, self._restarted = wants, take, restarted
        self._mounts: dict[str, NDArray[np.float64]] = {"base_link": np.zeros(3)}
        self._odometry = OdometryBuffer()
        self._newest: OdometrySample | None = None
        self._edges: VerticalEdges | None = None
        self._pose: PoseEstimate | None = None
        self._waiting: LaserScan | None = None
        self._taken_ns = 0
        node.subscribe("description", self.take_description)
        node.subscribe("odometry", self.take_odometry, depth=64)
        node.subscribe("vertical_edges", self.take_edges, depth=1)
        node.subscribe("pose", self.take_pose, depth=1)
        node.subscribe("scan", self.take_scan, depth=1)

    def take_description(self, description: RobotDescription) -> None:
        """Note where the sensors sit."""
        mounts = {mount.frame_id: pose_array(mount.pose) for mount in description.mounts}
        self._mounts = {"base_link": np.zeros(3)} | mounts

    def take_odometry(self, odometry: Odometry) -> None:
        """Follow how the robot moves; a scan may have waited for it."""
        now = OdometrySample(odometry.seq, odometry.stamp_ns, pose_array(odometry.pose))
        before, self._newest = self._newest, now
        if before is not None and restart_between(before, now) is not None:
            self._odometry.clear()
            self._pose = self._edges = self._waiting = None
            self._taken_ns = 0
            self._restarted()
        self._odometry.append(now.stamp_ns, now.pose)
        waiting, self._waiting = self._waiting, None
        if waiting is not None:
            self._look(waiting)

    def take_edges(self, edges: VerticalEdges) -> None:
        """Note what the camera sees."""
        self._edges = edges

    def take_pose(self, pose: PoseEstimate) -> None:
        """Note where the robot is said to be."""
        self._pose = pose

    def take_scan(self, scan: LaserScan) -> None:
        """Look for features, if that is due and wanted."""
        if 0 <= scan.stamp_ns - self._taken_ns < self._period_ns or not self._wants():
            return
        if scan.frame_id in self._mounts:
            self._look(scan)
        elif len(self._mounts) > 1:
            self._node.warn("scan", f"the robot's description has no mount '{scan.frame_id}'")

    def _look(self, scan: LaserScan) -> None:
        odom = self._odometry.pose_at(scan.stamp_ns, EXTRAPOLATION_NS)
        if odom is None:
            self._waiting = scan
            return
        self._taken_ns = scan.stamp_ns
        angles = scan.angle_min, scan.angle_increment
        view = ScanView.of(scan.ranges, angles, self._mounts[scan.frame_id])
        self._take(self._glance(scan.stamp_ns, odom, view))

    def _edges_at(self, stamp_ns: int, odom: NDArray[np.float64]) -> SeenEdges | None:
        """Return the edges of the last picture in base_link of now, None without a fresh one."""
        edges = self._edges
        if edges is None or abs(stamp_ns - edges.stamp_ns) > FRESH_EDGES_NS:
            return None
        mount = self._mounts.get(edges.frame_id)
        then = self._odometry.pose_at(edges.stamp_ns, EXTRAPOLATION_NS)
        if mount is None or then is None:
            return None
        seen = SeenEdges.of(mount, edges.bearings, edges.sigma)
        return seen.moved(se2.between(odom, then))

    def _glance(self, stamp_ns: int, odom: NDArray[np.float64], view: ScanView) -> Glance:
        seen = seen_features(view, self._edges_at(stamp_ns, odom))
        said = self._pose
        if said is not None and abs(stamp_ns - said.stamp_ns) <= FRESH_POSE_NS:
            then = self._odometry.pose_at(said.stamp_ns, EXTRAPOLATION_NS)
            if then is not None:
                here = se2.compose(pose_array(said.pose), se2.between(then, odom))
                return Glance(stamp_ns, view, seen, odom, here, said.covariance, said.state)
        nowhere = np.full(3, np.nan)
        return Glance(stamp_ns, view, seen, odom, nowhere, np.full((3, 3), np.nan), "unknown")
