"""The topological map on the page: its layer, the pairs that are matched, what is told of both."""

import math

import pytest
from playwright.sync_api import Locator, Page, expect

from browser.conftest import OpenPage, Picture, TopologyDesk
from browser.live_gateway import LiveGateway
from browser.looks import PHONE, wait_for_places
from browser.planning_looks import GREY, SOLID, WHITE, Colour, seen
from browser.show import Show
from browser.topology_show import HERE, NORTH, TopologyShow, node
from waiting import eventually

pytestmark = pytest.mark.browser

GRAPH = (139, 238, 189)
GRAPH_LIGHT = (25, 102, 89)
PANEL = (21, 28, 35)
TEXT_1, TEXT_2 = (232, 237, 242), (169, 182, 194)
ON_EDGE = (17.0, 6.5)
EMPTY_ROOM = (10.0, 2.6)
AT_PLACE, ROOM_PLACE = (11.85, 6.5), (11.2, 9.5)
OTHERS = ("belief", "places", "trail", "truth", "potential", "looks", "goal", "matches")

IN_WALLS = """(colour) => {
  const read = (id) => {
    const canvas = document.querySelector(id);
    const copy = new OffscreenCanvas(canvas.width, canvas.height);
    const context = copy.getContext('2d', { willReadFrequently: true });
    context.drawImage(canvas, 0, 0);
    return context.getImageData(0, 0, canvas.width, canvas.height);
  };
  const [floor, live] = [read('#floor'), read('#live')];
  const { width } = floor;
  const isWall = (i) => floor.data[4 * i] > 190 && floor.data[4 * i + 3] > 200;
  let n = 0;
  for (let i = 2 * width; i < floor.data.length / 4 - 2 * width; i++) {
    if (live.data[4 * i + 3] < 120) continue;
    if (![0, 1, 2].every((c) => Math.abs(live.data[4 * i + c] - colour[c]) < 24)) continue;
    // Doors touch the wall's rim: only what lies within it counts.
    if ([0, -2, 2, -2 * width, 2 * width].every((step) => isWall(i + step))) n++;
  }
  return n;
}"""


@pytest.fixture
def page(topology_desk: TopologyDesk) -> Page:
    return topology_desk.page


@pytest.fixture
def show(topology_desk: TopologyDesk) -> TopologyShow:
    return topology_desk.show


def chip(page: Page, layer: str) -> Locator:
    return page.locator(f"[data-layer={layer}]")


def only_graph(page: Page) -> None:
    """Switch every other layer off."""
    for layer in OTHERS:
        chip(page, layer).click()
        expect(chip(page, layer)).to_have_attribute("aria-pressed", "false")


def in_walls(page: Page, colour: Colour) -> int:
    """Return how many pixels of a colour lie within walls."""
    count = page.evaluate(IN_WALLS, list(colour))
    assert isinstance(count, int)
    return count


def test_the_graph_is_places_and_ways_and_key_9_switches_it(page: Page, picture: Picture) -> None:
    only_graph(page)
    eventually(lambda: seen(page, GRAPH, ROOM_PLACE, 9, SOLID) > 20, 5.0, "a place")
    assert seen(page, PANEL, ROOM_PLACE, 3, SOLID) > 8, "the inside of a place that is not here"
    assert 6 < seen(page, GRAPH, ON_EDGE, 10, 100) < 70, "a thin way, not at full strength"
    assert seen(page, GRAPH, ON_EDGE, 10, SOLID) == 0
    assert seen(page, GRAPH, EMPTY_ROOM, 10, 1) == 0
    picture(page, "topology-graph")
    page.keyboard.press("9")
    expect(chip(page, "graph")).to_have_attribute("aria-pressed", "false")
    eventually(lambda: seen(page, GRAPH, least=60) == 0, 5.0, "no graph")


