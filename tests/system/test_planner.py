"""Planning with real processes: goals reached or refused, doubts resolved, and a planner killed."""

import math
import os
import signal
import time
from collections.abc import Iterator

import httpx
import pytest

import processes
from pages import Page
from runs import REPOSITORY, Run, figure
from waiting import eventually

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]

DEMO = REPOSITORY / "deploy" / "config" / "demo.yaml"
COLD_S = 120.0
START = {"x": 37.5, "y": 21.5, "theta": 0.0}
"""Where the demo begins: in the middle of the open-plan office."""
AHEAD = {"x": 40.5, "y": 21.5, "theta": 1.57}
FAR = {"x": 47.5, "y": 20.8, "theta": 0.0}
ALIKE = {"x": 10.0, "y": 3.0, "theta": -1.571}
"""In one of nine single offices that are exactly alike, its back to the door."""

POSITION_M = 0.10 + 0.05
HEADING_RAD = math.radians(5.0 + 2.0)
"""What was wanted, and what the localizer may be off."""


@pytest.fixture(scope="module")
def port() -> int:
    return processes.free_port()


@pytest.fixture(scope="module")
def page(port: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """The page of the demo, shared by the tests of this module, the robot localized."""
    arguments = ["up", str(DEMO), "--no-browser", "--port", str(port)]
    with Run("pilotage", arguments, tmp_path_factory.mktemp("planner")) as run, Page(port) as page:
        eventually(lambda: page.answers("/healthz"), COLD_S, "/healthz")
        eventually(lambda: page.process("planner").get("state") == "ready", COLD_S, "the planner")
        eventually(lambda: page.get("potential"), COLD_S, "the map in the planner")
        page.localized(COLD_S)
        yield page
        assert "Traceback" not in run.text, run.text


def put(page: Page, pose: dict[str, float]) -> None:
    """Put the robot somewhere, standing and sure of where it is."""
    page.command("cancel")
    page.command("stop")
    page.command("kidnap", pose=pose)
    page.command("set_pose", pose=pose)
    page.localized(within=30.0)


def planning(page: Page) -> dict[str, object]:
    return page.get("planning") or {}


def is_idle(page: Page) -> bool:
    return planning(page).get("mode") == "idle"


def stands(page: Page) -> bool:
    odometry = page.get("sensors/odometry")
    return bool(odometry and max(abs(odometry["twist"][k]) for k in ("vx", "omega")) < 0.01)


def moves(page: Page) -> bool:
    odometry = page.get("sensors/odometry")
    return bool(odometry and abs(odometry["twist"]["vx"]) > 0.2)


def test_a_goal_is_reached_and_the_robot_stands_there(page: Page) -> None:
    put(page, START)
    began = time.monotonic()
    reply = page.command("go_to", pose=AHEAD)
    assert "going to (40.50, 21.50)" in reply["detail"]
    eventually(lambda: page.get("path"), 10.0, "the path")
    eventually(lambda: is_idle(page), 90.0, "the end of the way")
    assert planning(page)["outcome"] == "done", planning(page)
    eventually(lambda: stands(page), 10.0, "the robot standing")
    truth = page.get("sensors/ground_truth")
    assert truth is not None
    off = math.hypot(truth["pose"]["x"] - AHEAD["x"], truth["pose"]["y"] - AHEAD["y"])
    turn = abs(math.remainder(truth["pose"]["theta"] - AHEAD["theta"], math.tau))
    figure(
        f"go_to: 3 m in {time.monotonic() - began:.1f} s, {off:.3f} m and "
        f"{math.degrees(turn):.1f} degrees off"
    )
    assert off < POSITION_M
    assert turn < HEADING_RAD


@pytest.mark.parametrize(
    ("x", "y", "reason"),
    [(-5.0, 3.0, "off the map"), (0.0, 0.0, "wall"), (22.0, 20.0, "unknown ground")],
)
def test_a_goal_that_cannot_be_reached_is_refused_with_the_reason(
    page: Page, port: int, x: float, y: float, reason: str
) -> None:
    put(page, START)
    answer = httpx.post(
        f"http://127.0.0.1:{port}/api/v1/robots/demo/commands/go_to",
        json={"pose": {"x": x, "y": y, "theta": 0.0}},
        timeout=20.0,
    )
    assert answer.status_code == httpx.codes.CONFLICT
    assert reason in answer.json()["detail"]
    assert is_idle(page)


def test_cancel_lets_the_robot_stand(page: Page) -> None:
    put(page, START)
    page.command("go_to", pose=FAR)
    eventually(lambda: moves(page), 30.0, "the robot moving")
    page.command("cancel")
    eventually(lambda: stands(page), 10.0, "the robot standing")
    assert planning(page)["outcome"] == "cancelled"


def test_a_persons_stop_ends_the_way_for_good(page: Page) -> None:
    put(page, START)
    page.command("go_to", pose=FAR)
    eventually(lambda: moves(page), 30.0, "the robot moving")
    page.command("stop")
    eventually(lambda: is_idle(page), 10.0, "the planner giving up")
    assert planning(page)["outcome"] == "interrupted"
    assert stands(page)
    status = page.get("sensors/status")
    assert status is not None
    assert (status["mode"], status["reason"]) == ("stopped", "stopped by command")


def test_the_robot_stands_when_the_planner_is_killed_and_it_comes_back_idle(page: Page) -> None:
    put(page, START)
    page.command("go_to", pose=FAR)
    eventually(lambda: moves(page), 30.0, "the robot moving")
    before = page.process("planner")
    killed = time.time_ns()
    os.kill(before["pid"], signal.SIGKILL)
    eventually(lambda: stands(page), 5.0, "the robot standing")
    odometry = page.get("sensors/odometry")
    assert odometry is not None
    figure(f"planner killed: stands {(odometry['stamp_ns'] - killed) / 1e9:.2f} s later")
    eventually(lambda: page.is_back("planner", before["restarts"]), 60.0, "the planner again")
    eventually(lambda: planning(page).get("outcome") == "interrupted", 20.0, "its account")
    assert "restarted while going to (47.50, 20.80)" in str(planning(page)["reason"])
    assert is_idle(page)
    assert stands(page)


def test_a_robot_that_always_localizes_drives_out_of_a_room_like_others(page: Page) -> None:
    put(page, START)
    page.command("localize_actively", always=True)
    page.command("wander", enabled=True)
    began = time.monotonic()
    page.command("kidnap", pose=ALIKE)
    eventually(lambda: planning(page).get("mode") == "localizing", 30.0, "the search")
    plan = eventually(lambda: page.get("plan"), 10.0, "the plan")
    assert isinstance(plan, dict)
    eventually(lambda: is_idle(page), 120.0, "the end of the search")
    assert planning(page)["outcome"] == "done", planning(page)
    page.localized(within=10.0)
    figure(f"kidnapped into an alike room: localized {time.monotonic() - began:.1f} s later")
    eventually(
        lambda: (page.get("sensors/status") or {}).get("mode") == "wandering", 10.0, "wandering on"
    )
