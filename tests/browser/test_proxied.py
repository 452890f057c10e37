"""A page behind a reverse proxy with a path prefix, and its help: one page without a run for all tests."""

import threading
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import pytest

from dashboard.keys import groups
from dashboard.page import Page
from dashboard.serving import server
from dashboard.serving.access import Guard
from dashboard.theme.palette import DARK, LIGHT
from dashboard.theme.signs import SIGNS
from network import topics
from network.codec import encode
from tests.browser.driven import Driven
from tests.builders import state
from tests.dashboard.fakes import bus, receive
from tests.dashboard.serving.proxy import proxied

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.browser
SECRET = "a-token_of-some-length"
CONTRAST = """() => {
  const light = c => { const [r, g, b] = c.match(/[0-9.]+/g).map(n => { n /= 255;
    return n <= 0.03928 ? n / 12.92 : ((n + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  const style = getComputedStyle(document.querySelector("dialog.e-help"));
  const [a, b] = [light(style.color), light(style.backgroundColor)].sort((x, y) => y - x);
  return (a + 0.05) / (b + 0.05);
}"""


NAMELESS = """() => {
  const seen = e => { const r = e.getBoundingClientRect(); return r.width > 0 && r.height > 0 && e.tabIndex >= 0; };
  const labels = e => [...(e.labels || [])].map(label => label.textContent).join("");
  const name = e => e.getAttribute("aria-label") || labels(e) || e.textContent;
  return [...document.querySelectorAll("button, input, [tabindex]")].filter(seen).filter(e => !name(e).trim())
    .map(e => e.outerHTML.slice(0, 120));
}"""
LAYOUT = """() => {
  const box = e => { const r = e.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]; };
  const sheet = document.querySelector('div[style*="max-height: 60%"]');
  return {canvas: box(window.__viserMutable.canvas), sheet: sheet && box(sheet), wide: document.body.scrollWidth,
    strip: box(document.querySelector(".e-strip")), status: box(document.querySelector(".e-status"))};
}"""


class _Lifetime:
    over = False


@pytest.fixture(scope="module")
def shown() -> Iterator[tuple[Page, str]]:
    """A page of three robots, and its address below a proxy's prefix."""
    served, lifetime = server.serve(Guard("127.0.0.1", SECRET), 0, "x"), _Lifetime()
    page = Page(served, bus())
    thread = threading.Thread(target=page.serve, args=(lifetime,), daemon=True)
    thread.start()
    assert receive(page._feed.source, topics.state("x"), encode(state()))
    with proxied(served.get_port(), "/echelon") as port:
        yield page, f"http://127.0.0.1:{port}/echelon"
    lifetime.over = True
    thread.join(10.0)
    server.stop(served)


@pytest.fixture(scope="module")
def driven(browser: "Browser", shown: tuple[Page, str]) -> Iterator[Driven]:
    found = Driven(browser, shown[1], token=SECRET, width=1024, height=720)
    yield found
    found.page.close()


def test_a_page_behind_a_path_prefix_shows_robots_and_asks_nothing_outside_of_it(
    driven: Driven, shown: tuple[Page, str]
) -> None:
    driven.wait_text("FORMATION")
    assert driven.page.url.startswith(f"{shown[1]}/index.html?fixedDpr=1")
    assert SECRET not in driven.page.url
    outside = [url for url in driven.requests if not url.startswith((shown[1] + "/", "data:", "blob:"))]
    assert outside == []
    assert driven.errors == []


def test_the_help_has_every_key_and_sign_and_is_readable_in_both_themes(
    driven: Driven, shown: tuple[Page, str]
) -> None:
    dialog: Any = driven.page.locator("dialog.e-help")
    for opened_by in ("key", "button"):
        if opened_by == "key":
            driven.page.keyboard.press("?")
        else:
            driven.page.get_by_role("button", name="Help", exact=True).click()
        driven.until(dialog.is_visible, f"help by its {opened_by}")
        text = " ".join(dialog.inner_text().split())
        for group in groups():
            assert group.where in text
            assert all(what in text and all(key in text for key in keys) for keys, what in group.rows)
        assert all(sign.form in text and sign.meaning in text for sign in SIGNS.values())
        for palette in (LIGHT, DARK):
            shown[0]._set_palette(palette)
            driven.until(lambda theme="dark" if palette.dark else "light": driven.theme == theme, "theme")  # type: ignore[misc]
            assert driven.page.evaluate(CONTRAST) > 7.0
        driven.page.keyboard.press("Escape" if opened_by == "key" else "?")
        driven.until(lambda: not dialog.is_visible(), "closed help")
    assert driven.errors == []


def test_the_keyboard_alone_reaches_every_control_by_its_name(driven: Driven, shown: tuple[Page, str]) -> None:
    driven.until(lambda: driven.page.evaluate(NAMELESS) == [], "names of all controls")
    active = "(document.activeElement.getAttribute('aria-label') || document.activeElement.innerText).trim()"
    reached = Counter[str]()
    driven.page.evaluate("document.activeElement.blur()")
    for _ in range(120):
        driven.page.keyboard.press("Tab")
        reached[driven.page.evaluate(active)] += 1
    for name in ("Pause", "Draw a path", "Live", "Ledger", "Aim faults at the link from robot 2", "Time", "Help"):
        assert name in reached, sorted(reached)
    cell = driven.page.locator('[data-cell="link 1"]')
    cell.focus()
    driven.page.keyboard.press("ArrowDown")
    driven.page.keyboard.press("ArrowDown")
    driven.page.keyboard.press("Enter")
    driven.until(lambda: driven.chosen("Target") == "2 → 3", "target")
    driven.page.wait_for_timeout(1000)  # the table has been replaced since
    assert driven.page.evaluate("document.activeElement.dataset.cell") == "link 2"
    driven.page.locator("[data-title]", has_text="Draw a path").focus()
    driven.page.keyboard.press("Enter")
    driven.until(lambda: driven.page.get_by_role("button", name="Undo", exact=True).is_visible(), "open folder")


@pytest.mark.parametrize(("width", "height"), [(1024, 720), (800, 600), (390, 844)])
def test_a_narrow_window_shows_scene_and_state_side_by_side_or_one_below_the_other(
    driven: Driven, width: int, height: int
) -> None:
    driven.page.set_viewport_size({"width": width, "height": height})

    def fits() -> bool:
        seen = driven.page.evaluate(LAYOUT)
        left, top, right, bottom = seen["canvas"]
        inside = all(
            left - 1 <= box[0] and box[2] <= right + 1 and top - 1 <= box[1] and box[3] <= bottom + 1
            for box in (seen["strip"], seen["status"])
        )
        below = width > 576 or (seen["sheet"] and seen["sheet"][1] >= bottom - 1 and seen["sheet"][2] >= width - 1)
        folded = not 576 < width < 1024 or right > width - 60
        return inside and below and folded and right - left > 380 and bottom - top > 350 and seen["wide"] <= width

    driven.until(fits, f"scene and state in {width} x {height}")
    for text in ("FORMATION", "BELIEF", "t = "):
        assert text in driven.text()
    assert driven.errors == []
