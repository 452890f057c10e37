"""What is seen over the scene of a run in which one robot knows the path: one run and one page for all tests."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from network.control import Clear, SetFault
from tests.browser.browser_run import BrowserRun
from tests.browser.driven import Driven

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.processes]
LEAST, LENGTH = 26, 0.55 * 0.12
"""A body is never shorter on the screen [px]; how long it is in this scenario [m]."""
OVERLAY = """() => {
  const box = e => { const r = e.getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; };
  const all = name => [...document.querySelectorAll("#e-overlay " + name)].filter(
    e => getComputedStyle(e).visibility !== "hidden");
  const scales = window.__viserSceneTree.getState()["/bodies"].message.props.batched_scales;
  return {canvas: box(window.__viserMutable.canvas),
    numbers: all(".e-over-number").map(e => [e.textContent, ...box(e)]),
    chips: all(".e-over-chip").map(e => [e.textContent.trim(), ...box(e)]), scale: scales ? scales[0] : 1,
    notices: [...document.querySelectorAll(".mantine-Notification-root")].filter(e => e.offsetParent !== null).length};
}"""


@pytest.fixture(scope="module")
def run() -> Iterator[BrowserRun]:
    with BrowserRun("follow-the-leader", robots=4, alone={2}) as running:
        yield running


@pytest.fixture(scope="module")
def page(browser: "Browser", run: BrowserRun) -> Iterator[Driven]:
    driven = Driven(browser, run.url, width=1280, height=720)
    yield driven
    driven.page.close()


def overlay(page: Driven) -> Any:
    return page.page.evaluate(OVERLAY)


def places(page: Driven) -> np.ndarray[Any, np.dtype[np.float64]]:
    """(n, 2) of the robots in the window, by the page's camera [px]."""
    left, top, _, _ = overlay(page)["canvas"]
    return np.array([page.pixel(place)[0] + [left, top] for place in page.bodies()])


def numbers_fit(page: Driven) -> bool:
    """Whether every robot has its number on it."""
    shown = overlay(page)["numbers"]
    middles = np.array([[x + w / 2, y + h / 2] for _, x, y, w, h in shown])
    return [text for text, *_ in shown] == ["1", "2", "3", "4"] and bool(np.abs(middles - places(page)).max() < 3.0)


def test_at_first_sight_the_formation_fills_a_fair_part_of_the_view_and_nothing_covers_it(page: Driven) -> None:
    page.wait_text(r"Robot 1 knows the path; 2, 3 and 4 learn it hop by hop within \d+ ms", 60.0)
    page.press("Pause")
    page.wait_text("PAUSED")
    page.until(lambda: numbers_fit(page), "numbers on their robots")
    seen = overlay(page)
    assert 0.15 < np.ptp(places(page), axis=0).max() / seen["canvas"][3] < 0.6
    assert seen["notices"] == 0
    assert [text for text, *_ in seen["chips"]] == ["● knows the path"]
    page.press("Start")


def test_far_away_bodies_keep_a_least_size_and_their_numbers(page: Driven) -> None:
    page.press("Pause")
    page.wait_text("PAUSED")
    page.press("Fit")
    page.until(lambda: overlay(page)["scale"] > 1.0, "larger bodies")
    page.until(lambda: numbers_fit(page), "numbers on their robots")
    tips = [page.pixel(page.bodies()[0] + [overlay(page)["scale"] * dx, 0.0, 0.0])[0] for dx in (0.0, LENGTH)]
    assert np.hypot(*(tips[1] - tips[0])) == pytest.approx(LEAST, abs=3.0)
    page.press("Follow")
    page.until(lambda: overlay(page)["scale"] == pytest.approx(1.0), "bodies of their own size")
    page.press("Start")


