"""What can be done with a place: read its card, see the way there, go there, keep the graph."""

import pytest
from playwright.sync_api import Page, expect

from browser.conftest import OpenPage, Picture, TopologyDesk
from browser.looks import PHONE, wait_for_places
from browser.planning_looks import SOLID, on_page, seen
from browser.topology_show import (
    NORTH,
    ROUTE_WAY,
    SOUTH,
    TopologyShow,
    length,
    room,
)
from pilotage_schemas.commands import GoTo
from pilotage_schemas.topology import (
    Point,
    TopologyBuild,
    TopologyLoad,
    TopologyRoute,
    TopologySave,
)
from waiting import eventually

pytestmark = pytest.mark.browser

GRAPH = (139, 238, 189)
FAR_ROOM = (24.8, 9.5)
FAR_DOOR = (NORTH[3][0], 7.78)
FIRST_ROOM = (NORTH[0][1], 9.5)
ON_ROUTE = (18.5, 6.5)
ROBOT = (15.5, 6.5)


@pytest.fixture
def page(topology_desk: TopologyDesk) -> Page:
    return topology_desk.page


@pytest.fixture
def show(topology_desk: TopologyDesk) -> TopologyShow:
    return topology_desk.show


def press(page: Page, place: tuple[float, float]) -> None:
    page.mouse.click(*on_page(page, *place))


def note(page: Page, button: str) -> str:
    return page.locator(f"[data-place={button}] + p").inner_text()


def test_a_click_on_a_place_opens_its_card(page: Page, picture: Picture) -> None:
    press(page, FAR_DOOR)
    card = page.locator("#place")
    expect(page.locator("#place-name")).to_have_text("Door 3")
    expect(card.locator("[data-place=where]")).to_have_text("Door at x 21.6, y 7.8\u202fm")
    features = card.locator("[data-place=features]")
    expect(features).to_have_text("2 doors, 1 corner, 1.10\u202fm wide")
    picture(page, "topology-card")
    press(page, (24.0, 12.0))
    expect(card).to_be_hidden()
    press(page, FAR_ROOM)
    expect(page.locator("#place-name")).to_have_text("Room 3")
    page.keyboard.press("Escape")
    expect(card).to_be_hidden()


def test_a_drag_over_a_place_opens_nothing(page: Page) -> None:
    x, y = on_page(page, *FAR_ROOM)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 40, y, steps=4)
    page.mouse.up()
    expect(page.locator("#place")).to_be_hidden()


def test_the_route_to_a_place_is_drawn_with_its_length(
    page: Page, show: TopologyShow, picture: Picture
) -> None:
    thin = seen(page, GRAPH, ON_ROUTE, 8, SOLID)
    press(page, FAR_ROOM)
    page.locator("[data-place=route]").click()
    told = page.locator("[data-place=length]")
    metres = length(tuple((float(x), float(y)) for x, y in ROUTE_WAY))
    expect(told).to_have_text(f"{metres:.1f}\u202fm over 4 places")
    assert thin == 0
    wide = eventually(lambda: seen(page, GRAPH, ON_ROUTE, 8, SOLID), 5.0, "the route")
    assert 30 <= wide <= 64, "sixteen by three pixels"
    assert show.asked[-1] == (
        "topology_route",
        TopologyRoute(start=Point(x=ROBOT[0], y=ROBOT[1]), end=room(3)),
    )
    picture(page, "topology-route")
    show.change(pose=(17.0, 6.5, 0.0))
    expect(told).to_contain_text("from where it was")
    page.keyboard.press("Escape")
    eventually(lambda: seen(page, GRAPH, (19.5, 6.5), 6, SOLID) == 0, 5.0, "no route")


def test_a_refused_route_says_why_on_the_card(page: Page) -> None:
    press(page, FIRST_ROOM)
    page.locator("[data-place=route]").click()
    expect(page.locator("[data-place=route] + p")).to_have_text("no way leads there")
    expect(page.locator("[data-place=length]")).to_have_text("")


def test_go_here_sends_the_place_as_goal_whatever_the_heading(
    page: Page, show: TopologyShow
) -> None:
    press(page, FAR_ROOM)
    page.locator("[data-place=go]").click()
    expect(page.locator("[data-place=go] + p")).to_have_text("On the way")
    name, request = show.asked[-1]
    assert name == "go_to"
    assert isinstance(request, GoTo)
    assert (request.pose.x, request.pose.y) == FAR_ROOM
    assert request.heading_tolerance > 3.0
    show.refusal = "the way is blocked"
    page.locator("[data-place=go]").click()
    expect(page.locator("[data-place=go] + p")).to_have_text("the way is blocked")


def test_what_cannot_be_done_with_a_place_says_why(page: Page, show: TopologyShow) -> None:
    press(page, FAR_ROOM)
    show.change(topology="down")
    expect(page.locator("[data-place=route]")).to_be_disabled()
    assert note(page, "route") == "The topology service is down"
    show.change(topology="ready", planner="down")
    expect(page.locator("[data-place=go]")).to_be_disabled()
    assert note(page, "go") == "The planner is down"
    expect(page.locator("[data-place=route]")).to_be_enabled()


