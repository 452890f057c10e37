"""A formation in a user's hands: driven, pushed, drawn a path for. One run and two pages for all tests."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from formation.metrics import nearest
from formation.paths.waypoints import Waypoints
from formation.scenario.files import load
from network.interventions import Move, Push
from runtime.precompile import ensure_compiled
from tests.browser.browser_run import BrowserRun
from tests.browser.driven import Driven

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.processes]


@pytest.fixture(scope="module")
def driven(browser: "Browser") -> Iterator[tuple[BrowserRun, Driven]]:
    ensure_compiled(print)
    with BrowserRun("drive-me", 4, alone={2}, settings=["bodies=ideal"]) as run:
        page = Driven(browser, run.url)
        yield run, page
        page.page.close()


@pytest.fixture(scope="module")
def other(driven: tuple[BrowserRun, Driven], browser: "Browser") -> Driven:
    """Another page, in a small window, which draws in less time; a test closes it."""
    with driven[1].at_rest():
        return Driven(browser, driven[0].url, width=640, height=420)


def has_the_wheel(page: Driven) -> None:
    """Wait until the page listens to its keys."""
    page.wait_text("W A S D or arrow keys on page")
    page.page.wait_for_function("() => Boolean(window.__echelonWheel)", timeout=20_000, polling=100)


def test_keys_drive_while_they_are_held_and_only_where_the_wheel_is(
    driven: tuple[BrowserRun, Driven], other: Driven
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
    page.until(lambda: run.state().driving.v > 0.0, "order that is said again")  # a slow frame may let one end
    assert run.state().status == "running"  # neither S nor D nor P reached the page's own shortcuts
    page.page.keyboard.up("w")
    page.page.keyboard.up("ArrowLeft")
    page.until(lambda: (d := run.state().driving).v == d.omega == 0.0, "stop when the keys are released")
    pads = "navigator.getGamepads = () => [null, {connected: true, id: 'A pad', axes: [0.08, -1], buttons: []}]"
    page.page.evaluate(pads)
    page.until(lambda: (d := run.state().driving).v > 0.0 and d.omega == 0.0, "order of a gamepad's stick")
    page.wait_text("gamepad: A pad")
    page.page.evaluate("navigator.getGamepads = () => []")
    page.until(lambda: run.state().driving.v == 0.0, "stop when the stick is let go")
    orders = run.state().driving.orders
    other.page.keyboard.down("w")
    other.page.wait_for_timeout(700)
    other.page.keyboard.up("w")
    assert run.state().driving.orders == orders


def test_a_page_that_is_closed_while_a_key_is_held_stops_the_formation(
    driven: tuple[BrowserRun, Driven], other: Driven
) -> None:
    run, page = driven
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

    def off() -> float:
        """Of the preview's middle from the formation's centre; the page may be some frames behind [m]."""
        preview = page.prop("/preview", "points").reshape(-1, 2, 3)
        return float(np.abs(preview[:, :, :2].mean(axis=(0, 1)) - run.state().centre[:2]).max())

    page.until(lambda: off() < 0.1, "preview where the formation stands")
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


def test_buttons_push_the_chosen_robot_for_a_time_or_until_it_is_released(driven: tuple[BrowserRun, Driven]) -> None:
    run, page = driven
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


def test_a_robot_is_dragged_aside_with_the_mouse(driven: tuple[BrowserRun, Driven]) -> None:
    run, page = driven
    page.until(lambda: not run.state().pushes, "quiet")
    page.press("Fit")
    page.page.wait_for_timeout(500)
    before, seen = run.state().interventions, run.state().excursion_count
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
    page.until(lambda: run.state().excursion_count > seen, "robot beside its slot")
    page.wait_text(r"robot 4: pushed at|No robot is pushed")


def test_shape_and_spacing_change_while_it_runs_and_a_reset_returns(driven: tuple[BrowserRun, Driven]) -> None:
    run, page = driven
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


def test_the_ledger_names_the_push_and_a_pressed_row_goes_to_its_moment(driven: tuple[BrowserRun, Driven]) -> None:
    run, page = driven
    page.until(lambda: run.state().stamp > 1.0, "episode")
    seen = run.state().excursion_count
    run.ask(Move(robot=2, dx=0.0, dy=-0.04))
    page.until(lambda: run.state().excursion_count > seen, "excursion")
    row = run.state().excursions[-1]
    assert row.cause.startswith("robot 2: pushed at (0, -0.08) m/s")
    page.show("Ledger")
    page.wait_text(r"Excursions \d+ over 2\.0 mm")
    page.wait_text(r"robot 2: pushed at \(0, -0.08\) m/s")
    page.until(lambda: bool(run.state().excursions[-1].until), "end of the excursion", 40.0)
    page.click_cell(f"excursion {row.number % 32}")
    page.wait_text("How it came")
    page.wait_text("the run goes on at")
    page.show("Live")


def test_a_path_is_drawn_on_the_ground_saved_as_a_file_that_loads_and_run(
    driven: tuple[BrowserRun, Driven], tmp_path: Path
) -> None:
    run, page = driven
    page.page.locator("[data-title]", has_text="Draw a path").click()
    page.press("Draw")
    page.wait_text(r"Page \d+ draws")
    page.page.wait_for_timeout(800)  # until pages are asked for clicks
    box = page.page.locator("canvas").first.bounding_box()
    assert box is not None
    for points, (x, y) in enumerate(((0.2, 0.3), (0.7, 0.2), (0.5, 0.6)), 1):
        page.page.mouse.click(box["x"] + x * box["width"], box["y"] + y * box["height"])
        page.wait_text(rf"{points} point")
    orders = run.state().driving.orders
    scenario = load(str(page.take("Save", tmp_path)))
    assert isinstance(scenario.path, Waypoints)
    assert len(scenario.path.points) == 3
    assert run.state().driving.orders == orders, "a click was a point and an order"
    page.press("Run it")
    page.until(lambda: run.state().scenario == scenario.name, "run of the drawing", 40.0)
    page.until(lambda: run.state().stamp > 1.0, "its episode", 40.0)


def _in_line(slots: np.ndarray) -> bool:
    spread = np.linalg.svd(slots[:, :2] - slots[:, :2].mean(axis=0), compute_uv=False)
    return bool(spread[1] < 1e-3)
