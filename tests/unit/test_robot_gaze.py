"""Pointing the camera: from the planner's wish on the bus to the driver."""

from pathlib import Path

import numpy as np
import pytest

from pilotage.core.map_files import save_map
from pilotage.robot.config import RobotSettings
from pilotage.robot.simulator.simulator import Simulator
from robot_world import ROOM, Bench, LookingToy, toy_bench

LOG = """FLASER 3 1.0 2.0 1.0 0.0 0.0 0.0 0.0 0.0 0.0 100.0 host 0.0
FLASER 3 1.0 2.0 1.0 0.1 0.0 0.0 0.1 0.0 0.0 100.1 host 0.1
"""


def looking_bench() -> tuple[Bench, LookingToy]:
    bench = Bench(RobotSettings(driver="robot_world:LookingToy"))
    assert isinstance(bench.service.driver, LookingToy)
    return bench, bench.service.driver


def warnings_of(bench: Bench, caplog: pytest.LogCaptureFixture) -> str:
    bench.step()
    return "\n".join(record.getMessage() for record in caplog.records)


def test_a_gaze_command_reaches_the_driver_and_the_newest_counts() -> None:
    bench, robot = looking_bench()
    bench.point(0.5)
    bench.point(-0.25)
    assert robot.pans == [0.5, -0.25]


def test_pointing_the_camera_leaves_the_wheels_alone() -> None:
    bench, robot = looking_bench()
    bench.point(0.5)
    bench.advance(0.2)
    assert robot.twist.vx == 0.0
    assert bench.service.pilot.mode == "stopped"


def test_a_robot_without_a_camera_says_so_once_and_goes_on(
    caplog: pytest.LogCaptureFixture,
) -> None:
    bench, _ = toy_bench()
    bench.point(0.5)
    bench.point(0.6)
    assert warnings_of(bench, caplog).count("Toy has no command look") == 1
    assert len(bench.listen("odometry")) == 0
    bench.advance(0.1)
    assert bench.listen("odometry")


def test_a_stuck_joint_is_told_and_does_no_harm(caplog: pytest.LogCaptureFixture) -> None:
    bench, robot = looking_bench()
    robot.stuck = "the neck is stiff"
    bench.point(0.5)
    assert "the neck is stiff" in warnings_of(bench, caplog)
    robot.stuck = None
    bench.point(0.25)
    assert robot.pans == [0.25]


def test_a_replay_refuses_to_look(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    log = tmp_path / "run.log"
    log.write_text(LOG, "utf-8")
    bench = Bench(RobotSettings(driver="replay", log=log))
    bench.point(0.5)
    assert "a recorded log cannot be driven" in warnings_of(bench, caplog)


def test_the_simulated_camera_turns_at_its_own_speed_to_where_it_is_told(tmp_path: Path) -> None:
    save_map(ROOM, tmp_path / "room.yaml")
    world = tmp_path / "world.yaml"
    world.write_text(
        "map: room.yaml\nstart: [1.5, 1.75, 0]\n"
        "landmarks: [{class: post, x: 1.5, y: 2.75}]\nrobot: {camera: {pan_speed: 1.0}}",
        "utf-8",
    )
    bench = Bench(RobotSettings(driver="simulator", world=world, seed=1, wander=False))
    pictures = bench.listen("landmarks")
    bench.advance(1.0)
    assert len(pictures) == 5
    assert not any(picture.sightings for picture in pictures)
    bench.point(float(np.pi / 2.0))
    bench.advance(0.5)
    driver = bench.service.driver
    assert isinstance(driver, Simulator)
    camera = driver._simulation.camera
    assert camera is not None
    assert camera.pan == pytest.approx(0.5, abs=0.05)
    bench.advance(3.0)
    assert any(picture.sightings for picture in pictures)