def test_the_place_where_it_is_is_filled_and_named(page: Page, show: TopologyShow) -> None:
    only_graph(page)
    assert seen(page, PANEL, AT_PLACE, 3, SOLID) > 8
    expect(page.locator("#last-place")).to_have_text("At Corridor 4: 2 of 3 features matched")
    show.put(at=3)
    eventually(lambda: seen(page, GRAPH, AT_PLACE, 3, SOLID) > 20, 5.0, "the place filled")
    expect(page.locator("#last-place")).to_have_text("Last at Corridor 3, 3.7\u202fm away")
    show.find_again(HERE)
    told = page.locator("#last-place")
    expect(told).to_have_text("Found again at Corridor 4: 3 features matched")
    eventually(lambda: seen(page, PANEL, AT_PLACE, 3, SOLID) > 8, 5.0, "the place empty again")


def test_ways_do_not_run_through_walls(page: Page, show: TopologyShow) -> None:
    only_graph(page)
    eventually(lambda: seen(page, GRAPH, ON_EDGE, 10, 100) > 6, 5.0, "a way")
    assert in_walls(page, GRAPH) == 0
    show.put(has_ways=False)
    eventually(lambda: in_walls(page, GRAPH) > 10, 5.0, "what this test would see of such a way")


def test_doors_passages_and_corners_have_forms_of_their_own(page: Page, picture: Picture) -> None:
    only_graph(page)
    x, _ = NORTH[1]
    leaf, sill = (x - 0.55, 8.3), (x, 7.75)
    eventually(lambda: seen(page, GRAPH, leaf, 4, 100) > 6, 5.0, "the open leaf of a door")
    assert seen(page, GRAPH, (x + 0.2, 8.78), 8, 100) > 6, "the arc that it swings through"
    assert seen(page, GRAPH, (7.0, 7.65), 6, 100) > 6, "a jamb of the passage"
    assert seen(page, GRAPH, (0.4, 7.45), 10, 100) > 10, "the corner at the corridor's end"
    assert seen(page, GRAPH, (sill[0] + 0.3, sill[1]), 3, 100) == 0, "the opening is open"
    picture(page, "topology-features")


def test_places_it_could_be_have_the_names_of_the_graph(page: Page) -> None:
    rows = page.locator(".place > span:nth-child(2) > span:first-child")
    expect(rows).to_have_text(["Corridor\u00a04", "Corridor\u00a02", "Door\u00a04"])
    expect(page.locator("#where")).to_contain_text("place 1 · Corridor\u00a04")
    about = page.locator(".place > span:nth-child(2)").first
    expect(about).to_have_attribute("title", "x\u00a015.5,\u00a0y\u00a06.5\u202fm")


def test_pairs_are_two_lines_and_a_dash_and_they_are_counted(
    page: Page, show: TopologyShow, picture: Picture
) -> None:
    chart = page.locator("[data-chart=pairs]")
    expect(page.locator("#matched strong")).to_have_text("8")
    expect(page.locator("#matched span")).to_have_text("5 lines, 2 corners, 1 door")
    expect(chart.locator("output")).to_have_text("5")
    for layer in ("belief", "potential", "graph"):
        chip(page, layer).click()
    wall, beyond = (17.2, 7.7), (17.2, 8.0)
    eventually(lambda: seen(page, WHITE, beyond, 6, SOLID) > 10, 5.0, "what is seen")
    assert seen(page, WHITE, wall, 3, SOLID) == 0
    assert seen(page, GRAPH, wall, 4, 100) > 20, "what the map has"
    assert 4 < seen(page, TEXT_1, (17.2, 7.85), 5, 120) < 40, "the dash between"
    picture(page, "topology-matched")
    show.put(lines=2, features=0)
    expect(page.locator("#matched span")).to_have_text("2 lines")
    expect(chart.locator("output")).to_have_text("2")
    show.put(lines=0)
    expect(page.locator("#matched strong")).to_have_text("0")
    expect(page.locator("#matched span")).to_have_text("no pair")
    page.keyboard.press("m")
    expect(page.locator("#matched")).to_be_hidden()


