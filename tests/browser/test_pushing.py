"""Robots pushed from the page: buttons, a drag with the mouse, shape and spacing."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

from formation.metrics import nearest
from network.interventions import Move, Push
from network.messages import State
from runtime.precompile import ensure_compiled
from tests.browser.browser_run import BrowserRun
from tests.browser.driven import Driven

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.processes]


@pytest.fixture(scope="module")
def pushed(browser: "Browser") -> Iterator[tuple[BrowserRun, Driven]]:
    ensure_compiled(print)
    with BrowserRun("drive-me", 4, settings=["bodies=ideal"]) as run:
        page = Driven(browser, run.url)
        yield run, page
        page.page.close()


def test_buttons_push_the_chosen_robot_for_a_time_or_until_it_is_released(pushed: tuple[BrowserRun, Driven]) -> None:
    run, page = pushed
    page.choose("Robot", "Robot 3")
    page.press("Stuck")
    page.until(lambda: [(one.robot, one.text) for one in run.state().pushes] == [(3, "stuck")], "push")
    page.wait_text(r"robot 3: stuck,\s+\d+ s left")
    page.tick("Push for 10 s", False)
    page.press("Blind")
    page.wait_text(r"robot 3: not localised\s+until released")
    page.press("Release")
    page.until(lambda: not run.state().pushes, "release")
    page.wait_text("No robot is pushed")
    page.show("Log")
    page.wait_text("robot 3: no longer not localised")
    run.ask(Push(robot=1, kind="slow", seconds=1.0))  # by somebody else: shown here, too
    page.wait_text("robot 1: slowed to 50%")


def test_a_robot_is_dragged_aside_with_the_mouse(pushed: tuple[BrowserRun, Driven]) -> None:
    run, page = pushed
    page.until(lambda: not run.state().pushes, "quiet")
    page.press("Fit")
    page.page.wait_for_timeout(500)
    before = run.state().interventions
    box = page.page.locator("canvas").first.bounding_box()
    assert box is not None
    places = page.bodies()
    ratio = page.page.evaluate("window.__viserMutable.canvas.width") / box["width"]
    (x, y), _ = page.pixel(places[3])  # notices cover others
    (far, _), _ = page.pixel(places[3] + [0.1, 0.0, 0.0])
    shown = abs(far - x) / ratio / 0.1  # px per metre
    mouse = page.page.mouse
    mouse.move(box["x"] + x / ratio, box["y"] + y / ratio)
    mouse.down()
    for share in (0.3, 0.6, 1.0):
        mouse.move(box["x"] + x / ratio + share * 0.05 * shown, box["y"] + y / ratio)
        page.page.wait_for_timeout(250)
    mouse.up()
    page.until(lambda: run.state().interventions > before, "move")
    page.until(
        lambda: np.hypot(*(run.state().poses[1] - run.state().slots[1])[:2]) > 0.02, "robot beside its slot", 5.0
    )
    page.wait_text(r"robot 4: pushed at|No robot is pushed")


def test_shape_and_spacing_change_while_it_runs_and_a_reset_returns(pushed: tuple[BrowserRun, Driven]) -> None:
    run, page = pushed
    apart = nearest(run.state().slots[:, :2])[2]
    page.choose("Shape", "line")
    page.until(lambda: _in_line(run.state().slots), "line", 90.0)
    page.fill("Spacing mm", "140")
    page.until(lambda: abs(nearest(run.state().slots[:, :2])[2] - 0.14) < 1e-3, "spacing", 90.0)
    assert page.chosen("Shape") == "choose…"
    page.wait_text("the shape becomes line, spacing 0.1 m")
    page.press("Reset")
    page.until(lambda: abs(nearest(run.state().slots[:, :2])[2] - apart) < 1e-3, "first shape")
    page.until(lambda: page.number("Spacing mm") == f"{1000 * apart:.0f}", "spacing on the page")


def test_the_ledger_names_the_push_and_a_pressed_row_goes_to_its_moment(pushed: tuple[BrowserRun, Driven]) -> None:
    run, page = pushed
    page.until(lambda: run.state().stamp > 1.0, "episode")
    seen = run.state().excursion_count
    run.ask(Move(robot=2, dx=0.0, dy=-0.04))
    page.until(lambda: run.state().excursion_count > seen, "excursion")
    row = run.state().excursions[-1]
    assert row.cause.startswith("robot 2: pushed at (0, -0.08) m/s")
    page.show("Ledger")
    page.wait_text(r"Excursions \d+ over 2 mm")
    page.wait_text(r"robot 2: pushed at \(0, -0.08\) m/s")
    page.until(lambda: bool(run.state().excursions[-1].until), "end of the excursion", 40.0)
    page.click_cell(f"excursion {row.number % 32}")
    page.wait_text("How it came")
    page.wait_text("the run goes on at")
    page.show("Live")


def _off(state: State) -> float:
    """Of robot 4 from its slot [m]."""
    return float(np.hypot(*(state.poses[3] - state.slots[3])[:2]))


def _in_line(slots: np.ndarray) -> bool:
    spread = np.linalg.svd(slots[:, :2] - slots[:, :2].mean(axis=0), compute_uv=False)
    return bool(spread[1] < 1e-3)
