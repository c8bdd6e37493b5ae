"""A robot that knows nothing but what it passes: it makes out nodes by itself (Zhuang, 3.2).

The features of its scans are gathered in the odometry frame. A place abreast of a door, or of
doors near each other, is a node as in the map; it is told once the robot has gone on a little, with
the features about it as seen from there.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pilotage.core import se2
from pilotage.experiments.corridor_doors import SHARED_WITHIN
from pilotage.experiments.corridor_ride import Look
from pilotage.experiments.hybrid_localization import ANGLES, MOUNT
from pilotage.topology.features import KINDS, Features
from pilotage.topology.from_drive.landmarks import Landmarks
from pilotage.topology.node_chains.candidates import Link
from pilotage.topology.seeing.scan_view import ScanView
from pilotage.topology.seeing.seen_features import seen_features

DOOR = KINDS.index("door")
ABREAST = 2.0
"""m to the side within which a door is passed."""
SIDE = float(np.deg2rad(110.0))
"""rad to either side within which the robot tells what is about a node: it has not seen behind."""
REACH = 4.5
"""m within which it does."""

WAY_SIGMA, TURN_SIGMA, BEND_SIGMA = 0.03, 0.02, 0.02
"""How odometry errs: m per root of a metre, rad per root of a radian, rad per root of a metre."""


@dataclass(frozen=True)
class NodeSeen:
    """A node that was passed: what goes into the chain, and where the robot really was (3,)."""

    link: Link
    truth: NDArray[np.float64]


class NodeWatch:
    """Takes in looks in the order of time, and tells of nodes."""

    def __init__(self) -> None:
        self._landmarks = Landmarks()
        self._looks: list[Look] = []
        self._passed: list[int] = []
        self._is_abreast = np.empty(0, bool)
        self._last: int | None = None

    def see(self, look: Look) -> NodeSeen | None:
        """Take in a look; return the node that the robot has now left behind, if it has."""
        self._looks.append(look)
        seen = seen_features(ScanView.of(look.ranges, ANGLES, MOUNT))
        self._landmarks.add(seen.moved(look.odom_from_base))
        self._note_passed(look)
        if not self._passed or self._distance_since(self._passed[0]) <= SHARED_WITHIN:
            return None
        return self._node()

    def _note_passed(self, look: Look) -> None:
        """Note doors that were ahead at the last look and are not any more."""
        near = self._landmarks.features.moved(se2.inverse(look.odom_from_base))
        is_door = (near.kinds == DOOR) & self._landmarks.is_certain
        is_near = np.abs(near.poses[:, 1]) <= ABREAST
        is_ahead = near.poses[:, 0] > 0.0
        was_ahead = np.zeros(len(near), bool)
        was_ahead[: len(self._is_abreast)] = self._is_abreast
        gone = np.flatnonzero(is_door & is_near & was_ahead & ~is_ahead)
        beside = np.abs(near.poses[gone, 0]) <= SHARED_WITHIN
        self._passed += [int(door) for door in gone[beside] if int(door) not in self._passed]
        self._is_abreast = is_ahead & is_near

    def _distance_since(self, door: int) -> float:
        """Return how far the robot is past a door, m."""
        here = self._looks[-1].odom_from_base
        place = self._landmarks.features.chosen(np.array([door])).moved(se2.inverse(here))
        return float(np.abs(place.poses[0, 0]))

    def _node(self) -> NodeSeen:
        """Return the node abreast of the doors that were passed last."""
        doors = self._landmarks.features.poses[self._passed, :2].mean(axis=0)
        since = 0 if self._last is None else self._last + 1
        poses = np.array([look.odom_from_base for look in self._looks])
        ahead = np.array([se2.between(pose, [*doors, 0.0])[0] for pose in poses[since:]])
        now = since + int(np.argmin(np.abs(ahead)))
        link = Link(self._about(poses[now]), *self._way(poses, now))
        self._last, self._passed = now, []
        return NodeSeen(link, self._looks[now].truth)

    def _about(self, pose: NDArray[np.float64]) -> Features:
        """Return what is about a pose of the odometry frame, as seen from there."""
        known = self._landmarks.features.chosen(self._landmarks.is_certain)
        near = known.moved(se2.inverse(pose))
        x, y, _ = near.poses.T
        return near.chosen((np.hypot(x, y) <= REACH) & (np.abs(np.arctan2(y, x)) <= SIDE))

    def _way(
        self, poses: NDArray[np.float64], now: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the motion (3,) since the last node and its covariance (3, 3)."""
        if self._last is None:
            return np.zeros(3), np.zeros((3, 3))
        moved = se2.between(poses[self._last], poses[now])
        steps = se2.between(poses[self._last : now], poses[self._last + 1 : now + 1])
        way = float(np.hypot(steps[:, 0], steps[:, 1]).sum())
        turn = float(np.abs(steps[:, 2]).sum())
        heading = BEND_SIGMA**2 * way + TURN_SIGMA**2 * turn
        along = WAY_SIGMA**2 * way
        # Headings that drift evenly throw the robot aside by a third of the last one's variance.
        return moved, np.diag([along, along + heading * way**2 / 3.0, heading])