DASHED = """() => {
  const canvas = document.querySelector("[data-chart=mass] canvas");
  const copy = new OffscreenCanvas(canvas.width, canvas.height);
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(40, 0, canvas.width - 40, canvas.height);
  let n = 0;
  for (let i = 0; i < data.length; i += 4) {
    const isIt = [133, 147, 161].every((value, c) => Math.abs(data[i + c] - value) < 30);
    if (isIt && data[i + 3] > 60) n++;
  }
  return n;
}"""


def test_places_reached_and_poses_found_again_are_dashed_lines_in_the_charts(
    topology: TopologyShow, open_page: OpenPage
) -> None:
    page = open_page()
    wait_for_places(page)
    told = page.locator("#last-place")
    expect(told).to_contain_text("At Corridor 4")
    # So that the next line is not drawn upon the last.
    page.wait_for_timeout(1500)
    at_first = page.evaluate(DASHED)
    topology.put(at=3)
    expect(told).to_contain_text("Corridor 3")

    def drawn() -> int:
        """More than the few pixels that lines gain and lose as the chart moves on."""
        more = int(page.evaluate(DASHED)) - at_first
        return more if more > 30 else 0

    line = eventually(drawn, 5.0, "the next place")
    assert line < 160, "half of 104 px, over one column or two"
    page.wait_for_timeout(1500)
    topology.find_again(HERE)
    expect(told).to_contain_text("Found again at Corridor 4")
    eventually(lambda: page.evaluate(DASHED) > at_first + 1.2 * line, 5.0, "the pose found again")


def test_old_pairs_turn_grey_and_vanish(page: Page, show: TopologyShow) -> None:
    for layer in ("belief", "potential", "graph", "trail", "truth"):
        chip(page, layer).click()
    show.change(silent=frozenset({"matched_lines", "matched_features"}))
    eventually(lambda: seen(page, GREY, (17.2, 8.0), 6, 200) > 10, 5.0, "a grey line")
    expect(page.locator("#matched.is-old")).to_be_attached()
    expect(page.locator("#matched strong")).to_have_text("—")
    expect(page.locator("[data-chart=pairs] output")).to_have_text("—")
    expect(chip(page, "matches")).to_have_text("Matched · none now")
    eventually(lambda: seen(page, GREY, (17.2, 8.0), 6, 100) == 0, 5.0, "no pair any more")


def test_the_graph_of_another_map_is_not_drawn_on_this_one(page: Page, show: TopologyShow) -> None:
    only_graph(page)
    show.put(map_id="another")
    expect(chip(page, "graph")).to_have_text("Graph · of another map")
    expect(chip(page, "graph")).to_have_attribute(
        "title", "The topological map in use is not of this map: build or load one"
    )
    eventually(lambda: seen(page, GRAPH, least=60) == 0, 5.0, "no graph")
    expect(page.locator("#where")).to_contain_text("x\u00a015.5")


def test_without_its_service_the_graph_is_grey(page: Page, show: TopologyShow) -> None:
    only_graph(page)
    show.change(topology="down")
    expect(chip(page, "graph")).to_have_text("Graph · old")
    expect(chip(page, "graph")).to_have_attribute(
        "title", "The topology service is down; the graph is as it was"
    )
    eventually(lambda: seen(page, GRAPH, least=60) == 0, 5.0, "no colour")
    assert seen(page, GREY, least=SOLID) > 200


def test_without_topology_the_chips_name_topic_and_service(
    gateway: LiveGateway, open_page: OpenPage
) -> None:
    with Show(gateway):
        page = open_page()
        wait_for_places(page)
        expect_no_graph(page)


