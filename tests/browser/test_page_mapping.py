"""Making a map on the page: begun, watched as it grows, kept, finished, used again."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Page, expect

from browser.conftest import OpenPage, Picture
from browser.live_gateway import LiveGateway
from browser.looks import PHONE
from browser.mapping_show import MappingShow
from pilotage_schemas.commands import MapLoad, MapSave, MapStart, Nothing
from waiting import eventually

pytestmark = pytest.mark.browser

PATCHING = """import('/static/layers/walls.js').then(async (walls) => {
  const { readPalette } = await import('/static/palette.js');
  const palette = readPalette();
  const [rows, cols] = [%d, %d];
  let seed = 7;
  const next = (n) => (seed = (seed * 1103515245 + 12345) %% 2147483648) %% n;
  const cells = () => ({ shape: [rows, cols], data: new Int8Array(rows * cols).fill(-1) });
  const grid = { map_id: 'm', resolution: 0.05, origin: { x: 1, y: 2, theta: 0 }, cells: cells() };
  const patched = new walls.Walls();
  patched.take(grid, palette);
  const all = cells();
  for (let k = 0; k < 20; k++) {
    const [h, w] = [1 + next(9), 1 + next(9)];
    const [row, col] = [next(rows - h), next(cols - w)];
    const data = Int8Array.from({ length: h * w }, () => [-1, 0, 100][next(3)]);
    for (let r = 0; r < h; r++) {
      all.data.set(data.subarray(r * w, r * w + w), (row + r) * cols + col);
    }
    const patch = { map_id: 'm', row, col, cells: { shape: [h, w], data } };
    if (!patched.patch(patch, palette)) return 'refused';
  }
  const whole = new walls.Walls();
  whole.take({ ...grid, cells: all }, palette);
  const pixels = (image) =>
    image.getContext('2d').getImageData(0, 0, image.width, image.height).data;
  return patched.levels.map((level, i) => [
    String(level.kinds) === String(whole.levels[i].kinds),
    String(pixels(level.walls)) === String(pixels(whole.levels[i].walls)),
    String(pixels(level.floor)) === String(pixels(whole.levels[i].floor)),
  ]).concat([[patched.patch({ map_id: 'other', row: 0, col: 0, cells: all }, palette),
    patched.patch({ map_id: 'm', row: 1, col: 0, cells: all }, palette)]]);
})"""


@pytest.fixture
def mapping(gateway: LiveGateway) -> Iterator[MappingShow]:
    with MappingShow(gateway) as running:
        yield running


@pytest.fixture
def page(open_page: OpenPage, mapping: MappingShow) -> Page:
    """A page on which a map is being made."""
    page = open_page()
    mapping.mode = "mapping"
    expect(page.locator("[data-chip=state]")).to_have_text("Mapping")
    return page


def seen(page: Page) -> float:
    """Return how many pixels of the page's map are free floor."""
    area = page.evaluate(
        """import('/static/palette.js').then(({ readPalette, channels }) => {
          const canvas = document.querySelector('#floor');
          const [r, g, b] = channels(readPalette().free);
          const copy = new OffscreenCanvas(canvas.width, canvas.height);
          const context = copy.getContext('2d', { willReadFrequently: true });
          context.drawImage(canvas, 0, 0);
          const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
          let n = 0;
          for (let i = 0; i < data.length; i += 4) {
            if (data[i] === r && data[i + 1] === g && data[i + 2] === b && data[i + 3] === 255) n++;
          }
          return n;
        })"""
    )
    assert isinstance(area, int)
    return float(area)


def test_a_map_is_begun_by_a_button_and_the_state_says_so(
    open_page: OpenPage, mapping: MappingShow
) -> None:
    page = open_page()
    page.locator("#mapping-title").click()
    expect(page.locator("[data-map=toggle]")).to_have_text("Start mapping")
    expect(page.locator("[data-map=reset]")).to_be_disabled()
    page.locator("[data-map=toggle]").click()
    expect(page.locator("[data-chip=state]")).to_have_text("Mapping")
    expect(page.locator("[data-map=toggle]")).to_have_text("Stop mapping")
    assert mapping.asked == [("map_start", MapStart())]


def test_the_map_grows_by_patches_while_the_robot_drives(
    page: Page, mapping: MappingShow, picture: Picture
) -> None:
    expect(page.locator("#mapping-note")).to_contain_text("scans in the map")
    eventually(lambda: seen(page) > 0, 10.0, "a map")
    page.locator("[data-tool=out]").click()
    page.wait_for_timeout(300)
    first = seen(page)
    eventually(lambda: seen(page) > 1.5 * first, 20.0, "the map growing")
    picture(page, "mapping")
    assert len(mapping.asked) == 0


