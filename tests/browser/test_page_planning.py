"""What the planner wants is on the map and in words, and never looks fresher than it is."""

from dataclasses import replace

import pytest
from playwright.sync_api import Page, expect

from browser.conftest import OpenPage, Picture
from browser.live_gateway import LiveGateway
from browser.looks import PHONE, wait_for_places
from browser.planning_looks import (
    GOAL,
    GOAL_LIGHT,
    GREY,
    SOLID,
    WHITE,
    next_look,
    on_page,
    seen,
)
from browser.planning_show import GOING, LOOKING, PlanningShow, Task
from browser.show import Show
from waiting import eventually

pytestmark = pytest.mark.browser

CHOSEN, OTHER = (19.5, 6.4), (21.5, 2.5)
ON_THE_WAY = (20.0, 6.55)
DESTINATION = (22.0, 2.5)
DRIVING = "Resolving doubt Drive 4.2\u202fm to A: \u22121.3\u202fbits expected."
SLOPE = (7.0, 2.3)
"""Right of the landmark at (2, 2): the field falls towards +x."""


def test_the_potential_is_contours_and_an_arrow_down_the_slope(
    planning_page: Page, planning_show: PlanningShow, picture: Picture
) -> None:
    page = planning_page
    eventually(lambda: seen(page, GOAL) > 1000, 10.0, "contours")
    assert seen(page, GOAL, least=SOLID) == 0
    page.mouse.move(*on_page(page, *SLOPE))
    x, y = SLOPE
    eventually(lambda: seen(page, GOAL, (x + 1.0, y), 16, SOLID) > 20, 5.0, "an arrow")
    assert seen(page, GOAL, (x - 1.0, y), 16, SOLID) == 0
    expect(page.locator("#readout")).to_contain_text("potential")
    planning_show.task = LOOKING
    picture(page, "planning-potential")
    page.keyboard.press("6")
    expect(page.locator("[data-layer=potential]")).to_have_attribute("aria-pressed", "false")
    eventually(lambda: seen(page, GOAL) == 0, 5.0, "no contours")
    page.keyboard.press("6")


def test_candidates_are_diamonds_and_a_dashed_way_leads_to_the_best(
    planning_page: Page, planning_show: PlanningShow, picture: Picture
) -> None:
    page = planning_page
    planning_show.task = LOOKING
    expect(next_look(page)).to_have_text(f"{DRIVING} Would tell place 1 from place 2.")
    eventually(lambda: seen(page, WHITE, CHOSEN, 9) > 20, 5.0, "the best candidate")
    assert seen(page, WHITE, OTHER, 9) > 10
    dashes = seen(page, WHITE, (18.0, 6.45), 12)
    assert 4 < dashes < 40, "of two by twenty-four pixels, every other four"
    picture(page, "planning-looks")
    page.keyboard.press("7")
    eventually(lambda: seen(page, WHITE, CHOSEN, 9) == 0, 5.0, "no candidates")
    page.keyboard.press("7")
    planning_show.task = Task(outcome="done", reason="it knows where it is")
    expect(next_look(page)).to_have_text("Done It knows where it is.")
    eventually(lambda: seen(page, WHITE, CHOSEN, 9) == 0, 5.0, "the plan vanishing")


def test_the_way_to_the_goal_is_solid_and_ends_in_a_ring(
    planning_page: Page, planning_show: PlanningShow, picture: Picture
) -> None:
    page = planning_page
    expect(page.locator("[data-layer=goal]")).to_be_visible()
    planning_show.task = GOING
    expect(next_look(page)).to_have_text("Going 9.3\u202fm left to x 22.0, y 2.5\u202fm.")
    eventually(lambda: seen(page, GOAL, DESTINATION, 12, SOLID) > 60, 5.0, "the goal")
    assert seen(page, GOAL, ON_THE_WAY, 12, SOLID) > 20
    picture(page, "planning-going")
    page.keyboard.press("8")
    eventually(lambda: seen(page, GOAL, DESTINATION, 12, SOLID) == 0, 5.0, "no goal")
    page.keyboard.press("8")
    eventually(lambda: seen(page, GOAL, DESTINATION, 12, SOLID) > 60, 5.0, "the goal again")
    planning_show.task = Task(outcome="done", reason="at (22.00, 2.50)")
    eventually(lambda: seen(page, GOAL, least=SOLID) == 0, 5.0, "goal and way vanishing")


def test_changes_are_announced_and_failures_as_alarms(
    planning_page: Page, planning_show: PlanningShow
) -> None:
    planning_show.task = GOING
    expect(planning_page.locator("#announce")).to_contain_text("Going. 9.3")
    planning_show.task = Task(outcome="failed", reason="the way is blocked")
    expect(planning_page.locator("#alarm")).to_have_text("Gave up. The way is blocked.")
    expect(planning_page.locator("#next.is-fault")).to_be_attached()


