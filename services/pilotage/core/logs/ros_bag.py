"""Scans and odometry of ROS 1 and ROS 2 bags, by the library rosbags, without ROS."""

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

import numpy as np
from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from pilotage.core.logs.line_format import pose_of
from pilotage.core.logs.records import LogError, OdometryRecord, Record, ScanRecord
from pilotage.core.logs.ros_transforms import Message, TransformTree, yaw_of

SCAN, ODOMETRY = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
OLD_TRANSFORMS = "tf/msg/tfMessage"
"""The same message under the name it had in ROS 1 at first."""

BASES = ("base_link", "base_footprint", "base")
"""Frames of the robot, where the odometry does not name its own."""
ODOM = "odom"
NO_RETURN_FROM, LONGEST_RANGE = 0.999, 200.0
"""From this part of the maximum range on nothing came back; the maximum [m] if none is stated."""
FEW_MESSAGES, FEW_SHARE = 10, 0.1
"""Damaged messages that are passed over: so many, or this share."""


def read_bag(path: Path) -> tuple[list[Record], int]:
    """Return the records of a bag (a file, or the folder of ROS 2) and how many were damaged.

    Of several lasers or odometries the one with most messages is taken. Where no Odometry was
    recorded, the transform from odom to the robot serves.

    Raises:
        LogError: it cannot be opened, or holds neither scans nor odometry.
    """
    try:
        with ExitStack() as stack:
            bag = stack.enter_context(_Bag(path))
            return bag.records(), bag.damaged
    except LogError:
        raise
    except FileNotFoundError:
        raise LogError(f"{path}: the log does not exist") from None
    except Exception as error:
        # A damaged file may make the foreign library fail in any way; the reason is passed on.
        reason = str(error) or type(error).__name__
        raise LogError(f"{path}: the ROS bag cannot be read ({reason})") from error


class _Bag:
    """An open bag: finds the topics, reads them, counts what is damaged."""

    def __init__(self, path: Path) -> None:
        head = _head(path)
        is_ros1 = head.startswith(b"#ROSBAG")
        self._path, self._is_mcap = path, head.startswith(b"\x89MCAP")
        self._reader: Any = Reader1(path) if is_ros1 else Reader2(path)
        self._store = _typestore(is_ros1=is_ros1)
        self._deserialize: Callable[[bytes, str], Message] = (
            self._store.deserialize_ros1 if is_ros1 else self._store.deserialize_cdr
        )
        self.damaged = 0

    def __enter__(self) -> Self:
        self._reader.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._reader.close()

    def records(self) -> list[Record]:
        """Return scans and odometry; LogError if there are none, or too many are damaged."""
        tree = TransformTree()
        for stamp, message in self._messages(self._all(TRANSFORMS, OLD_TRANSFORMS), TRANSFORMS):
            for transform in message.transforms:
                tree.add(_stamp(transform.header, stamp), transform)
        odometry, base = self._odometry(tree)
        scans = [
            scan
            for stamp, message in self._messages(self._richest(SCAN), SCAN)
            if (scan := _scan(message, _stamp(message.header, stamp), tree, base)) is not None
        ]
        records: list[Record] = [*odometry, *scans]
        if not records:
            others = ", and recordings of Pilotage itself are not read yet" * self._is_mcap
            raise LogError(f"{self._path}: the ROS bag holds neither scans nor odometry{others}")
        if self.damaged > max(FEW_MESSAGES, FEW_SHARE * len(records)):
            raise LogError(f"{self._path}: {self.damaged} messages of the ROS bag are damaged")
        return records

    def _odometry(self, tree: TransformTree) -> tuple[list[OdometryRecord], str]:
        """Return the odometry and the frame of the robot that it is about."""
        records, base = [], ""
        for stamp, message in self._messages(self._richest(ODOMETRY), ODOMETRY):
            base = base or message.child_frame_id.strip("/")
            pose, twist = message.pose.pose, message.twist.twist
            try:
                place = pose_of(pose.position.x, pose.position.y, yaw_of(pose.orientation))
            except ValueError:
                self.damaged += 1
                continue
            speeds = float(twist.linear.x), float(twist.angular.z)
            records.append(OdometryRecord(_stamp(message.header, stamp), place, *speeds))
        if records:
            return records, base or BASES[0]
        for base in BASES:
            poses = tree.track(ODOM, base)
            if poses:
                return [OdometryRecord(stamp, pose) for stamp, pose in poses], base
        return [], BASES[0]

    def _messages(self, wanted: list[Connection], kind: str) -> Iterator[tuple[float, Message]]:
        """Yield the messages of some connections, with the time in s when each was recorded."""
        if not wanted:
            return
        for _, stamp_ns, raw in self._reader.messages(wanted):
            try:
                message = self._deserialize(raw, kind)
            except Exception:  # noqa: BLE001 - one damaged message fails in any way; it is counted
                self.damaged += 1
            else:
                yield stamp_ns / 1e9, message

    def _all(self, *kinds: str) -> list[Connection]:
        return [c for c in self._reader.connections if c.msgtype in kinds]

    def _richest(self, kind: str) -> list[Connection]:
        """Return the connections of the topic of this kind with most messages."""
        counts: dict[str, int] = {}
        for connection in self._all(kind):
            counts[connection.topic] = counts.get(connection.topic, 0) + connection.msgcount
        if not counts:
            return []
        topic = max(counts, key=lambda name: counts[name])
        return [c for c in self._all(kind) if c.topic == topic]


def _head(path: Path) -> bytes:
    """Return the first bytes of a file, nothing of a folder."""
    if not path.is_file():
        return b""
    with path.open("rb") as stream:
        return stream.read(8)


def _typestore(*, is_ros1: bool) -> Typestore:
    """Return the standard messages, which have not changed within ROS 1, nor within ROS 2."""
    store = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_HUMBLE)
    if TRANSFORMS not in store.fielddefs:
        store.register(
            get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS)
        )
    return store


def _stamp(header: Message, recorded: float) -> float:
    """Return the time of the measurement [s]; when it was recorded, if it does not say."""
    stamp = float(header.stamp.sec) + float(header.stamp.nanosec) / 1e9
    return stamp if stamp > 0.0 else recorded


def _scan(message: Message, stamp: float, tree: TransformTree, base: str) -> ScanRecord | None:
    """Return a scan with the laser's mount; None if it has no beams."""
    ranges = np.array(message.ranges, np.float64)
    first, step = float(message.angle_min), float(message.angle_increment)
    if len(ranges) < 2 or step == 0.0 or not math.isfinite(first + step):
        return None
    range_max = float(message.range_max)
    if not 0.0 < range_max <= LONGEST_RANGE:
        range_max = LONGEST_RANGE
    is_echo = (ranges >= message.range_min) & (ranges > 0.0) & (ranges < NO_RETURN_FROM * range_max)
    ranges[~is_echo] = np.inf
    mount = tree.between(base, message.header.frame_id.strip("/"))
    yaw = math.atan2(mount[1, 0], mount[0, 0])
    if mount[2, 2] < 0.0:  # it hangs upside down: its bearings run the other way round
        first, step = -first, -step
    if step < 0.0:
        ranges, first, step = ranges[::-1], first + step * (len(ranges) - 1), -step
    return ScanRecord(
        stamp=stamp,
        ranges=np.ascontiguousarray(ranges, np.float32),
        angle_min=first,
        angle_increment=step,
        range_max=range_max,
        odom_pose=None,
        laser_mount=pose_of(float(mount[0, 3]), float(mount[1, 3]), yaw),
    )
