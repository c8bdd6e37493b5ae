"""The demo as people start it: a robot finds out where it is, whatever happens to its services."""

import math
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

import processes
from runs import REPOSITORY, Run, figure, lives
from waiting import eventually

pytestmark = [pytest.mark.system, pytest.mark.timeout(240)]

DEMO = REPOSITORY / "deploy" / "config" / "demo.yaml"
COLD_S = 120.0
"""A first start compiles every kernel, on a machine that may have other work."""

NEAR_M = 0.5
NEAR_RAD = math.radians(15.0)


class Page:
    """What the page knows of the robot, over HTTP."""

    def __init__(self, port: int) -> None:
        self._client = httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=5.0)

    def close(self) -> None:
        self._client.close()

    def answers(self, path: str) -> bool:
        """Say whether a path is served."""
        try:
            return self._client.get(path).status_code == httpx.codes.OK
        except httpx.TransportError:
            return False

    def get(self, what: str) -> dict[str, Any] | None:
        """Return the newest of something, None without one."""
        try:
            answer = self._client.get(f"/api/v1/robots/demo/{what}")
        except httpx.TransportError:
            return None
        return answer.json() if answer.status_code == httpx.codes.OK else None

    def command(self, name: str, **arguments: object) -> dict[str, Any]:
        """Give a command that must be carried out."""
        answer = self._client.post(f"/api/v1/robots/demo/commands/{name}", json=arguments)
        assert answer.status_code == httpx.codes.OK, answer.text
        reply: dict[str, Any] = answer.json()
        return reply

    def process(self, name: str) -> dict[str, Any]:
        """Return what the deployment says of a process."""
        deployment = self.get("deployment")
        found = deployment["processes"] if deployment else []
        return next((one for one in found if one["name"] == name), {})

    def is_back(self, name: str, restarts: int) -> bool:
        """Say whether a process is ready again after so many restarts."""
        one = self.process(name)
        return bool(one) and one["state"] == "ready" and one["restarts"] > restarts

    def is_localized_since(self, stamp_ns: int) -> bool:
        """Say whether a pose measured after `stamp_ns` is localized where the robot truly is."""
        pose, truth = self.get("pose"), self.get("sensors/ground_truth")
        if pose is None or truth is None or pose["stamp_ns"] < stamp_ns:
            return False
        return pose["state"] == "localized" and is_near(pose["pose"], truth["pose"])

    def localized(self, within: float) -> None:
        """Wait until a pose measured from now on is localized where the robot truly is."""
        began = time.time_ns()
        eventually(lambda: self.is_localized_since(began), within, "a localized pose")


def is_near(pose: dict[str, float], truth: dict[str, float]) -> bool:
    """Say whether two poses are the same place; the robot drives on between two answers."""
    way = math.hypot(pose["x"] - truth["x"], pose["y"] - truth["y"])
    turn = math.remainder(pose["theta"] - truth["theta"], math.tau)
    return way < NEAR_M and abs(turn) < NEAR_RAD


@pytest.fixture(scope="module")
def port() -> int:
    return processes.free_port()


@pytest.fixture(scope="module")
def run(port: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Run]:
    """The demo, shared by the tests of this module."""
    arguments = ["up", str(DEMO), "--no-browser", "--port", str(port)]
    with Run("pilotage", arguments, tmp_path_factory.mktemp("demo")) as run:
        yield run


@pytest.fixture(scope="module")
def page(port: int, run: Run) -> Iterator[Page]:
    """The page of the running demo, with the robot localized."""
    page, began = Page(port), time.monotonic()
    eventually(lambda: page.answers("/healthz"), COLD_S, "/healthz")
    figure(f"/healthz after {time.monotonic() - began:.1f} s")
    page.localized(COLD_S)
    figure(f"localized after {time.monotonic() - began:.1f} s")
    assert "Traceback" not in run.text
    yield page
    page.close()


def test_a_robot_with_an_unknown_start_is_localized(page: Page) -> None:
    page.localized(within=60.0)
    assert page.answers("/readyz")


def test_every_process_is_ready_and_none_was_restarted(page: Page) -> None:
    deployment = page.get("deployment")
    assert deployment is not None
    states = {one["name"]: (one["state"], one["restarts"]) for one in deployment["processes"]}
    names = ("router", "gateway", "mapper", "robot", "localizer")
    assert states == dict.fromkeys(names, ("ready", 0))


def test_a_kidnapped_robot_finds_itself_again(page: Page) -> None:
    began = time.monotonic()
    page.command("kidnap")
    page.localized(within=60.0)
    figure(f"localized {time.monotonic() - began:.1f} s after being carried away")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
@pytest.mark.parametrize("name", ["localizer", "robot", "mapper", "gateway"])
def test_a_service_that_dies_or_hangs_is_back_with_the_picture(
    page: Page, name: str, number: signal.Signals
) -> None:
    before = eventually(lambda: page.process(name), 20.0, "the deployment")
    began, stamp = time.monotonic(), time.time_ns()
    os.kill(before["pid"], number)
    if name != "gateway":
        eventually(lambda: page.process(name)["state"] != "ready", 20.0, "the failure noticed")
        figure(f"{name} {number.name}: noticed after {time.monotonic() - began:.2f} s")
    eventually(lambda: page.is_back(name, before["restarts"]), 30.0, f"{name} ready again")
    figure(f"{name} {number.name}: ready after {time.monotonic() - began:.2f} s")
    eventually(lambda: page.is_localized_since(stamp + 1), 60.0, "the picture")
    figure(f"{name} {number.name}: localized after {time.monotonic() - began:.2f} s")
    assert not lives(before["pid"])
    page.command("restart", service=name)
    eventually(lambda: page.is_back(name, before["restarts"] + 1), 30.0, "failures forgiven")


def test_everything_reconnects_after_the_router_s_death(page: Page) -> None:
    before = eventually(lambda: page.process("router"), 20.0, "the deployment")
    others = {name: page.process(name)["restarts"] for name in ("mapper", "robot", "localizer")}
    began = time.monotonic()
    os.kill(before["pid"], signal.SIGKILL)
    eventually(lambda: page.is_back("router", before["restarts"]), 30.0, "the router")
    page.localized(within=30.0)
    figure(f"router: everything is back after {time.monotonic() - began:.2f} s")
    assert {name: page.process(name)["restarts"] for name in others} == others


def test_ctrl_c_ends_everything(page: Page, run: Run) -> None:
    assert page.answers("/healthz")
    children, began = run.descendants(), time.monotonic()
    run.send(signal.SIGINT)
    assert run.ended(within=30.0) == 0
    figure(f"stopped after {time.monotonic() - began:.2f} s")
    assert len(children) == 6
    assert not any(lives(pid) for pid in children)


def test_the_demo_script_needs_nothing_else() -> None:
    script = Path(REPOSITORY / "deploy" / "demo")
    assert os.access(script, os.X_OK)
    assert "pilotage up deploy/config/demo.yaml" in script.read_text(encoding="utf-8")
