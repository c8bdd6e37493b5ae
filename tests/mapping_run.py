"""A whole run that maps, and somebody who listens to it on the bus."""

import math
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

import numpy as np

import processes
from pilotage.bus.clock import SystemClock
from pilotage.bus.node import Node
from pilotage.bus.session import open_fabric
from pilotage.core import se2
from pilotage_schemas.geometry import Pose2
from pilotage_schemas.localization import PoseEstimate
from pilotage_schemas.mapping import GridPatch, MappingStatus, OccupancyGrid
from runs import REPOSITORY
from waiting import eventually

SAME_TIME_NS = 30_000_000
WORLD = REPOSITORY / "deploy" / "worlds" / "office.yaml"


def deployment(folder: Path, port: int) -> tuple[Path, str]:
    """Write a deployment of a robot that maps the office; return the file and the endpoint."""
    endpoint = f"tcp/127.0.0.1:{processes.free_port()}"
    path = folder / "mapping.yaml"
    lines = [
        f"endpoint: {endpoint}",
        "services:",
        f"  gateway: {{port: {port}}}",
        "  mapper: {mapping: laser}",
        f"  robot: {{driver: simulator, world: {WORLD}}}",
        "  localizer: {}",
    ]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path, endpoint


class Listener:
    """Hears poses, the truth and the map; knows how the new map lies in the true one."""

    def __init__(self, endpoint: str) -> None:
        self.poses: list[PoseEstimate] = []
        self.maps: list[OccupancyGrid] = []
        self.patches: list[GridPatch] = []
        self.statuses: list[MappingStatus] = []
        self.errors: list[tuple[int, float]] = []
        self.true_from_map: np.ndarray | None = None
        self._truths: dict[int, np.ndarray] = {}
        self._endpoint = endpoint
        self._stack = ExitStack()

    def __enter__(self) -> Self:
        fabric = self._stack.enter_context(open_fabric(self._endpoint))
        self.node = Node("spectator", "demo", fabric, SystemClock())
        self.node.subscribe("pose", self._hear_pose, depth=500)
        self.node.subscribe("ground_truth", self._hear_truth, depth=500)
        self.node.subscribe("map", self.maps.append)
        self.node.subscribe("map_patch", self.patches.append)
        self.node.subscribe("mapping_status", self.statuses.append)
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def until(self, condition: Any, within: float, what: str) -> None:  # noqa: ANN401 - any callable
        """Listen until a condition holds."""

        def holds() -> object:
            self.node.step()
            return condition()

        eventually(holds, within, what)

    @property
    def status(self) -> MappingStatus:
        """What the mapper said last."""
        self.node.step()
        return self.statuses[-1]

    def worst_since(self, stamp_ns: int) -> float:
        """Return the largest error [m] of the poses measured since then."""
        return max((error for stamp, error in self.errors if stamp >= stamp_ns), default=math.inf)

    def longest_silence_since(self, stamp_ns: int) -> float:
        """Return the longest time [s] between two poses since then."""
        stamps = np.array([one.stamp_ns for one in self.poses if one.stamp_ns >= stamp_ns])
        return float(np.diff(stamps).max()) / 1e9 if len(stamps) > 1 else math.inf

    def _hear_truth(self, truth: Any) -> None:  # noqa: ANN401 - GroundTruth, decoded by the node
        self._truths[truth.stamp_ns] = _array(truth.pose)
        while len(self._truths) > 200:
            del self._truths[next(iter(self._truths))]

    def _hear_pose(self, said: PoseEstimate) -> None:
        self.poses.append(said)
        nearest = min(self._truths, key=lambda stamp: abs(stamp - said.stamp_ns), default=0)
        if abs(nearest - said.stamp_ns) > SAME_TIME_NS or said.state != "localized":
            return
        true, pose = self._truths[nearest], _array(said.pose)
        if self.true_from_map is None:
            self.true_from_map = se2.compose(true, se2.inverse(pose))
        off = se2.compose(self.true_from_map, pose) - true
        self.errors.append((said.stamp_ns, float(np.hypot(off[0], off[1]))))


def _array(pose: Pose2) -> np.ndarray:
    return np.array([pose.x, pose.y, pose.theta])
