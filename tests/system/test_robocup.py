"""The football field as people start it: landmarks alone tell the robot where it is."""

from pathlib import Path

import pytest

import processes
from pages import Page
from runs import REPOSITORY, Run
from waiting import eventually

pytestmark = [pytest.mark.system, pytest.mark.timeout(240)]

COLD_S = 120.0
"""A first start compiles every kernel, on a machine that may have other work."""


def test_landmarks_alone_tell_where_the_robot_is_and_where_it_was_carried(tmp_path: Path) -> None:
    port = processes.free_port()
    file = str(REPOSITORY / "deploy" / "config" / "robocup.yaml")
    with (
        Run("pilotage", ["up", file, "--no-browser", "--port", str(port)], tmp_path) as run,
        Page(port) as page,
    ):
        eventually(lambda: page.answers("/healthz"), COLD_S, "/healthz")
        page.localized(within=60.0)
        sightings = page.get("sensors/landmarks")
        assert sightings is not None
        assert sightings["frame_id"] == "camera"
        page.command("look", pan=0.8)
        page.command("kidnap", pose={"x": -1.5, "y": -0.5, "theta": 2.0})
        page.localized(within=60.0)
        assert "Traceback" not in run.text
