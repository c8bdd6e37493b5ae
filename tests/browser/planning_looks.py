"""What tests of the planner's layers see of the page."""

from playwright.sync_api import Locator, Page

GOAL = (246, 90, 194)
GOAL_LIGHT = (109, 0, 163)
WHITE = (255, 255, 255)
GREY = (138, 151, 165)
SOLID = 250
"""Alpha of what is drawn at full opacity."""

PLACED = """([x, y]) => Promise.all([import('/static/view.js')]).then(([m]) => {
  const { width, height } = document.querySelector('#live').getBoundingClientRect();
  const isPhone = matchMedia('(width < 760px)').matches;
  const view = new m.View();
  view.size = { width, height };
  const chips = document.querySelector('#layers').offsetHeight;
  view.inset = m.frameFor(isPhone ? 148 : 0, !document.querySelector('#notice').hidden, chips);
  view.bounds = { x0: 0, y0: 0, x1: 26, y1: 13 };
  view.fit(false);
  const at = view.toScreen({ x, y });
  return [at.x, at.y];
})"""

COUNTED = """([colour, box, least]) => {
  const canvas = document.querySelector('#live');
  const ratio = canvas.width / canvas.getBoundingClientRect().width;
  const copy = new OffscreenCanvas(canvas.width, canvas.height);
  const context = copy.getContext('2d', { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const whole = [0, 0, canvas.width, canvas.height];
  const part = box ? box.map((value) => Math.round(value * ratio)) : whole;
  const { data } = context.getImageData(...part);
  let n = 0;
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] < least) continue;
    if (colour.every((value, c) => Math.abs(data[i + c] - value) < 24)) n++;
  }
  return n;
}"""

Colour = tuple[int, int, int]


def next_look(page: Page) -> Locator:
    """Return the panel's sentence on what the planner does."""
    return page.locator("#next p")


def on_map(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return where a point of the map is on its canvas, the whole map in view."""
    left, top = page.evaluate(PLACED, [x, y])
    return float(left), float(top)


def on_page(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return where a point of the map is on the page."""
    box = page.locator("#live").bounding_box()
    assert box is not None
    left, top = on_map(page, x, y)
    return box["x"] + left, box["y"] + top


def seen(
    page: Page,
    colour: Colour,
    around: tuple[float, float] | None = None,
    half: float = 12.0,
    least: int = 120,
) -> int:
    """Return how many pixels of the live canvas are of a colour and of at least this alpha.

    Of the whole canvas, or of the square of 2 * `half` px around a point of the map.
    """
    box = None
    if around is not None:
        x, y = on_map(page, *around)
        box = [x - half, y - half, 2 * half, 2 * half]
    count = page.evaluate(COUNTED, [colour, box, least])
    assert isinstance(count, int)
    return count
