"""A page behind a reverse proxy with a path prefix, and its help: one page without a run for all tests."""

import threading
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
