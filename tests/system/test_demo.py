"""The demo as people start it: a robot finds out where it is, whatever happens to its services."""

import os
import signal
import time
from collections.abc import Iterator

import pytest

import processes
from pages import Page
from runs import REPOSITORY, Run, figure, lives
from waiting import eventually

pytestmark = [pytest.mark.system, pytest.mark.timeout(240)]

DEMO = REPOSITORY / "deploy" / "config" / "demo.yaml"
COLD_S = 120.0
"""A first start compiles every kernel, on a machine that may have other work."""


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
    began = time.monotonic()
    with Page(port) as page:
        eventually(lambda: page.answers("/healthz"), COLD_S, "/healthz")
        figure(f"/healthz after {time.monotonic() - began:.1f} s")
        page.localized(COLD_S)
        figure(f"localized after {time.monotonic() - began:.1f} s")
        assert "Traceback" not in run.text
        yield page


def test_a_robot_with_an_unknown_start_is_localized(page: Page) -> None:
    page.localized(within=60.0)
    assert page.answers("/readyz")


def test_every_process_is_ready_and_none_was_restarted(page: Page) -> None:
    deployment = page.get("deployment")
    assert deployment is not None
    states = {one["name"]: (one["state"], one["restarts"]) for one in deployment["processes"]}
    names = ("router", "gateway", "mapper", "robot", "localizer", "planner", "topology")
    assert states == dict.fromkeys(names, ("ready", 0))


def test_a_kidnapped_robot_finds_itself_again(page: Page) -> None:
    began = time.monotonic()
    page.command("kidnap")
    page.localized(within=60.0)
    figure(f"localized {time.monotonic() - began:.1f} s after being carried away")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP])
@pytest.mark.parametrize("name", ["localizer", "robot", "mapper", "gateway", "planner", "topology"])
def test_a_service_that_dies_or_hangs_is_back_with_the_picture(
    page: Page, name: str, number: signal.Signals
) -> None:
    page.localized(within=60.0)
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
    assert len(children) == 8
    assert not any(lives(pid) for pid in children)
