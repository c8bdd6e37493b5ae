"""Goals and doubts: what people want of the planner reaches it, and its answer is shown."""

import math
import secrets

import pytest
from playwright.sync_api import Browser, Page, expect

from browser.conftest import OpenPage, Picture
from browser.live_gateway import LiveGateway
from browser.looks import PHONE, wait_for_places
from browser.planning_looks import GOAL, SOLID, next_look, on_page, seen
from browser.planning_show import GOAL as WANTED
from browser.planning_show import GOING, LOOKING, PlanningShow, Task
from pilotage_schemas.commands import GoTo, LocalizeActively, Nothing, SetPose
from pilotage_schemas.message import Part
from waiting import eventually

pytestmark = pytest.mark.browser

RESOLVE = "[data-action=resolve]"
PAUSE = "[data-action=wander]"
SEND = "[data-action=send_goal]"


@pytest.fixture
def page(planning_page: Page) -> Page:
    return planning_page


@pytest.fixture
def show(planning_show: PlanningShow) -> PlanningShow:
    return planning_show


def asked(page: Page, show: PlanningShow, count: int = 1) -> list[tuple[str, Part]]:
    """Return what the services were asked, once it is `count` questions."""
    while len(show.asked) < count:
        page.wait_for_timeout(20)
    assert len(show.asked) == count
    return show.asked


def drag(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    """Press at one place of the map, let go at another."""
    page.mouse.move(*on_page(page, *start))
    page.mouse.down()
    page.mouse.move(*on_page(page, *end), steps=3)
    page.mouse.up()


def test_resolve_doubt_starts_and_ends_the_search(page: Page, show: PlanningShow) -> None:
    button = page.locator(RESOLVE)
    expect(button).to_have_text("Resolve doubt")
    button.click()
    expect(button).to_have_text("Stop resolving")
    expect(page.locator(f"{RESOLVE} + p")).to_have_text("Drives so as to find out")
    button.click()
    expect(button).to_have_text("Resolve doubt")
    expect(next_look(page)).to_contain_text("Cancelled")
    assert asked(page, show, 2) == [
        ("localize_actively", LocalizeActively()),
        ("cancel", Nothing()),
    ]


def test_without_a_doubt_there_is_nothing_to_resolve(page: Page, show: PlanningShow) -> None:
    show.change(state="localized", confidence=0.95)
    expect(page.locator(RESOLVE)).to_be_disabled()
    expect(page.locator(f"{RESOLVE} + p")).to_have_text("There is no doubt now")
    expect(page.locator("#always")).to_be_enabled()


def test_always_is_a_switch_that_shows_what_the_planner_says(
    page: Page, show: PlanningShow
) -> None:
    switch = page.get_by_role("switch", name="Always resolve doubt")
    expect(switch).not_to_be_checked()
    switch.focus()
    page.keyboard.press(" ")
    expect(switch).to_be_checked()
    assert asked(page, show) == [("localize_actively", LocalizeActively(always=True))]
    show.task = Task()
    expect(switch).not_to_be_checked()


def test_ending_the_standing_order_keeps_the_goal(page: Page, show: PlanningShow) -> None:
    show.plan(**vars(GOING) | {"always": True})
    switch = page.get_by_role("switch")
    expect(switch).to_be_checked()
    page.locator(".switch").click()
    expect(switch).not_to_be_checked()
    assert asked(page, show, 2) == [("cancel", Nothing()), ("go_to", GoTo(pose=WANTED))]
    expect(next_look(page)).to_contain_text("Going")


def test_pause_holds_the_goal_and_go_on_sends_it_again(page: Page, show: PlanningShow) -> None:
    show.task = GOING
    expect(next_look(page)).to_contain_text("Going")
    show.change(mode="commanded")
    button = page.locator(PAUSE)
    expect(button).to_have_text("Pause")
    button.click()
    expect(button).to_have_text("Go on")
    button.click()
    expect(button).to_have_text("Pause")
    assert asked(page, show, 2) == [("cancel", Nothing()), ("go_to", GoTo(pose=WANTED))]


def test_what_ended_otherwise_does_not_go_on(page: Page, show: PlanningShow) -> None:
    show.task = LOOKING
    show.change(mode="stopped")
    expect(page.locator(RESOLVE)).to_have_text("Stop resolving")
    page.locator(PAUSE).click()
    expect(page.locator(PAUSE)).to_have_text("Go on")
    show.task = Task(outcome="interrupted", reason="stopped by a person")
    expect(page.locator(PAUSE)).to_have_text("Wander")


def test_a_goal_is_pressed_dragged_and_confirmed(
    page: Page, show: PlanningShow, picture: Picture
) -> None:
    page.locator(SEND).click()
    expect(page.locator("#hint")).to_contain_text("Press where it shall go")
    drag(page, (13.0, 3.0), (13.0, 4.5))
    expect(page.locator("#aim")).to_contain_text("Go to 13.0, 3.0\u202fm, looking 90°?")
    assert seen(page, GOAL, (13.0, 3.0), 12, SOLID) > 60
    assert show.asked == []
    picture(page, "planning-aim")
    page.locator("[data-confirm]").click()
    expect(page.locator("#aim")).to_be_hidden()
    ((_, request),) = asked(page, show)
    assert isinstance(request, GoTo)
    assert request.heading_tolerance < 0.1
    found = request.pose
    assert (found.x, found.y) == pytest.approx((13.0, 3.0), abs=0.06)
    assert found.theta == pytest.approx(math.pi / 2, abs=0.02)
    expect(next_look(page)).to_contain_text("Going")


def test_a_goal_without_a_drag_leaves_the_heading_open(page: Page, show: PlanningShow) -> None:
    page.locator(SEND).click()
    page.mouse.click(*on_page(page, 13.0, 3.0))
    expect(page.locator("#aim")).to_contain_text("any heading?")
    page.keyboard.press("Enter")
    ((_, request),) = asked(page, show)
    assert isinstance(request, GoTo)
    assert request.heading_tolerance > 3.1


def test_a_refused_goal_says_why_where_the_ghost_is(
    page: Page, show: PlanningShow, picture: Picture
) -> None:
    show.refusal = "no way leads to (13.00, 3.00)"
    page.locator(SEND).click()
    page.mouse.click(*on_page(page, 13.0, 3.0))
    page.locator("[data-confirm]").click()
    box = page.locator("#aim")
    expect(box).to_contain_text("Not going: no way leads to (13.00, 3.00)")
    assert seen(page, GOAL, (13.0, 3.0), 12, SOLID) > 60
    near = box.bounding_box()
    x, y = on_page(page, 13.0, 3.0)
    assert near is not None
    assert abs(near["x"] - x) < 60
    assert abs(near["y"] - y) < 60
    picture(page, "planning-refused")
    show.refusal = ""
    page.mouse.click(*on_page(page, 14.0, 3.0))
    expect(box).to_contain_text("Go to 14.0, 3.0")
    page.keyboard.press("Escape")
    expect(box).to_be_hidden()
    page.locator("#stop").hover()
    eventually(lambda: seen(page, GOAL, least=SOLID) == 0, 5.0, "the ghost vanishing")
    assert len(show.asked) == 1


def test_a_goal_is_set_by_keys_alone_and_a_pose_still_is(page: Page, show: PlanningShow) -> None:
    page.locator(SEND).focus()
    for key in ("Enter", "Shift+ArrowLeft", "[", "[", "Enter"):
        page.keyboard.press(key)
    ((_, request),) = asked(page, show)
    assert isinstance(request, GoTo)
    assert request.pose.theta == pytest.approx(math.radians(10))
    expect(page.locator("#aim")).to_be_hidden()
    page.locator("[data-action=set_pose]").focus()
    for key in ("Enter", "ArrowUp", "Enter"):
        page.keyboard.press(key)
    assert isinstance(asked(page, show, 2)[1][1], SetPose)


def test_a_recorded_run_takes_no_goals(page: Page, show: PlanningShow) -> None:
    show.change(source="replay", mode="replaying", commands=())
    for button in (RESOLVE, PAUSE, SEND):
        expect(page.locator(f"{button} + p")).to_have_text("A recorded run cannot be driven")


def test_who_may_only_look_is_told_so(browser: Browser) -> None:
    token = secrets.token_hex()
    with LiveGateway(viewer_tokens=[token]) as gateway, PlanningShow(gateway) as show:
        page = browser.new_page()
        page.goto(f"{gateway.url}#token={token}")
        page.locator(RESOLVE).click()
        for button in (RESOLVE, PAUSE, SEND):
            expect(page.locator(f"{button} + p")).to_have_text("Your token lets you look only")
        assert show.asked == []
        page.close()


class Finger:
    """One finger on a page."""

    def __init__(self, page: Page) -> None:
        self._session = page.context.new_cdp_session(page)

    def put(self, x: float, y: float) -> None:
        self._send("touchStart", x, y)

    def move(self, x: float, y: float) -> None:
        self._send("touchMove", x, y)

    def lift(self) -> None:
        self._session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})

    def _send(self, kind: str, x: float, y: float) -> None:
        event = {"type": kind, "touchPoints": [{"x": x, "y": y}]}
        self._session.send("Input.dispatchTouchEvent", event)