def test_the_card_hides_neither_robot_nor_place_nor_way(page: Page) -> None:
    for place in (FAR_ROOM, FIRST_ROOM, (SOUTH[2][1], 2.6), (SOUTH[0][1], 2.6)):
        press(page, place)
        box = page.locator("#place").bounding_box()
        assert box is not None
        for point in (place, ROBOT):
            x, y = on_page(page, *point)
            is_beside = not box["x"] <= x <= box["x"] + box["width"]
            assert is_beside or not box["y"] <= y <= box["y"] + box["height"]
        page.keyboard.press("Escape")


def test_places_are_reached_by_keys_alone(page: Page) -> None:
    page.keyboard.press("n")
    name = page.locator("#place-name")
    expect(name).to_have_text("Corridor 3")
    assert page.evaluate("document.activeElement.dataset.place") == "close"
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.dataset.place") == "route"
    page.keyboard.press("Tab")
    page.keyboard.press("Tab")
    chosen = page.evaluate("document.activeElement.firstChild.textContent")
    page.keyboard.press("Enter")
    expect(name).to_have_text(chosen)
    page.keyboard.press("Escape")
    expect(page.locator("#place")).to_be_hidden()
    assert page.evaluate("document.activeElement.id") == "live"


def test_the_card_keeps_nobody_from_stopping_the_robot(page: Page, show: TopologyShow) -> None:
    page.keyboard.press("n")
    expect(page.locator("#place")).to_be_visible()
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    eventually(lambda: "stop" in [name for name, _ in show.asked], 5.0, "the robot stopping")


def test_ways_lead_from_card_to_card(page: Page) -> None:
    press(page, FAR_ROOM)
    ways = page.locator("#place .way")
    expect(ways).to_have_text(["Corridor 65.4\u202fm"])
    ways.first.click()
    expect(page.locator("#place-name")).to_have_text("Corridor 6")
    expect(ways).to_have_count(2)


def test_a_graph_without_the_place_closes_its_card(page: Page, show: TopologyShow) -> None:
    press(page, FAR_ROOM)
    expect(page.locator("#place")).to_be_visible()
    show.put(map_id="another")
    expect(page.locator("#place")).to_be_hidden()


def test_the_graph_is_built_kept_and_used_again(
    page: Page, show: TopologyShow, picture: Picture
) -> None:
    page.locator("#mapping summary").click()
    told = page.locator("#topology-note")
    expect(told).to_have_text("21 places (2.3 features each), 13 ways.")
    page.locator("[data-topology=build]").click()
    expect(told).to_have_text("23 places and 22 ways")
    assert ("topology_build", TopologyBuild()) in show.asked
    page.locator("#spacing").select_option("2")
    page.locator("[data-topology=build]").click()
    spaced = ("topology_build", TopologyBuild(spacing="equal", metres=2.0))
    eventually(lambda: spaced in show.asked, 5.0, "the second order")
    page.locator("#topology-name").fill("no/name")
    page.locator("#topology-save button").click()
    expect(told).to_contain_text("A name has letters")
    page.locator("#topology-name").fill("upstairs")
    page.locator("#topology-save button").click()
    expect(told).to_have_text("Kept as upstairs")
    assert ("topology_save", TopologySave(name="upstairs")) in show.asked
    expect(page.locator("#topologies li")).to_have_count(2)
    picture(page, "topology-fold")
    page.get_by_role("button", name="Use the places upstairs").click()
    expect(told).to_have_text("upstairs is in use")
    assert ("topology_load", TopologyLoad(name="upstairs")) in show.asked


def test_a_refused_graph_says_why_and_a_missing_service_disables(
    page: Page, show: TopologyShow
) -> None:
    page.locator("#mapping summary").click()
    told = page.locator("#topology-note")
    show.refusal = "the map has no free space"
    page.locator("[data-topology=build]").click()
    expect(told).to_have_text("the map has no free space")
    show.change(topology="given_up")
    expect(page.locator("[data-topology=build]")).to_be_disabled()
    expect(page.locator("#topology-save button")).to_be_disabled()
    expect(told).to_have_text("The topology service is down", timeout=12_000)


@pytest.mark.usefixtures("topology")
def test_a_finger_opens_the_card_of_the_place_beneath_it(
    open_page: OpenPage, picture: Picture
) -> None:
    phone = open_page(viewport=PHONE, has_touch=True, device_scale_factor=2)
    wait_for_places(phone)
    expect(phone.locator("#matched")).to_be_visible()
    phone.touchscreen.tap(*on_page(phone, *FAR_ROOM))
    expect(phone.locator("#place-name")).to_have_text("Room 3")
    phone.locator("[data-place=route]").tap()
    expect(phone.locator("[data-place=length]")).to_contain_text("over 4 places")
    picture(phone, "topology-phone-card")
    for name in ("route", "go"):
        box = phone.locator(f"[data-place={name}]").bounding_box()
        assert box is not None
        assert box["height"] >= 44
    sheet = phone.locator("#panel").bounding_box()
    card = phone.locator("#place").bounding_box()
    assert sheet is not None
    assert card is not None
    assert card["y"] + card["height"] <= sheet["y"]
    phone.locator("[data-place=close]").tap()
    expect(phone.locator("#place")).to_be_hidden()
