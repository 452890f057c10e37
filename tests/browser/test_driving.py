"""A formation driven from the page: keys, a click on the ground, and what is shown of it."""

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

from runtime.precompile import ensure_compiled
from tests.browser.browser_run import BrowserRun
from tests.browser.driven import Driven

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.processes]


@pytest.fixture(scope="module")
def driven(browser: "Browser") -> Iterator[tuple[BrowserRun, Driven]]:
    ensure_compiled(print)
    with BrowserRun("drive-me", 4) as run:
        page = Driven(browser, run.url)
        yield run, page
        page.page.close()


def has_the_wheel(page: Driven) -> None:
    """Wait until the page listens to its keys."""
    page.wait_text("W A S D or arrow keys on page")
    page.page.wait_for_function("() => Boolean(window.__echelonWheel)", timeout=20_000, polling=100)


def test_keys_drive_while_they_are_held_and_only_where_the_wheel_is(
    driven: tuple[BrowserRun, Driven], browser: "Browser"
) -> None:
    run, page = driven
    page.wait_text("Nobody has the wheel")
    page.page.keyboard.press("w")
    page.page.wait_for_timeout(500)
    assert run.state().driving.orders == 0
    page.press("Take the wheel")
    has_the_wheel(page)
    page.page.keyboard.down("w")
    page.page.keyboard.down("ArrowLeft")
    page.until(lambda: (d := run.state().driving).v > 0.0 and d.omega > 0.0, "order of two keys")
    page.page.wait_for_timeout(1500)  # longer than one order counts: it is said again and again
    assert run.state().driving.v > 0.0
    assert run.state().status == "running"  # neither S nor D nor P reached the page's own shortcuts
    page.page.keyboard.up("w")
    page.page.keyboard.up("ArrowLeft")
    page.until(lambda: (d := run.state().driving).v == d.omega == 0.0, "stop when the keys are released")
    other = Driven(browser, run.url)
    orders = run.state().driving.orders
    other.page.keyboard.down("w")
    other.page.wait_for_timeout(700)
    other.page.keyboard.up("w")
    assert run.state().driving.orders == orders
    other.page.close()


def test_a_page_that_is_closed_while_a_key_is_held_stops_the_formation(
    driven: tuple[BrowserRun, Driven], browser: "Browser"
) -> None:
    run, page = driven
    other = Driven(browser, run.url)
    button = other.page.get_by_role("button", name=re.compile("Take the wheel|has the wheel"))
    button.evaluate("element => element.click()")  # from the other page, if that has it
    has_the_wheel(other)
    other.page.keyboard.down("s")
    other.until(lambda: run.state().driving.v < 0.0, "order")
    other.page.close()
    page.until(lambda: run.state().driving.v == 0.0, "stop")
    page.wait_text("Nobody has the wheel")


def test_a_click_on_the_ground_drives_there(driven: tuple[BrowserRun, Driven]) -> None:
    run, page = driven
    page.press("Take the wheel")
    has_the_wheel(page)
    page.tick("Click on the ground: go there", True)
    box = page.page.locator("canvas").first.bounding_box()
    assert box is not None
    before = run.state().driving.orders
    page.page.wait_for_timeout(800)  # until the panel has asked for clicks
    page.page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.3 * box["height"])
    page.until(lambda: run.state().driving.orders > before, "way to the point")
    page.until(lambda: run.state().driving.goal is None, "arrival", 40.0)
    preview = page.prop("/preview", "points").reshape(-1, 2, 3)
    assert np.abs(preview[:, :, :2].mean(axis=(0, 1)) - run.state().centre[:2]).max() < 0.1
    page.press("Stop")


def test_the_drivers_link_is_a_target_of_faults_and_the_way_ages(driven: tuple[BrowserRun, Driven]) -> None:
    run, page = driven
    page.click_cell("driver 1")
    page.until(lambda: page.chosen("Target") == "driver → 1", "target")
    page.tick("Cut", True)
    page.until(lambda: "driver->1" in {str(link) for link in run.state().faults}, "fault")
    page.wait_text(r"(?s)Age of the orders, hop by hop.*R1\s+[\d.]+ s")
    page.press("Clear this target")
    page.until(lambda: not run.state().faults, "whole link")


def test_controllers_that_need_the_path_are_left_out_with_the_reason(driven: tuple[BrowserRun, Driven]) -> None:
    _, page = driven
    page.wait_text("Left out: .*virtual_structure.*need the path in every robot")