def test_a_cut_is_seen_in_the_line_in_chips_and_where_the_way_ended(page: Driven, run: BrowserRun) -> None:
    run.ask(SetFault(link="1->2", changes={"cut": True}))
    page.wait_text(r"Link 1 → 2 cut \d\.\d s ago", 30.0)
    page.wait_text("what 2 was told ended here", 30.0)
    page.wait_text(r"\d\.\d s since told the way")
    page.press("Pause")
    page.wait_text("PAUSED")
    page.until(lambda: numbers_fit(page), "numbers on their robots")
    chips = [box for _, *box in overlay(page)["chips"]]
    for i, (x, y, w, h) in enumerate(chips):
        for place in places(page):
            assert not (x < place[0] < x + w and y < place[1] < y + h), "a chip lies on a robot"
        for u, v, a, b in chips[:i]:
            assert x + w <= u or u + a <= x or y + h <= v or v + b <= y, "chips overlap"
    run.ask(Clear())
    page.press("Start")
    page.wait_text("2, 3 and 4 learn it", 60.0)
    assert page.errors == []


def drag(page: Driven, share: float) -> None:
    """Drag the handle of the time line to a share of what is kept, as a user does."""
    box = page.page.locator(".e-track").bounding_box()
    assert box is not None
    mouse = page.page.mouse
    mouse.move(box["x"] + box["width"] - 2, box["y"] + 50)
    mouse.down()
    mouse.move(box["x"] + 0.5 * (1 + share) * box["width"], box["y"] + 50)
    mouse.move(box["x"] + share * box["width"], box["y"] + 50)
    mouse.up()


def stands_still(page: Driven) -> bool:
    """Whether the robots that are drawn do not move."""
    before = page.bodies()
    page.page.wait_for_timeout(700)
    return np.array_equal(page.bodies(), before)


def test_a_drag_shows_the_moment_while_the_run_goes_on_and_live_returns(page: Driven, run: BrowserRun) -> None:
    page.wait_text("● LIVE")
    cut_at = run.state().stamp
    run.ask(SetFault(link="2->3", changes={"cut": True}))
    page.wait_text(r"✕ 2→3 cut", 20.0)
    run.ask(Clear())
    page.page.wait_for_timeout(1500)
    drag(page, 0.5 * cut_at / run.state().stamp)  # before the cut, also if all of this took long
    page.wait_text("REWOUND")
    page.wait_text(r"Looking at t = \d+\.\d s .* the run goes on at \d+\.\d s")
    page.until(lambda: stands_still(page), "a moment that stands still")
    before, stamp = page.bodies(), run.state().stamp
    page.page.wait_for_timeout(1000)
    np.testing.assert_array_equal(page.bodies(), before)
    assert run.state().stamp > stamp
    assert np.abs(before[:, :2] - run.state().poses[:, :2]).max() > 0.02
    box = page.page.locator(".e-frame").evaluate("e => getComputedStyle(e).borderTopWidth")
    assert box == "2px"
    page.page.locator(".e-handle").press("ArrowRight")
    page.until(lambda: bool(np.abs(page.bodies() - before).max() > 1e-3), "a second later")
    page.press("Next event")
    page.wait_text(r"0\.\d s after \d→\d cut", 20.0)
    page.page.locator(".e-live").click()
    page.wait_text("● LIVE")
    page.until(lambda: "REWOUND" not in page.text(), "the run as it is")
    page.until(lambda: bool(np.abs(page.bodies()[:, :2] - run.state().poses[:, :2]).max() < 0.05), "robots of now")


def test_a_reset_begins_a_new_episode_and_the_old_one_can_be_looked_at(page: Driven, run: BrowserRun) -> None:
    ended = run.state().stamp
    page.press("Reset")
    page.until(lambda: run.state().stamp < ended - 5.0, "another episode")
    page.page.wait_for_timeout(2500)
    drag(page, 0.3)
    page.wait_text("an earlier episode")
    page.page.locator(".e-handle").press("Escape")
    page.wait_text("● LIVE")
    assert page.errors == []
