"""A real browser before the real gateway; skipped, saying so, where there is no Chromium."""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from browser.live_gateway import LiveGateway
from browser.show import Show
from playwright.sync_api import Browser, Page, Request, sync_playwright

DESKTOP = {"width": 1440, "height": 900}
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--force-color-profile=srgb"]


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


OpenPage = Callable[..., Page]


@pytest.fixture
def open_page(browser: Browser, gateway: LiveGateway) -> Iterator[OpenPage]:
    """Open the page in a fresh browser profile; it must load nothing from elsewhere, nor fail."""
    contexts, troubles = [], []

    def watch(request: Request) -> None:
        if not request.url.startswith((gateway.url, gateway.url.replace("http", "ws"), "data:")):
            troubles.append(f"request to {request.url}")

    def opened(path: str = "", **options: object) -> Page:
        context = browser.new_context(**({"viewport": DESKTOP, "color_scheme": "dark"} | options))
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(8000)
        page.on("request", watch)
        page.on("pageerror", lambda error: troubles.append(f"error: {error}"))
        page.on(
            "console",
            lambda message: (
                troubles.append(f"console: {message.text}")
                if message.type == "error" and "ERR_CONNECTION_REFUSED" not in message.text
                else None
            ),
        )
        page.goto(gateway.url + path)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert troubles == []


@pytest.fixture(scope="session")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder for screenshots: PILOTAGE_SCREENSHOTS or a temporary one."""
    wanted = os.environ.get("PILOTAGE_SCREENSHOTS")
    folder = Path(wanted) if wanted else tmp_path_factory.mktemp("screenshots")
    folder.mkdir(parents=True, exist_ok=True)
    return folder
