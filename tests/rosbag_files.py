"""Small ROS bags for tests."""

from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

SCAN, ODOMETRY = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
LEVEL, UPSIDE_DOWN = (0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0)
"""Quaternions x, y, z, w."""

Message = Any
"""An object of a class that rosbags makes at run time."""


class BagMaker:
    """Makes messages of ROS 1 or 2 and writes them; stamps in s."""

    def __init__(self, *, ros1: bool = False) -> None:
        self.ros1 = ros1
        self.store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
        if TRANSFORMS not in self.store.fielddefs:
            fields = "geometry_msgs/TransformStamped[] transforms"
            self.store.register(get_types_from_msg(fields, TRANSFORMS))

    def write(
        self, path: Path, messages: list[tuple[str, float, Any]], *, mcap: bool = False
    ) -> Path:
        """Write messages (topic, stamp, message) as a file of ROS 1 or a folder of ROS 2."""
        storage = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
        writer = Writer1(path) if self.ros1 else Writer2(path, version=9, storage_plugin=storage)
        with writer:
            connections: dict[str, Any] = {}
            for topic, stamp, message in messages:
                kind = message.__msgtype__
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=self.store)
                raw = self._serialize(message, kind)
                writer.write(connections[topic], round(stamp * 1e9), raw)
        return path

    def scan(
        self, stamp: float, ranges: list[float], *, step: float = 0.5, low: float = -0.5
    ) -> Message:
        """A scan in the frame `laser`, up to 10 m."""
        return self.store.types[SCAN](
            header=self._header(stamp, "laser"),
            angle_min=low,
            angle_max=low + step * (len(ranges) - 1),
            angle_increment=step,
            time_increment=0.0,
            scan_time=0.1,
            range_min=0.1,
            range_max=10.0,
            ranges=np.array(ranges, np.float32),
            intensities=np.zeros(0, np.float32),
        )

    def odometry(self, stamp: float, x: float, child: str = "base_link") -> Message:
        """A robot that looks along x and drives at 0.5 m/s."""
        still, types = np.zeros(36), self.store.types
        pose = types["geometry_msgs/msg/Pose"](self._point(x), self._quaternion(LEVEL))
        speed, none = self._vector(0.5, 0.0), self._vector(0.0, 0.0)
        twist = types["geometry_msgs/msg/Twist"](speed, none)
        return types[ODOMETRY](
            header=self._header(stamp, "odom"),
            child_frame_id=child,
            pose=types["geometry_msgs/msg/PoseWithCovariance"](pose, still),
            twist=types["geometry_msgs/msg/TwistWithCovariance"](twist, still),
        )

    def transform(
        self,
        stamp: float,
        frames: tuple[str, str],
        place: tuple[float, float],
        turned: tuple[float, float, float, float] = LEVEL,
    ) -> Message:
        """A message with the transform of one frame (second) in its parent (first)."""
        types = self.store.types
        moved = types["geometry_msgs/msg/Transform"](self._vector(*place), self._quaternion(turned))
        stamped = types["geometry_msgs/msg/TransformStamped"](
            self._header(stamp, frames[0]), frames[1], moved
        )
        return types[TRANSFORMS]([stamped])

    def _serialize(self, message: Message, kind: str) -> Message:
        return (
            self.store.serialize_ros1(message, kind)
            if self.ros1
            else self.store.serialize_cdr(message, kind)
        )

    def _header(self, stamp: float, frame: str) -> Message:
        time = self.store.types["builtin_interfaces/msg/Time"](int(stamp), round(stamp % 1 * 1e9))
        sequence = {"seq": 0} if self.ros1 else {}
        return self.store.types["std_msgs/msg/Header"](stamp=time, frame_id=frame, **sequence)

    def _point(self, x: float) -> Message:
        return self.store.types["geometry_msgs/msg/Point"](x, 0.0, 0.0)

    def _vector(self, x: float, y: float) -> Message:
        return self.store.types["geometry_msgs/msg/Vector3"](x, y, 0.0)

    def _quaternion(self, values: tuple[float, float, float, float]) -> Message:
        return self.store.types["geometry_msgs/msg/Quaternion"](*values)