def test_the_view_stays_fitted_to_the_growing_map_until_somebody_moves_it(
    page: Page, mapping: MappingShow
) -> None:
    def place() -> str:
        """What the page says of the place under one and the same pixel."""
        page.mouse.move(400, 400)
        page.mouse.move(401, 400)
        page.wait_for_timeout(400)
        return page.locator("#readout").inner_text().split("·")[0].strip()

    eventually(lambda: seen(page) > 0, 10.0, "a map")
    fitted = place()
    eventually(lambda: place() != fitted, 15.0, "the view following the map")
    page.locator("[data-tool=follow]").click()
    page.locator("[data-tool=in]").click()
    page.wait_for_timeout(500)
    chosen, before = place(), len(mapping._way)
    eventually(lambda: len(mapping._way) > before + 30, 15.0, "some way")
    assert place() == chosen != ""


def test_who_opens_the_page_later_sees_the_same_map(
    page: Page, open_page: OpenPage, mapping: MappingShow
) -> None:
    eventually(lambda: len(mapping._way) > 60, 20.0, "some way")
    late = open_page()
    expect(late.locator("[data-chip=state]")).to_have_text("Mapping")
    eventually(lambda: abs(seen(late) - seen(page)) < 0.05 * seen(page) > 0, 20.0, "the same map")


def test_a_loop_that_is_closed_draws_the_map_anew(
    page: Page, mapping: MappingShow, picture: Picture
) -> None:
    eventually(lambda: len(mapping._way) > 40, 20.0, "some way")
    mapping.close_loop(0.5)
    expect(page.locator("#mapping-note")).to_contain_text("drawn anew once")
    page.wait_for_timeout(1200)
    picture(page, "mapping-redrawn")
    assert seen(page) > 0


def test_old_beliefs_are_gone_while_a_map_is_made(page: Page) -> None:
    expect(page.locator(".place")).to_have_count(0)
    expect(page.locator("#elsewhere")).to_have_text("On a map in the making there is only one.")
    expect(page.locator("#certainty")).to_contain_text("%")


def test_what_the_localizer_cannot_do_now_is_disabled_with_its_reason(page: Page) -> None:
    for action in ("set_pose", "relocalize"):
        button = page.locator(f"[data-action={action}]")
        expect(button).to_be_disabled()
        expect(button.locator("+ .reason")).to_have_text("A map is being made")


def test_a_map_is_kept_under_a_name_and_can_be_used_again(page: Page, mapping: MappingShow) -> None:
    page.locator("#map-name").fill("no/name")
    page.locator("#map-save button").click()
    expect(page.locator("#mapping-note")).to_contain_text("A name has letters")
    page.locator("#map-name").fill("ground_floor")
    page.locator("#map-save button").click()
    expect(page.locator("#library li")).to_contain_text("ground_floor")
    page.get_by_label("Use the map ground_floor").click()
    expect(page.locator("#mapping-note")).to_have_text("ground_floor is in use")
    assert mapping.asked == [
        ("map_save", MapSave(name="ground_floor")),
        ("map_load", MapLoad(map="ground_floor")),
    ]


def test_a_refusal_is_written_where_it_was_asked(page: Page, mapping: MappingShow) -> None:
    mapping.refusal = "the map 'x' was not saved: No space left on device"
    page.locator("#map-name").fill("x")
    page.locator("#map-save button").click()
    expect(page.locator("#mapping-note")).to_have_text(mapping.refusal)
    expect(page.locator("#mapping-note")).to_have_class("reason is-fault")


def test_stopping_gives_the_pose_back(page: Page, mapping: MappingShow) -> None:
    eventually(lambda: seen(page) > 0, 10.0, "a map")
    page.locator("[data-map=toggle]").click()
    expect(page.locator("[data-map=toggle]")).to_have_text("Start mapping")
    assert mapping.asked == [("map_stop", Nothing())]
    expect(page.locator("[data-action=set_pose]")).to_be_enabled()


def test_on_a_phone_mapping_is_in_the_sheet(
    open_page: OpenPage, mapping: MappingShow, picture: Picture
) -> None:
    page = open_page(viewport=PHONE)
    mapping.mode = "mapping"
    expect(page.locator("[data-chip=state]")).to_have_text("Mapping")
    page.locator("#grab").click()
    page.wait_for_timeout(500)
    page.locator("[data-map=toggle]").scroll_into_view_if_needed()
    expect(page.locator("[data-map=toggle]")).to_be_visible()
    picture(page, "mapping-phone")


@pytest.mark.parametrize(("rows", "cols"), [(70, 131), (30, 30), (129, 64)])
def test_a_patched_map_looks_like_the_whole_one(modules: Page, rows: int, cols: int) -> None:
    told = modules.evaluate(PATCHING % (rows, cols))
    assert told != "refused"
    *levels, refused = told
    assert all(all(level) for level in levels)
    assert refused == [False, False]
