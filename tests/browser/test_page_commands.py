"""What is pressed reaches the robot, once; what it answered is what is shown."""

import math

import pytest
from playwright.sync_api import Page, expect

from browser.conftest import Desk, Picture
from browser.show import Show
from pilotage_schemas.commands import Drive, SetPose, Turn, Velocity, Wander
from pilotage_schemas.message import Part

pytestmark = pytest.mark.browser


def asked(page: Page, show: Show, count: int = 1) -> list[tuple[str, Part]]:
    """Return what the services were asked, once it is `count` questions."""
    while len(show.asked) < count:
        page.wait_for_timeout(20)
    return show.asked


@pytest.fixture
def page(desk: Desk) -> Page:
    return desk.page


@pytest.fixture
def show(desk: Desk) -> Show:
    return desk.show


def test_a_click_is_one_step(page: Page, show: Show) -> None:
    page.locator("#distance").select_option("1")
    page.locator("[data-drive=forward]").click()
    page.locator("[data-drive=right]").click()
    (forward, drive), (turn, angle) = asked(page, show, 2)
    assert (forward, turn) == ("forward", "turn")
    assert isinstance(drive, Drive)
    assert drive.distance == 1.0
    assert isinstance(angle, Turn)
    assert angle.angle == pytest.approx(-math.pi / 2)


def test_a_held_button_drives_until_it_is_let_go(page: Page, show: Show) -> None:
    page.locator("[data-drive=left]").hover()
    page.mouse.down()
    asked(page, show, 3)
    page.mouse.up()
    expect(page.locator("[data-drive=left]")).not_to_have_class("is-held")
    while not is_still(show.asked[-1][1]):
        page.wait_for_timeout(20)
    assert {name for name, _ in show.asked} == {"velocity"}
    first = show.asked[0][1]
    assert isinstance(first, Velocity)
    assert first.twist.omega > 0.0


def is_still(request: Part) -> bool:
    return isinstance(request, Velocity) and request.twist.omega == request.twist.vx == 0.0


@pytest.mark.parametrize("way", ["click", "space", "escape twice"])
def test_stop_acts_at_once_and_shows_the_robots_answer(page: Page, show: Show, way: str) -> None:
    if way == "click":
        page.locator("#stop").click()
    elif way == "space":
        page.keyboard.press(" ")
    else:
        page.keyboard.press("Escape")
        page.keyboard.press("Escape")
    expect(page.locator("#stop")).to_have_text("Stopped 0.08\u202fs")
    assert [name for name, _ in show.asked] == ["stop"]
    expect(page.locator("#stop")).to_have_text("Stop")


def test_pause_turns_into_wander_when_the_robot_has_stopped(page: Page, show: Show) -> None:
    button = page.locator("[data-action=wander]")
    expect(button).to_have_text("Pause")
    button.click()
    expect(button).to_have_text("Wander")
    button.click()
    expect(button).to_have_text("Pause")
    assert [request for _, request in show.asked] == [Wander(enabled=False), Wander(enabled=True)]


def test_kidnap_and_forget_say_what_was_done(page: Page, show: Show) -> None:
    page.locator("[data-action=kidnap]").click()
    expect(page.locator("[data-action=kidnap] + p")).to_have_text("Put at 3.0, 2.0\u202fm")
    page.locator("[data-action=relocalize]").click()
    expect(page.locator("[data-action=relocalize] + p")).to_have_text("Begins from nothing")
    assert [name for name, _ in show.asked] == ["kidnap", "relocalize"]


def test_a_pose_is_pressed_dragged_and_confirmed(page: Page, show: Show, picture: Picture) -> None:
    page.locator("[data-action=set_pose]").click()
    box = page.locator("#live").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y - 60, steps=4)
    page.mouse.up()
    expect(page.locator("#aim")).to_contain_text("looking 90°?")
    assert show.asked == []
    picture(page, "aim")
    page.locator("[data-confirm]").click()
    expect(page.locator("#aim")).to_be_hidden()
    ((_, request),) = asked(page, show)
    assert isinstance(request, SetPose)
    assert request.pose.theta == pytest.approx(math.pi / 2)
    assert 0.0 < request.pose.x < 26.0
    assert 0.0 < request.pose.y < 13.0


def test_a_refused_pose_says_why_beside_the_ghost(page: Page, show: Show) -> None:
    show.refusal = "the pose is not in the map's free space"
    page.locator("[data-action=set_pose]").click()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("[")
    expect(page.locator("#aim")).to_contain_text("looking 5°?")
    page.keyboard.press("Enter")
    expect(page.locator("#aim")).to_contain_text("Not set: the pose is not in the map's free space")
    page.keyboard.press("Escape")
    expect(page.locator("#aim")).to_be_hidden()


def test_layers_are_switched_by_key_and_remembered(page: Page) -> None:
    scan = page.locator("[data-layer=scan]")
    expect(scan).to_have_attribute("aria-pressed", "false")
    page.keyboard.press("4")
    expect(scan).to_have_attribute("aria-pressed", "true")
    page.reload()
    expect(scan).to_have_attribute("aria-pressed", "true")


def test_panning_lets_go_of_the_robot_and_says_so(page: Page) -> None:
    follow = page.locator("[data-tool=follow]")
    expect(follow).to_have_attribute("aria-pressed", "true")
    page.mouse.move(500, 400)
    page.mouse.down()
    page.mouse.move(600, 420, steps=3)
    page.mouse.up()
    expect(follow).to_have_attribute("aria-pressed", "false")
    page.keyboard.press("0")
    expect(follow).to_have_attribute("aria-pressed", "true")


def test_the_pointer_reads_place_cell_and_mass(page: Page) -> None:
    page.mouse.move(500, 400)
    expect(page.locator("#readout")).to_contain_text("cell")
    expect(page.locator("#readout")).to_contain_text("mass")


def test_the_theme_is_switched_and_remembered(page: Page) -> None:
    page.locator("#about summary").click()
    page.locator("[data-theme-switch]").click()
    expect(page.locator("html")).to_have_attribute("data-theme", "light")
    page.reload()
    expect(page.locator("html")).to_have_attribute("data-theme", "light")
