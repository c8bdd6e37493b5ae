"""Pictures for people to look at; here only the rules that a program can check."""

from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from browser.conftest import OpenPage
from browser.live_gateway import LiveGateway
from browser.show import Show

pytestmark = pytest.mark.browser

PHONE = {"width": 390, "height": 844}
LOCALIZED = {
    "state": "localized",
    "confidence": 0.98,
    "places": ((0.98, 15.5, 6.5, 0.03),),
}


def see_places(page: Page) -> None:
    expect(page.locator("[data-chip=state]")).to_have_text("Ambiguous · 3 places")
    expect(page.locator(".place")).to_have_count(3)
    page.wait_for_function("document.querySelector('.bar i').style.transform !== ''")


def test_desktop_in_both_themes(show: Show, open_page: OpenPage, pictures: Path) -> None:
    for scheme in ("dark", "light"):
        page = open_page(color_scheme=scheme)
        see_places(page)
        page.wait_for_timeout(1500)
        page.screenshot(path=pictures / f"{scheme}.png")


def test_localized(show: Show, open_page: OpenPage, pictures: Path) -> None:
    show.change(**LOCALIZED)
    page = open_page()
    page.keyboard.press("4")
    expect(page.locator("[data-chip=state]")).to_have_text("Localized")
    page.wait_for_timeout(4000)
    page.screenshot(path=pictures / "localized.png")


def test_phone(show: Show, open_page: OpenPage, pictures: Path) -> None:
    page = open_page(viewport=PHONE, has_touch=True, device_scale_factor=2)
    see_places(page)
    page.wait_for_timeout(1000)
    page.screenshot(path=pictures / "phone.png")
    page.locator("#grab").click()
    page.wait_for_timeout(400)
    page.screenshot(path=pictures / "phone-half.png")
    page.locator("#grab").click()
    page.wait_for_timeout(400)
    page.screenshot(path=pictures / "phone-full.png")


def test_stale(show: Show, open_page: OpenPage, pictures: Path) -> None:
    page = open_page()
    see_places(page)
    show.change(silent=frozenset({"localizer"}), localizer=(("state", "down"), ("try_number", 2), ("reason", "killed by signal 9")))
    expect(page.locator("#age")).to_contain_text("old")
    expect(page.locator("#banner")).to_be_visible()
    page.wait_for_timeout(900)
    page.screenshot(path=pictures / "stale.png")


def test_lost_link(show: Show, gateway: LiveGateway, open_page: OpenPage, pictures: Path) -> None:
    page = open_page()
    see_places(page)
    gateway.unplug()
    expect(page.locator("#banner")).to_contain_text("No contact since")
    page.wait_for_timeout(4000)
    page.screenshot(path=pictures / "lost.png")
    gateway.plug()
    expect(page.locator("#banner")).to_be_hidden()


def test_nothing_yet(gateway: LiveGateway, open_page: OpenPage, pictures: Path) -> None:
    page = open_page()
    expect(page.locator("#waiting")).to_contain_text("Waiting for the map from mapper")
    page.screenshot(path=pictures / "empty.png")


def test_middle_width(show: Show, open_page: OpenPage, pictures: Path) -> None:
    page = open_page(viewport={"width": 900, "height": 700})
    see_places(page)
    page.screenshot(path=pictures / "middle.png")
