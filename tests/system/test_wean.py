"""The recorded run through Wean Hall in place of the simulator: real noise, a real building."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import processes
from pages import Page
from pilotage.core.grid import OccupancyMap
from pilotage.core.map_files import load_map
from runs import REPOSITORY, Run, figure
from waiting import eventually

pytestmark = [pytest.mark.system, pytest.mark.data, pytest.mark.timeout(180)]

CONVERGED_S = 90.0
POSES_WATCHED = 20


def state_of(page: Page) -> str:
    """Return the state of the newest pose."""
    pose = page.get("pose")
    return pose["state"] if pose else ""


def watched(page: Page, seen: dict[int, dict[str, Any]]) -> dict[int, dict[str, Any]]:
    """Return what was seen so far, the newest pose among it."""
    pose = page.get("pose")
    if pose:
        seen[pose["stamp_ns"]] = pose
    return seen


def are_free(world: OccupancyMap, points: NDArray[np.float64]) -> bool:
    """Say whether a robot can stand at all of these points (n, 2)."""
    rows, cols = world.geometry.cells_of(points).T
    return bool(np.all(world.is_free[rows, cols]))


def test_the_pose_converges_and_stays_on_the_map(
    data_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PILOTAGE_DATA", str(data_dir))
    world = load_map(data_dir / "wean_hall" / "wean.dat.gz")
    port = processes.free_port()
    file = str(REPOSITORY / "deploy" / "config" / "wean.yaml")
    with (
        Run("pilotage", ["up", file, "--no-browser", "--port", str(port)], tmp_path) as run,
        Page(port) as page,
    ):
        eventually(lambda: state_of(page) == "localized", CONVERGED_S, "a localized pose")
        seen: dict[int, dict[str, Any]] = {}
        eventually(lambda: len(watched(page, seen)) >= POSES_WATCHED, 30.0, "further poses")
        assert "Traceback" not in run.text
    localized = [pose for pose in seen.values() if pose["state"] == "localized"]
    figure(f"{len(localized)} of {len(seen)} poses localized")
    assert len(localized) > POSES_WATCHED // 2
    points = np.array([[pose["pose"]["x"], pose["pose"]["y"]] for pose in localized])
    assert are_free(world, points)
