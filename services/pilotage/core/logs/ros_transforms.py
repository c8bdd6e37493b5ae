"""The transforms of a ROS bag: where sensors sit on the robot, and how odometry moved it."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilotage.core.angles import wrap
from pilotage.core.logs.records import Pose

Matrix = NDArray[np.float64]
"""(4, 4), takes points of the child's frame to the parent's."""

Message = Any
"""An object of a class that rosbags makes at run time."""

DEEPEST = 50
"""Frames from a sensor to its robot; more is a circle."""


def quaternion_matrix(rotation: Message) -> Matrix:
    """Return the rotation (3, 3) of a quaternion; ValueError if it is none."""
    q = np.array([rotation.w, rotation.x, rotation.y, rotation.z], float)
    length = float(np.linalg.norm(q))
    if not math.isfinite(length) or length < 1e-3:
        raise ValueError("a rotation that is no quaternion")
    w, x, y, z = q / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def yaw_of(rotation: Message) -> float:
    """Return the heading of a quaternion, rad; ValueError if it is none."""
    matrix = quaternion_matrix(rotation)
    return wrap(math.atan2(matrix[1, 0], matrix[0, 0]))


class TransformTree:
    """Frames by their parents. A mount is taken from the first transform that states it."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, Matrix]] = {}
        self._tracks: dict[tuple[str, str], list[tuple[float, Pose]]] = {}

    def add(self, stamp: float, transform: Message) -> None:
        """Take in a TransformStamped of a time [s]; one that is damaged is passed over."""
        parent, child = transform.header.frame_id.strip("/"), transform.child_frame_id.strip("/")
        moved = transform.transform.translation
        matrix = np.eye(4)
        try:
            matrix[:3, :3] = quaternion_matrix(transform.transform.rotation)
        except ValueError:
            return
        matrix[:3, 3] = moved.x, moved.y, moved.z
        if not np.isfinite(matrix).all():
            return
        self._parents.setdefault(child, (parent, matrix))
        pose = float(moved.x), float(moved.y), yaw_of(transform.transform.rotation)
        self._tracks.setdefault((parent, child), []).append((stamp, pose))

    def between(self, base: str, frame: str) -> Matrix:
        """Return how a frame sits on the robot (4, 4); at its centre, if nothing says how."""
        matrix = np.eye(4)
        for _ in range(DEEPEST):
            if frame == base or frame not in self._parents:
                break
            frame, step = self._parents[frame]
            matrix = step @ matrix
        return matrix if frame == base else np.eye(4)

    def track(self, parent: str, child: str) -> list[tuple[float, Pose]]:
        """Return all poses of a frame directly in another, in the order they were recorded."""
        return self._tracks.get((parent, child), [])
