"""The deployments that come with Pilotage can be run as they are."""

import os
from pathlib import Path

import numpy as np
import pytest

from pilotage.bus.deployment import read_deployment
from pilotage.core.landmark_map import read_landmarks
from pilotage.launcher.effective import Overrides, effective
from pilotage.launcher.process_table import PROCESSES
from pilotage.launcher.run_folder import write_deployment
from pilotage.robot.simulator.config import open_world

CONFIG = Path(__file__).resolve().parents[2] / "deploy" / "config"
SHIPPED = sorted(path.name for path in CONFIG.glob("*.yaml"))
RECORDED = {"wean.yaml"}
"""Deployments of a recorded log, which does not come with Pilotage."""


def test_the_promised_deployments_are_there() -> None:
    promised = {"demo", "hall", "mapping", "office", "robocup", "wean"}
    assert {f"{name}.yaml" for name in promised} <= set(SHIPPED)


@pytest.mark.parametrize("name", [name for name in SHIPPED if name not in RECORDED])
def test_a_simulation_needs_nothing_but_the_checkout(name: str) -> None:
    made = effective(read_deployment(CONFIG / name), Overrides(), PROCESSES)
    assert {"gateway", "mapper", "robot", "localizer"} <= set(made.services)


def test_the_football_robot_localizes_by_the_landmarks_that_its_camera_sees() -> None:
    made = effective(read_deployment(CONFIG / "robocup.yaml"), Overrides(), PROCESSES)
    robot, localizer = made.services["robot"] or {}, made.services["localizer"] or {}
    assert localizer["sensors"] == ["landmark"]
    known = read_landmarks(Path(str(localizer["landmarks"])))
    camera = open_world(Path(str(robot["world"]))).camera
    assert camera is not None
    assert np.array_equal(camera.landmarks.positions, known.positions)
    assert camera.landmarks.identities == known.identities


@pytest.mark.parametrize("name", sorted(RECORDED))
def test_a_replay_needs_only_the_recorded_data(
    name: str, data_dir: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PILOTAGE_DATA", str(data_dir))
    made = effective(read_deployment(CONFIG / name), Overrides(), PROCESSES)
    assert Path(str((made.services["robot"] or {})["log"])).is_relative_to(data_dir)


@pytest.mark.parametrize("name", [name for name in SHIPPED if name not in RECORDED])
def test_an_effective_deployment_says_what_its_file_says(name: str, tmp_path: Path) -> None:
    made = effective(read_deployment(CONFIG / name), Overrides(), PROCESSES)
    again = effective(read_deployment(write_deployment(made, tmp_path)), Overrides(), PROCESSES)
    assert again == made


def test_the_demo_script_can_be_run() -> None:
    script = CONFIG.parent / "demo"
    assert os.access(script, os.X_OK)
    assert "pilotage up deploy/config/demo.yaml" in script.read_text(encoding="utf-8")
