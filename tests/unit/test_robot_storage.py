"""A simulated robot stays where it is when its driver's process ends."""

from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
import pytest

from pilotage.bus.clock import HandClock
from pilotage.bus.deployment import Deployment
from pilotage.bus.fake import FakeFabric
from pilotage.bus.node import Node
from pilotage.robot import service
from pilotage.robot.config import RobotSettings
from pilotage.robot.driver import DriverError, Measurement
from pilotage.robot.service import RobotService
from pilotage.robot.storage import PLACE_FILE, load_place, save_place
from pilotage_schemas.geometry import Pose2, Twist2
from pilotage_schemas.sensors import GroundTruth, RobotDescription

START = Pose2(x=0.0, y=0.0, theta=0.0)
ELSEWHERE = Pose2(x=12.5, y=-3.0, theta=1.25)


class ToySimulator:
    """A simulated robot that stands where it is put; nobody can stand at x below 0."""

    def __init__(self) -> None:
        self.pose = START

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        pass

    def describe(self) -> RobotDescription:
        return RobotDescription.model_validate(
            {
                "stamp_ns": 0,
                "frame_id": "base_link",
                "name": "Toy",
                "driver": "toy",
                "footprint": np.array([[0.1, 0.0], [-0.1, 0.1], [-0.1, -0.1]], np.float32),
                "mounts": (),
                "max_linear": 0.5,
                "max_angular": 1.0,
                "commands": (),
            }
        )

    def sense(self, now_ns: int) -> Iterator[Measurement]:
        truth = GroundTruth(
            stamp_ns=now_ns, frame_id="map", pose=self.pose, twist=Twist2(vx=0.0, vy=0.0, omega=0.0)
        )
        yield Measurement("ground_truth", truth)

    def drive(self, twist: Twist2) -> None:
        pass

    def stop(self) -> None:
        pass

    def kidnap(self, pose: Pose2 | None) -> Pose2:
        if pose is None or pose.x < 0.0:
            raise DriverError("no place to stand")
        self.pose = pose
        return pose


def started(folder: Path | None, monkeypatch: pytest.MonkeyPatch) -> tuple[ToySimulator, Node]:
    """Start a robot service with the toy as its driver."""
    toy = ToySimulator()
    monkeypatch.setattr(service, "make_driver", lambda _settings: toy)
    node = Node("robot", "demo", FakeFabric(), HandClock())
    robot = RobotService(RobotSettings(), node, Deployment(run_dir=folder))
    robot.begin()
    return toy, node


def pass_time(node: Node, seconds: float) -> None:
    assert isinstance(node.clock, HandClock)
    for _ in range(round(seconds / 0.05)):
        node.clock.advance(0.05)
        node.step()


def test_a_place_is_read_as_it_was_written(tmp_path: Path) -> None:
    save_place(tmp_path, ELSEWHERE)
    assert load_place(tmp_path) == ELSEWHERE


@pytest.mark.parametrize("content", [b"", b"{}", b"\xff", b'{"x": 1, "y": "two", "theta": 0}'])
def test_a_damaged_place_is_none(tmp_path: Path, content: bytes) -> None:
    (tmp_path / PLACE_FILE).write_bytes(content)
    assert load_place(tmp_path) is None


def test_without_a_memory_there_is_no_place(tmp_path: Path) -> None:
    assert load_place(tmp_path) is None


def test_a_robot_is_where_it_was_when_its_driver_starts_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, node = started(tmp_path, monkeypatch)
    first.kidnap(ELSEWHERE)
    pass_time(node, 2.0)
    second, _ = started(tmp_path, monkeypatch)
    assert second.pose == ELSEWHERE


def test_a_place_where_nobody_can_stand_is_forgotten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save_place(tmp_path, Pose2(x=-1.0, y=0.0, theta=0.0))
    toy, _ = started(tmp_path, monkeypatch)
    assert toy.pose == START


def test_a_disk_that_cannot_be_written_stops_no_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    toy, node = started(tmp_path / "gone", monkeypatch)
    pass_time(node, 2.0)
    assert "cannot be kept" in node.vitals.last_error
    assert toy.pose == START


def test_without_a_run_folder_nothing_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    _, node = started(None, monkeypatch)
    pass_time(node, 2.0)
    assert node.vitals.last_error == ""