def test_a_finger_that_rests_sets_a_goal_and_aims_it(
    planning: PlanningShow, open_page: OpenPage, picture: Picture
) -> None:
    phone = open_page(viewport=PHONE, has_touch=True, device_scale_factor=2)
    wait_for_places(phone)
    finger, (x, y) = Finger(phone), on_page(phone, 13.0, 3.0)
    finger.put(x, y)
    expect(phone.locator("#hint")).to_contain_text("Press where it shall go")
    finger.move(x, y - 30)
    finger.lift()
    expect(phone.locator("#aim")).to_contain_text("looking 90°?")
    picture(phone, "planning-phone-goal")
    assert planning.asked == []
    phone.locator("[data-confirm]").tap()
    ((_, request),) = asked(phone, planning)
    assert isinstance(request, GoTo)
    assert (request.pose.x, request.pose.y) == pytest.approx((13.0, 3.0), abs=0.2)


def test_a_finger_that_moves_on_pans_and_sets_nothing(page: Page, show: PlanningShow) -> None:
    finger, (x, y) = Finger(page), on_page(page, 13.0, 3.0)
    finger.put(x, y)
    finger.move(x + 40, y)
    page.wait_for_timeout(600)
    finger.lift()
    expect(page.locator("[data-tool=follow]")).to_have_attribute("aria-pressed", "false")
    expect(page.locator("#hint")).to_be_hidden()
    assert show.asked == []


def test_a_goal_that_cannot_be_is_refused_under_the_finger(page: Page, show: PlanningShow) -> None:
    show.change(planner="down")
    expect(page.locator(f"{SEND} + p")).to_have_text("The planner is down")
    finger, (x, y) = Finger(page), on_page(page, 13.0, 3.0)
    finger.put(x, y)
    expect(page.locator("#aim")).to_contain_text("Not going: The planner is down")
    finger.lift()
    expect(page.locator("[data-confirm]")).to_be_hidden()
    page.locator("[data-cancel]").click()
    expect(page.locator("#aim")).to_be_hidden()
    assert show.asked == []
