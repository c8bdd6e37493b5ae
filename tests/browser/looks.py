"""What tests see of the page."""

from playwright.sync_api import Page, expect

PHONE = {"width": 390, "height": 844}


def state_chip(page: Page) -> str:
    """Return the word of THE state chip."""
    return page.locator("[data-chip=state]").inner_text().strip()


def wait_for_places(page: Page) -> None:
    """Wait until the first picture stands."""
    expect(page.locator("[data-chip=state]")).to_have_text("Ambiguous · 3 places")
    expect(page.locator(".place")).to_have_count(3)
    expect(page.locator("#certainty")).to_have_text("58\u202f%")


def wait_for_commands(page: Page) -> None:
    """Wait until the robot can be commanded."""
    expect(page.locator("[data-action=wander]")).to_be_enabled()


def painted(page: Page, canvas: str) -> int:
    """Return how many pixels of a canvas are not transparent."""
    count = page.evaluate(
        """(id) => {
          const canvas = document.querySelector(id);
          const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
          let n = 0;
          for (let i = 3; i < data.length; i += 4) if (data[i] > 0) n++;
          return n;
        }""",
        canvas,
    )
    assert isinstance(count, int)
    return count
