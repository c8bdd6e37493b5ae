"""Rules of the page's looks that a program can check: sizes, contrast, keyboard, weight."""

import gzip
import re
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from browser.conftest import Desk, OpenPage, Picture
from browser.looks import PHONE, wait_for_places

pytestmark = pytest.mark.browser

LIMIT_BYTES = 300_000

CONTRASTS = """() => {
  const channel = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  const light = ([r, g, b]) =>
    0.2126 * channel(r / 255) + 0.7152 * channel(g / 255) + 0.0722 * channel(b / 255);
  const parse = (text) => text.match(/[\\d.]+/g).map(Number);
  const ground = (node) => {
    for (; node; node = node.parentElement) {
      const colour = parse(getComputedStyle(node).backgroundColor);
      if (colour.length < 4 || colour[3] === 1) return colour;
    }
    return [0, 0, 0];
  };
  const low = [];
  for (const node of document.querySelectorAll("body *")) {
    const own = [...node.childNodes].some((c) => c.nodeType === 3 && c.data.trim());
    if (!own || !node.checkVisibility() || node.closest(".off-screen")) continue;
    const [a, b] = [light(parse(getComputedStyle(node).color)), light(ground(node))];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (contrast < 4.5) low.push(`${node.textContent.trim()}: ${contrast.toFixed(2)}`);
  }
  return low;
}"""

SMALL_TARGETS = """(least) => [...document.querySelectorAll("button, select")]
  .filter((node) => node.checkVisibility({ visibilityProperty: true }))
  .filter((node) => !node.matches(".chip, .layer, .plain, #stop, #grab"))
  .filter((node) => node.getBoundingClientRect().height < least)
  .map((node) => node.textContent.trim())"""


@pytest.fixture
def page(desk: Desk) -> Page:
    return desk.page


def box(page: Page, selector: str) -> dict[str, Any]:
    found = page.locator(selector).bounding_box()
    assert found is not None
    return dict(found)


def test_the_frame_is_as_designed(page: Page) -> None:
    assert box(page, "#strip")["height"] == 48
    assert box(page, "#panel")["width"] == 336
    assert box(page, "#charts")["height"] == 168
    assert box(page, "#charts")["width"] == 1440 - 336
    assert page.evaluate("document.documentElement.scrollHeight") == 900
    assert page.evaluate("document.documentElement.scrollWidth") == 1440


def test_one_number_is_big_and_one_button_primary(page: Page) -> None:
    sizes = page.evaluate(
        "[...document.querySelectorAll('body *')].filter((n) => n.checkVisibility())"
        ".filter((n) => getComputedStyle(n).fontSize === '40px').map((n) => n.id)"
    )
    assert sizes == ["certainty"]
    expect(page.locator(".is-primary")).to_have_count(1)
    least = page.evaluate(
        "Math.min(...[...document.querySelectorAll('body *')].filter((n) => n.checkVisibility())"
        ".map((n) => parseFloat(getComputedStyle(n).fontSize)))"
    )
    assert least >= 11


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_every_text_can_be_read(page: Page, picture: Picture, scheme: str) -> None:
    page.locator("#about summary").click()
    if scheme == "light":
        page.locator("[data-theme-switch]").click()
    expect(page.locator("html")).to_have_attribute("data-theme", scheme)
    assert page.evaluate(CONTRASTS) == []
    picture(page, scheme)


def test_controls_are_large_enough(page: Page) -> None:
    assert page.evaluate(SMALL_TARGETS, 40) == []


def test_the_keyboard_reaches_every_control_and_shows_where_it_is(page: Page) -> None:
    named = "n.id || JSON.stringify(n.dataset) + n.className + n.textContent.slice(0, 2)"
    reached = set()
    for _ in range(60):
        page.keyboard.press("Tab")
        seen = page.evaluate(
            "(() => { const n = document.activeElement; const s = getComputedStyle(n);"
            f"return [{named}, s.outlineStyle, n === document.body]; }})()"
        )
        if seen[2]:
            break
        assert seen[1] == "solid", seen
        reached.add(seen[0])
    folded = ":not(details:not([open]) > :not(summary) *)"
    shown = f"button:visible:enabled{folded}, select:visible, summary:visible, #live"
    assert set(page.locator(shown).evaluate_all(f"all => all.map((n) => {named})")) <= reached


@pytest.mark.usefixtures("show")
def test_a_phone_has_strip_map_and_sheet(open_page: OpenPage, picture: Picture) -> None:
    page = open_page(viewport=PHONE, has_touch=True, device_scale_factor=2)
    wait_for_places(page)
    picture(page, "phone")
    assert box(page, "#panel")["height"] == 148
    assert box(page, "#stop")["height"] == 44
    assert box(page, "#stage")["height"] == 844 - 48
    expect(page.locator("[data-layer=scan]")).to_be_hidden()
    page.locator("#unfold").tap()
    expect(page.locator("[data-layer=scan]")).to_be_visible()
    assert page.evaluate(SMALL_TARGETS, 44) == []
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    for share in (0.5, 0.92):
        page.locator("#grab").tap()
        page.wait_for_function(
            "(h) => Math.abs(document.querySelector('#panel').offsetHeight - h) < 1",
            arg=share * 844,
        )
        picture(page, f"phone-{share:.0%}")
    expect(page.locator("#panel #charts")).to_be_attached()


def test_a_middling_window_has_one_chart_at_a_time(page: Page, picture: Picture) -> None:
    page.set_viewport_size({"width": 900, "height": 700})
    expect(page.locator(".chart:visible")).to_have_count(1)
    page.locator("#charts-tabs button").nth(1).click()
    expect(page.locator(".chart:visible figcaption")).to_contain_text("Uncertainty")
    assert box(page, "#panel")["width"] == 288
    picture(page, "middle")
    page.set_viewport_size({"width": 1440, "height": 900})
    expect(page.locator(".chart:visible")).to_have_count(3)


def test_a_phone_on_its_side_has_map_and_panel(page: Page, picture: Picture) -> None:
    page.set_viewport_size({"width": 844, "height": 390})
    expect(page.locator("#charts")).to_be_hidden()
    assert box(page, "#panel")["width"] == 280
    assert box(page, "#stage")["height"] == 390 - 48
    picture(page, "landscape")
    page.set_viewport_size({"width": 1440, "height": 900})


def test_motion_is_reduced_where_that_is_wished(open_page: OpenPage) -> None:
    page = open_page(reduced_motion="reduce")
    durations = page.evaluate(
        "[...document.querySelectorAll('*')].map((n) => getComputedStyle(n).transitionDuration)"
    )
    assert set(durations) == {"0s"}
    assert page.evaluate(
        "import('/static/view.js').then((m) => { const v = new m.View();"
        "v.zoomBy(2, v.focus); return [v.scale, v.motion]; })"
    ) == [40, None]


def test_the_page_weighs_little(repository: Path) -> None:
    web = repository / "services" / "pilotage" / "gateway" / "web"
    files = [file for file in web.rglob("*") if file.is_file() and file.suffix != ".md"]
    assert sum(len(gzip.compress(file.read_bytes())) for file in files) <= LIMIT_BYTES


def test_the_page_needs_nothing_inline(repository: Path) -> None:
    page = (repository / "services/pilotage/gateway/web/index.html").read_text(encoding="utf-8")
    assert " style=" not in page
    assert "<style" not in page
    assert not re.search(r"\son[a-z]+=", page)
    assert page.count("<script") == 1