def test_the_wishes_of_a_silent_planner_turn_grey(
    planning_page: Page, planning_show: PlanningShow, picture: Picture
) -> None:
    page = planning_page
    planning_show.task = GOING
    eventually(lambda: seen(page, GOAL, DESTINATION, 12, SOLID) > 60, 5.0, "the goal")
    planning_show.task = replace(GOING, is_silent=True)
    expect(next_look(page)).to_contain_text("Planner silent No word for")
    eventually(lambda: seen(page, GREY, DESTINATION, 12, SOLID) > 60, 5.0, "a grey goal")
    assert seen(page, GOAL) == 0
    expect(page.locator("[data-action=send_goal] + p")).to_have_text("The planner is silent")
    picture(page, "planning-silent")
    planning_show.change(planner="down")
    expect(next_look(page)).to_contain_text("Planner down")
    expect(page.locator("[data-action=send_goal] + p")).to_have_text("The planner is down")
    expect(page.locator("#banner")).to_contain_text("Nothing drives by itself")


def test_an_old_pose_and_a_lost_link_grey_the_plan_as_well(
    gateway: LiveGateway, planning: PlanningShow, open_page: OpenPage, picture: Picture
) -> None:
    page = open_page()
    wait_for_places(page)
    planning.task = LOOKING
    expect(next_look(page)).to_contain_text("Resolving doubt")
    planning.change(silent=frozenset({"localizer"}))
    expect(page.locator("#stage.is-stale")).to_be_attached()
    filters = "getComputedStyle(document.querySelector('#live')).filter"
    assert page.evaluate(filters) == "saturate(0.2) opacity(0.6)"
    gateway.unplug()
    expect(page.locator("#stage.is-lost")).to_be_attached()
    for name in ("resolve", "wander", "send_goal"):
        expect(page.locator(f"[data-action={name}] + p")).to_have_text("No contact")
    expect(page.locator("#always")).to_be_disabled()
    picture(page, "planning-lost")
    gateway.plug()
    expect(page.locator("#banner")).to_be_hidden()


@pytest.mark.usefixtures("show")
def test_without_a_planner_layers_and_buttons_say_what_is_missing(
    show: Show, open_page: OpenPage
) -> None:
    page = open_page()
    wait_for_places(page)
    for layer, topic in (("potential", "potential"), ("looks", "plan"), ("goal", "goal")):
        chip = page.locator(f"[data-layer={layer}]")
        expect(chip).to_contain_text("none yet")
        told = f"Topic {topic} has not come; planner should send it"
        expect(chip).to_have_attribute("title", told)
    expect(next_look(page)).to_contain_text("No planner Topic planning_status has not come")
    expect(page.locator("[data-action=resolve] + p")).to_have_text("No planner runs here")
    expect(page.locator("[data-action=send_goal] + p")).to_have_text("No planner runs here")
    show.change(planner="starting")
    expect(page.locator("[data-action=resolve] + p")).to_have_text("The planner is starting")


def test_by_daylight_the_field_has_the_colour_of_the_light_theme(
    planning_page: Page, planning_show: PlanningShow, picture: Picture
) -> None:
    planning_show.task = LOOKING
    planning_page.emulate_media(color_scheme="light")
    eventually(lambda: seen(planning_page, GOAL_LIGHT) > 1000, 10.0, "contours")
    expect(next_look(planning_page)).to_contain_text("Resolving doubt")
    picture(planning_page, "planning-light")
    planning_page.emulate_media(color_scheme="dark")


def test_a_phone_has_the_plan_above_its_sheet_and_the_words_in_it(
    planning: PlanningShow, open_page: OpenPage, picture: Picture
) -> None:
    planning.task = LOOKING
    phone = open_page(viewport=PHONE, has_touch=True, device_scale_factor=2)
    wait_for_places(phone)
    eventually(lambda: seen(phone, GOAL) > 1000, 10.0, "contours")
    for name in ("resolve", "wander"):
        expect(phone.locator(f"[data-action={name}]")).to_be_in_viewport(ratio=1.0)
    expect(phone.locator("#next")).to_be_hidden()
    picture(phone, "planning-phone")
    phone.locator("#grab").tap()
    expect(phone.locator("[data-action=send_goal]")).to_be_in_viewport(ratio=1.0)
    expect(next_look(phone)).to_contain_text("Would tell place 1 from place 2.")
    picture(phone, "planning-phone-half")
