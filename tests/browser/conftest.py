"""A real browser before the real gateway; skipped, saying so, where there is no Chromium."""

import contextlib
import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import (
    Browser,
    BrowserContext,
    ConsoleMessage,
    Page,
    Request,
    expect,
    sync_playwright,
)

from browser.live_gateway import LiveGateway
from browser.looks import wait_for_commands, wait_for_places
from browser.planning_looks import next_look
from browser.planning_show import PlanningShow
from browser.show import Script, Show
from browser.topology_show import TopologyShow

DESKTOP = {"width": 1440, "height": 900}
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--force-color-profile=srgb"]
EXPECTED = ("ERR_CONNECTION_REFUSED", "ERR_EMPTY_RESPONSE", "status of 409", "status of 503")
"""What browsers log of connections that are cut and commands that are refused on purpose."""

OpenPage = Callable[..., Page]
Picture = Callable[[Page, str], None]

expect.set_options(timeout=10_000)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Debian's Chromium without a window."""
    if CHROMIUM is None:
        pytest.skip("chromium not found: apt-get install chromium")
    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield running
        running.close()


@pytest.fixture
def gateway() -> Iterator[LiveGateway]:
    """A gateway to which nobody has said anything yet."""
    with LiveGateway() as running:
        yield running


@pytest.fixture
def show(gateway: LiveGateway) -> Iterator[Show]:
    """A robot that could be in three places."""
    with Show(gateway) as running:
        yield running


@pytest.fixture
def planning(gateway: LiveGateway) -> Iterator[PlanningShow]:
    """A robot that could be in three places, and a planner."""
    with PlanningShow(gateway) as running:
        yield running


@pytest.fixture
def topology(gateway: LiveGateway) -> Iterator[TopologyShow]:
    """A robot that could be in three places of a graph."""
    with TopologyShow(gateway) as running:
        yield running


@pytest.fixture
def open_page(browser: Browser, gateway: LiveGateway) -> Iterator[OpenPage]:
    """Open the page in a fresh profile; it must neither load from elsewhere nor fail."""
    with watched_pages(browser, gateway) as opened:
        yield opened


@dataclass
class Desk:
    """A page and the show behind it, shared by the tests of one module."""

    page: Page
    show: Show


@pytest.fixture(scope="module")
def shared_desk(browser: Browser) -> Iterator[Desk]:
    """One gateway, show and page for many tests: starting them takes longer than most tests."""
    with (
        LiveGateway() as gateway,
        Show(gateway) as show,
        watched_pages(browser, gateway) as opened,
    ):
        yield Desk(opened(), show)


@pytest.fixture
def desk(shared_desk: Desk) -> Desk:
    """The shared page as if it were opened for the first time, the first picture standing."""
    shared_desk.show.script = Script()
    shared_desk.show.refusal = ""
    shared_desk.page.evaluate("localStorage.clear()")
    shared_desk.page.reload()
    wait_for_places(shared_desk.page)
    wait_for_commands(shared_desk.page)
    shared_desk.show.asked.clear()
    return shared_desk


@dataclass
class PlanningDesk:
    """A page and the planning robot behind it, shared by the tests of one module."""

    page: Page
    show: PlanningShow


@pytest.fixture(scope="module")
def shared_planning(browser: Browser) -> Iterator[PlanningDesk]:
    """One gateway, page and robot that plans for many tests."""
    with (
        LiveGateway() as gateway,
        PlanningShow(gateway) as show,
        watched_pages(browser, gateway) as opened,
    ):
        yield PlanningDesk(opened(), show)


@pytest.fixture
def planning_desk(shared_planning: PlanningDesk) -> PlanningDesk:
    """The shared page with the planner idle and nothing aimed; opening it anew takes longer."""
    page = shared_planning.page
    shared_planning.show.begin_anew()
    if page.locator("#stage.is-aiming").count():
        page.keyboard.press("Escape")
        page.wait_for_timeout(700)  # a second Escape within 0.6 s is Stop
    page.mouse.move(5, 5)
    wait_for_places(page)
    expect(next_look(page)).to_have_text("Idle Nothing is planned.")
    expect(page.locator("[data-action=wander]")).to_have_text("Pause")
    expect(page.locator("[data-action=resolve]")).to_be_enabled()
    return shared_planning


@pytest.fixture
def planning_page(planning_desk: PlanningDesk) -> Page:
    """The page before a robot that plans."""
    return planning_desk.page


@pytest.fixture
def planning_show(planning_desk: PlanningDesk) -> PlanningShow:
    """The robot that plans."""
    return planning_desk.show


@dataclass
class TopologyDesk:
    """A page and the robot with places behind it, shared by the tests of one module."""

    page: Page
    show: TopologyShow


@pytest.fixture(scope="module")
def shared_topology(browser: Browser) -> Iterator[TopologyDesk]:
    """One gateway, page and robot that knows places for many tests."""
    with (
        LiveGateway() as gateway,
        TopologyShow(gateway) as show,
        watched_pages(browser, gateway) as opened,
    ):
        yield TopologyDesk(opened(), show)


@pytest.fixture
def topology_desk(shared_topology: TopologyDesk) -> TopologyDesk:
    """The shared page as if opened for the first time, the graph standing, nothing asked."""
    shared_topology.show.begin_anew()
    shared_topology.page.evaluate("localStorage.clear()")
    shared_topology.page.reload()
    wait_for_places(shared_topology.page)
    expect(shared_topology.page.locator("[data-layer=graph]")).to_have_text("Graph")
    expect(shared_topology.page.locator("#matched")).to_be_visible()
    shared_topology.show.asked.clear()
    return shared_topology


@contextlib.contextmanager
def watched_pages(browser: Browser, gateway: LiveGateway) -> Iterator[OpenPage]:
    """Yield what opens pages; at the end none may have failed or asked anyone else."""
    contexts: list[BrowserContext] = []
    troubles: list[str] = []

    def watch_request(request: Request) -> None:
        if not request.url.startswith((gateway.url, gateway.url.replace("http", "ws"))):
            troubles.append(f"request to {request.url}")

    def watch_console(message: ConsoleMessage) -> None:
        is_expected = any(text in message.text for text in EXPECTED)
        if message.type in ("error", "warning") and not is_expected:
            troubles.append(f"console: {message.text}")

    def opened(**options: object) -> Page:
        wanted: dict[str, Any] = {"viewport": DESKTOP, "color_scheme": "dark"} | options
        context = browser.new_context(**wanted)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(10_000)
        page.on("request", watch_request)
        page.on("console", watch_console)
        page.on("pageerror", lambda error: troubles.append(f"error: {error}"))
        page.goto(gateway.url)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert troubles == []


@pytest.fixture(scope="module")
def modules(browser: Browser) -> Iterator[Page]:
    """A bare page of the gateway's origin, from which the page's modules can be imported."""
    with LiveGateway() as running:
        page = browser.new_page()
        page.goto(f"{running.url}healthz")
        yield page
        page.close()


@pytest.fixture(scope="session")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Picture:
    """Take a screenshot into PILOTAGE_SCREENSHOTS, or into a temporary folder."""
    wanted = os.environ.get("PILOTAGE_SCREENSHOTS")
    folder = Path(wanted) if wanted else tmp_path_factory.mktemp("screenshots")
    folder.mkdir(parents=True, exist_ok=True)

    def take(page: Page, name: str) -> None:
        page.screenshot(path=folder / f"{name}.png")

    return take