def expect_no_graph(page: Page) -> None:
    expect(chip(page, "graph")).to_have_text("Graph · none yet")
    missing = "Topic topology has not come; topology should send it"
    expect(chip(page, "graph")).to_have_attribute("title", missing)
    expect(chip(page, "matches")).to_have_text("Matched · none yet")
    neither = "Neither matched_lines of localizer nor matched_features of topology has come"
    expect(chip(page, "matches")).to_have_attribute("title", neither)
    expect(page.locator("#matched")).to_be_hidden()
    expect(page.locator("[data-chart=pairs]")).to_be_hidden()
    expect(page.locator("figure.chart:visible")).to_have_count(3)


def test_the_camera_shows_where_it_looks_and_what_it_sees(
    page: Page, show: TopologyShow, picture: Picture
) -> None:
    only_graph(page)
    chip(page, "graph").click()
    expect(chip(page, "camera")).to_have_text("Camera · none yet")
    neither = "Neither vertical_edges of robot nor landmarks of robot has come"
    expect(chip(page, "camera")).to_have_attribute("title", neither)
    show.put(gaze=1.2)
    expect(chip(page, "camera")).to_have_text("Camera")
    landmark, ahead = (15.5, 8.5), (16.9, 6.95)
    assert seen(page, TEXT_1, landmark, 9) == 0, "it is off at first"
    page.keyboard.press("c")
    eventually(lambda: seen(page, TEXT_1, landmark, 9) > 20, 5.0, "a landmark")
    assert seen(page, TEXT_2, ahead, 8, 60) > 8, "the ray of an edge"
    bow = (15.5 + 0.8 * math.cos(1.2), 6.5 + 0.8 * math.sin(1.2))
    eventually(lambda: seen(page, TEXT_2, bow, 8) > 10, 5.0, "where it looks")
    picture(page, "topology-camera")
    show.put(gaze=None)
    eventually(lambda: seen(page, TEXT_1, landmark, 9) == 0, 5.0, "old sightings gone")


def test_by_daylight_the_graph_has_the_colour_of_the_light_theme(
    page: Page, picture: Picture
) -> None:
    page.emulate_media(color_scheme="light")
    eventually(lambda: seen(page, GRAPH_LIGHT, ROOM_PLACE, 9, SOLID) > 20, 5.0, "a place")
    picture(page, "topology-light")
    page.emulate_media(color_scheme="dark")


def test_the_pairs_chart_is_as_wide_as_the_others(page: Page) -> None:
    widths = page.evaluate(
        "[...document.querySelectorAll('.chart')].map((n) => n.getBoundingClientRect().width)"
    )
    assert len(widths) == 4
    assert max(widths) - min(widths) < 2
    assert page.evaluate("document.documentElement.scrollWidth") == 1440


def test_of_two_places_in_one_spot_one_is_drawn(page: Page, show: TopologyShow) -> None:
    only_graph(page)
    before = seen(page, GRAPH, ROOM_PLACE, 9, SOLID)
    x, y = ROOM_PLACE
    show.put(extra=(node(900, "node", "twin", (x + 0.02, y, 0.0)),))
    eventually(
        lambda: page.evaluate("document.querySelector('#topology-note').textContent").startswith(
            "22 places"
        ),
        5.0,
        "the larger graph",
    )
    assert abs(seen(page, GRAPH, ROOM_PLACE, 9, SOLID) - before) < 4


@pytest.mark.usefixtures("topology")
def test_a_phone_has_graph_and_count_above_its_sheet(open_page: OpenPage, picture: Picture) -> None:
    phone = open_page(viewport=PHONE, has_touch=True, device_scale_factor=2)
    wait_for_places(phone)
    eventually(lambda: seen(phone, GRAPH, (5.4, 9.5), 6, SOLID) > 20, 5.0, "a place")
    expect(phone.locator("#unfold")).to_have_text("+8")
    expect(phone.locator("#matched strong")).to_have_text("8")
    expect(phone.locator("[data-action=resolve]")).to_be_in_viewport(ratio=1.0)
    picture(phone, "topology-phone")
    phone.locator("#grab").tap()
    expect(phone.locator("#last-place")).to_be_visible()
