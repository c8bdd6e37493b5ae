"""Empty, live, old, lost, found again: the page says which and never looks fresher than it is."""

import secrets

import pytest
from playwright.sync_api import Browser, expect

from browser.conftest import OpenPage, Picture
from browser.live_gateway import LiveGateway
from browser.looks import painted, wait_for_places
from browser.show import Show

pytestmark = pytest.mark.browser

HERE = (15.5, 6.5, 0.0)
DOWN = (("state", "down"), ("try_number", 2), ("reason", "killed by signal 9"))


def test_without_data_the_page_names_what_it_waits_for(
    open_page: OpenPage, picture: Picture
) -> None:
    page = open_page()
    expect(page.locator("[data-chip=state]")).to_have_text("No data")
    expect(page.locator("#waiting")).to_have_text("Waiting for the map from mapper")
    belief = page.locator("[data-layer=belief]")
    expect(belief).to_have_text("Belief · none yet")
    expect(belief).to_have_attribute("title", "Topic belief has not come; localizer should send it")
    for button in page.locator("[data-action]").all():
        expect(button).to_be_disabled()
        assert button.locator("+ p").inner_text() != ""
    picture(page, "empty")


@pytest.mark.usefixtures("show")
def test_the_first_picture_has_everything(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_places(page)
    expect(page.locator("#source")).to_have_text("demo")
    expect(page.locator("#notice")).to_contain_text("This is a simulation. Connect your robot")
    expect(page.locator("[data-chip=localizer]")).to_have_text("Localizer 9.8\u202fHz")
    expect(page.locator("[data-chip=link]")).to_contain_text("Link")
    expect(page.locator(".place").first).to_contain_text("x 15.5, y 6.5")
    expect(page.locator("#elsewhere")).to_have_text("Elsewhere 6\u202f%")
    assert painted(page, "#floor") > 100_000
    assert painted(page, "#live") > 1_000


def test_localized_the_number_is_the_calibrated_confidence(
    show: Show, open_page: OpenPage, picture: Picture
) -> None:
    show.change(state="localized", confidence=0.93, pose=HERE, places=((0.98, *HERE),))
    page = open_page()
    expect(page.locator("[data-chip=state]")).to_have_text("Localized")
    expect(page.locator("#certainty")).to_have_text("93\u202f%")
    expect(page.locator("#where")).to_contain_text("inside 0.5\u202fm and 15°")
    page.keyboard.press("4")
    picture(page, "localized")


def test_an_old_pose_looks_old_and_then_is_no_number_any_more(
    show: Show, open_page: OpenPage
) -> None:
    page = open_page()
    wait_for_places(page)
    show.change(silent=frozenset({"localizer"}))
    expect(page.locator("#stage.is-stale")).to_be_attached()
    expect(page.locator("[data-chip=localizer]")).to_contain_text("Localizer late")
    expect(page.locator("#age")).to_contain_text("s old")
    expect(page.locator("#whereabouts.is-old")).to_be_attached()
    expect(page.locator("#certainty")).to_have_text("—")
    expect(page.locator("[data-chip=state]")).to_have_text("No data")
    show.change(silent=frozenset())
    expect(page.locator("#certainty")).to_have_text("58\u202f%")
    expect(page.locator("#age")).to_be_hidden()


def test_a_service_that_is_down_is_named_with_what_it_means(
    show: Show, open_page: OpenPage, picture: Picture
) -> None:
    page = open_page()
    wait_for_places(page)
    show.change(silent=frozenset({"localizer"}), localizer=DOWN)
    chip = page.locator("[data-chip=localizer]")
    expect(chip).to_have_text("Localizer down, restarting, try 2 of 5")
    expect(page.locator("#chips > :nth-child(2)")).to_have_attribute("data-chip", "localizer")
    expect(page.locator("#banner")).to_have_text(
        "Localizer stopped (killed by signal 9). The pose on the map is frozen. "
        "Restarting, try 2 of 5."
    )
    expect(page.locator("#alarm")).to_have_text("Localizer down, restarting, try 2 of 5")
    expect(page.locator("[data-action=set_pose] + p")).to_have_text("The localizer is down")
    expect(page.locator("#age")).to_be_visible()
    picture(page, "stale")
    show.change(silent=frozenset(), localizer=())
    expect(page.locator("#banner")).to_be_hidden()


@pytest.mark.usefixtures("show")
def test_a_lost_gateway_greys_the_map_and_comes_back_by_itself(
    gateway: LiveGateway, open_page: OpenPage, picture: Picture
) -> None:
    page = open_page()
    wait_for_places(page)
    gateway.unplug()
    expect(page.locator("#banner")).to_contain_text("No contact since")
    expect(page.locator("#banner")).to_contain_text("Stop cannot reach the robot")
    expect(page.locator("#stage.is-lost")).to_be_attached()
    expect(page.locator("[data-chip=link]")).to_have_text("No contact")
    expect(page.locator("[data-action=wander]")).to_be_disabled()
    expect(page.locator("#stop")).to_be_enabled()
    picture(page, "lost")
    page.locator("#stop").click()
    expect(page.locator("#popover")).to_contain_text("The gateway cannot be reached")
    gateway.plug()
    expect(page.locator("#banner")).to_be_hidden()
    expect(page.locator("#stage.is-lost")).not_to_be_attached()
    expect(page.locator("#certainty")).to_have_text("58\u202f%")


@pytest.mark.usefixtures("show")
def test_a_lost_bus_is_told_from_a_lost_gateway(gateway: LiveGateway, open_page: OpenPage) -> None:
    page = open_page()
    wait_for_places(page)
    gateway.fabric.connected = False
    expect(page.locator("[data-chip=link]")).to_have_text("Bus lost")
    expect(page.locator("#banner")).to_contain_text("The bus is gone since")
    expect(page.locator("[data-action=kidnap] + p")).to_have_text("The gateway has lost the bus")
    gateway.fabric.connected = True
    expect(page.locator("#banner")).to_be_hidden()


def test_a_replayed_run_shows_its_progress_and_cannot_be_driven(
    show: Show, open_page: OpenPage
) -> None:
    show.change(source="replay", mode="replaying", commands=())
    page = open_page()
    expect(page.locator("#source")).to_have_text("replay 42\u202f%")
    expect(page.locator("#notice")).to_be_hidden()
    expect(page.locator("#drive-reason")).to_have_text("A recorded run cannot be driven")
    kidnap = page.locator("[data-action=kidnap] + p")
    expect(kidnap).to_have_text("Only a simulated robot can be carried away")


def test_a_token_comes_in_the_fragment_and_leaves_the_address(browser: Browser) -> None:
    token = secrets.token_hex()
    with LiveGateway(operator_tokens=[token]) as gateway, Show(gateway):
        page = browser.new_page()
        page.goto(gateway.url)
        expect(page.locator("#waiting")).to_contain_text("This gateway wants a token")
        page.goto(f"{gateway.url}#token={token}")
        page.reload()
        wait_for_places(page)
        assert page.url == gateway.url
        page.locator("#stop").click()
        expect(page.locator("#stop")).to_have_text("Stopped 0.08\u202fs")
        page.close()


@pytest.mark.usefixtures("show")
def test_a_chip_tells_more_when_pressed(open_page: OpenPage) -> None:
    page = open_page()
    wait_for_places(page)
    page.locator("[data-chip=localizer]").click()
    popover = page.locator("#popover")
    expect(popover).to_contain_text("ready since")
    expect(popover).to_contain_text("9.8\u202fHz, limit 1.0\u202fs")
    page.keyboard.press("Escape")
    expect(popover).to_be_hidden()
