"""The dashboard in a browser, on a real run of three robots. One run and one page for all tests of the module."""

import csv
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import imageio.v3 as images
import numpy as np
import pytest

from dashboard.theme import colours
from dashboard.theme.palette import DARK, LIGHT, Palette
from formation.arrays import FloatArray
from formation.faults import Fault
from formation.link_ids import LinkId
from network.control import Compare, SetFault, UseController
from tests.browser.browser_run import ROOT, RUN, BrowserRun
from tests.browser.driven import Driven

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.processes]
SHOWN = """() => ["/ghosts", "/ghost_edges", "/ghost_trails"].map(
  name => window.__viserSceneTree.getState()[name].effectiveVisibility)"""
NEWEST = """() => Object.values(window.__viserTestpoints.uplots).map(
  plot => Object.fromEntries(plot.chart.series.map((line, i) => [line.label, plot.chart.data[i].at(-1)])))"""


@pytest.fixture(scope="module")
def run() -> Iterator[BrowserRun]:
    with BrowserRun("triangle-circle", robots=3, alone={2}) as running:
        yield running


@pytest.fixture(scope="module")
def page(browser: "Browser", run: BrowserRun) -> Iterator[Driven]:
    driven = Driven(browser, run.url)
    yield driven
    driven.page.close()


@pytest.fixture(autouse=True)
def undisturbed(page: Driven) -> Iterator[None]:
    """Every test begins and ends with a running, healthy run."""
    yield
    page.press("Clear")
    if page.page.get_by_role("button", name="Start", exact=True).count():
        page.press("Start")
    page.wait_text("No faults", 30.0)
    page.wait_text("RUNNING", 30.0)


def test_the_page_comes_up_without_errors_or_requests_elsewhere(page: Driven) -> None:
    page.wait_text("RUNNING")
    page.wait_text(r"t = \d")
    own = urlsplit(page.url).netloc
    assert page.errors == []
    elsewhere = [
        url for url in page.requests if urlsplit(url).scheme not in ("blob", "data") and urlsplit(url).netloc != own
    ]
    assert elsewhere == []


def test_robots_are_where_the_world_has_them(page: Driven, run: BrowserRun) -> None:
    page.press("Follow")
    page.press("Pause")
    page.wait_text("PAUSED")
    poses = run.state().poses
    page.until(lambda: np.allclose(page.bodies()[:, :2], poses[:, :2], atol=1e-5), "robots where the world has them")
    page.until(lambda: painted(page, poses, DARK), "robots in their colours")
    page.press("Fit")


def painted(page: Driven, poses: FloatArray, palette: Palette) -> bool:
    """Whether the picture has every robot's colour at its nose."""
    for robot, (x, y, heading) in enumerate(poses, start=1):
        nose = np.array([x + 0.022 * np.cos(heading), y + 0.022 * np.sin(heading), 0.006])
        _, colour = page.pixel(nose)
        if np.abs(colour - 255.0 * colours.rgb(colours.identity(robot, 3, palette))).max() > 60.0:
            return False
    return True


def test_a_light_page_is_light_all_over(page: Driven, run: BrowserRun) -> None:
    page.press("Follow")
    page.press("Pause")
    page.wait_text("PAUSED")
    poses = run.state().poses
    page.tick("Light", True)
    page.until(lambda: page.theme == "light", "light panels")
    page.until(lambda: painted(page, poses, LIGHT), "robots in the light look's colours")
    page.until(lambda: page.plots_are_whole, "plots over all the time")
    page.tick("Light", False)
    page.until(lambda: page.theme == "dark" and painted(page, poses, DARK), "the dark look again")
    page.press("Fit")


def test_a_cell_of_the_link_matrix_becomes_the_target_of_faults(page: Driven, run: BrowserRun) -> None:
    page.click_cell("link 2")
    page.until(lambda: page.chosen("Target") == "2 → 3", "target 2->3")
    page.click_cell("both 1")
    page.until(lambda: page.chosen("Target") == "Robot 1: from and to", "target robot 1")
    page.tick("Cut", True)
    page.until(
        lambda: run.state().faults == {LinkId(1, 2): Fault(cut=True), LinkId(3, 1): Fault(cut=True)},
        "both links cut",
    )
    page.click_cell("all 0")
    page.until(lambda: page.chosen("Target") == "All links", "target all")


def test_two_pages_agree(browser: "Browser", page: Driven, run: BrowserRun) -> None:
    with page.at_rest():
        other = Driven(browser, run.url, width=640, height=420)
    page.click_cell("link 1")
    page.tick("Cut", True)
    other.wait_text(r"1→2\s+cut")
    other.until(lambda: other.ticked("Cut") and other.chosen("Target") == "1 → 2", "the cut on the other page")
    other.press("Pause")
    page.wait_text("PAUSED")
    assert page.page.get_by_role("button", name="Start", exact=True).count() == 1
    stamp = run.state().stamp
    for each in (page, other):
        each.wait_text(re.escape(f"t = {stamp:.1f} s"))
    assert other.errors == []
    other.page.close()


def test_where_nobody_can_kill_an_agent_the_page_shows_it(page: Driven, run: BrowserRun) -> None:
    page.show("Robots")
    page.click_cell("kill 1")
    page.wait_text(r"Kill agent 1\?")
    page.press("Kill 1")
    page.wait_text("nobody here can end or start agents")
    assert run.state().dismissed == []
    page.show("Live")


def test_exported_files_are_named_and_whole(browser: "Browser", page: Driven, run: BrowserRun, tmp_path: Path) -> None:
    run.ask(SetFault(link="1->2", changes={"latency": 0.05}))
    name = rf"echelon_{RUN}_triangle-circle_[a-z_]+_t\d+\.\ds\.(html|csv|png)"
    replay, plots, picture = (page.take(what, tmp_path) for what in ("Replay", "CSV", "Picture"))
    for path in (replay, plots, picture):
        assert re.fullmatch(name, path.name), path.name
    rows = list(csv.DictReader(plots.read_text().splitlines()))
    assert float(rows[-1]["t_s"]) > float(rows[0]["t_s"])
    assert any("1->2: latency" in row["events"] for row in rows)
    image = images.imread(picture)
    view = page.page.locator("canvas[data-engine]").bounding_box()
    assert view is not None
    assert abs(image.shape[1] - view["width"]) <= 2
    assert len(np.unique(image.reshape(-1, image.shape[2]), axis=0)) > 20, "not one colour"
    _plays_alone(browser, replay)


def _plays_alone(browser: "Browser", replay: Path) -> None:
    """From the file alone, asking nothing of any network, and it moves."""
    alone, asked, errors = browser.new_page(), list[str](), list[str]()
    alone.on("request", lambda request: asked.append(request.url))
    alone.on("pageerror", lambda error: errors.append(str(error)))
    alone.on("console", lambda message: errors.append(message.text))
    alone.goto(replay.as_uri())
    before = alone.evaluate("document.getElementById('scene').toDataURL()")
    alone.select_option("#speed", "20")
    alone.click("#play")
    end = time.monotonic() + 30.0
    while alone.evaluate("playing || now === 0"):  # its own policy forbids what wait_for_function does
        assert time.monotonic() < end, "it does not play to its end"
        alone.wait_for_timeout(60)
    assert alone.evaluate("document.getElementById('scene').toDataURL()") != before
    assert "triangle-circle" in alone.locator("#about").inner_text()
    assert (asked, errors) == ([replay.as_uri()], [])
    alone.close()


def test_pause_stops_motion_and_start_goes_on(page: Driven, run: BrowserRun) -> None:
    page.press("Pause")
    page.wait_text("PAUSED")
    poses = run.state().poses[:, :2]
    page.until(lambda: np.allclose(page.bodies()[:, :2], poses, rtol=0.0, atol=2e-7), "robots where they stopped")
    before = page.bodies()
    page.page.wait_for_timeout(400)
    np.testing.assert_array_equal(page.bodies(), before)
    page.press("Start")
    page.until(lambda: bool(np.abs(page.bodies() - before).max() > 1e-3), "motion")


def test_a_latency_on_one_link_ages_that_link_and_no_other(page: Driven) -> None:
    page.choose("Target", "1 → 2")
    page.fill("Latency ms", "400")
    page.until(lambda: (page.age(1, 2) or 0.0) >= 0.39, "age of 1->2")
    assert (page.age(2, 3) or 0.0) < 0.2
    assert (page.age(3, 1) or 0.0) < 0.2
    page.choose("Target", "2 → 3")
    page.until(lambda: page.number("Latency ms") == "0", "latency 0 on 2->3")
    page.choose("Target", "1 → 2")
    page.until(lambda: page.number("Latency ms") == "400", "latency 400 on 1->2")


def test_a_cut_link_is_lost_until_it_is_healed(page: Driven) -> None:
    page.choose("Target", "3 → 1")
    page.tick("Cut", True)
    page.wait_text(r"CUT")
    page.until(lambda: (page.age(3, 1) or 0.0) > 0.5, "age of 3->1")
    page.tick("Cut", False)
    page.until(lambda: (page.age(3, 1) or 1.0) < 0.2, "fresh plans over 3->1")
    assert "CUT" not in page.text()


def test_a_fault_for_ten_seconds_ends_by_itself(page: Driven) -> None:
    page.choose("Target", "1 → 2")
    page.tick("For 10 s", True)
    page.fill("Loss %", "50")
    page.wait_text(r"1→2\s+loss 50 %")  # ten seconds of a busy machine are few
    page.choose("Speed", "5 x")
    page.wait_text("No faults", 40.0)
    page.until(lambda: page.number("Loss %") == "0", "loss 0 on the panel")
    page.tick("For 10 s", False)
    page.choose("Speed", "1 x real time")


def test_controls_follow_the_world(page: Driven, run: BrowserRun) -> None:
    page.choose("Controller", "leader_follower")
    page.until(lambda: run.state().controller == "leader_follower", "the controller in the world")
    run.ask(UseController(controller="nash"))
    page.until(lambda: page.chosen("Controller") == "nash", "nash on the page")
    run.ask(SetFault(link="2->3", changes={"latency": 0.25}))
    page.choose("Target", "2 → 3")
    page.until(lambda: page.number("Latency ms") == "250", "latency 250 on the panel")


def test_a_dashboard_that_is_started_again_shows_the_faults_in_force(page: Driven, run: BrowserRun) -> None:
    page.choose("Target", "All links")
    page.fill("Loss %", "25")
    page.choose("Target", "2 → 3")
    page.tick("Cut", True)
    page.wait_text(r"2→3\s+cut")
    run.end("dashboard", kill=True)
    page.until(lambda: page.lost, "word that the server is gone")
    run.url = run.start_dashboard(urlsplit(page.url).port or 0)
    page.open(run.url)
    page.wait_text(r"2→3\s+cut")
    assert not page.lost
    page.until(lambda: page.number("Loss %") == "25" and page.ticked("Cut"), "the faults on the panel")


def test_a_killed_agent_is_shown_and_comes_back(page: Driven, run: BrowserRun) -> None:
    run.end("agent-2", kill=True)
    page.wait_text(r"R2\s+LOST")
    run.start_agent(2)
    page.until(lambda: re.search(r"R2\s+LOST", page.text()) is None, "robot 2 alive", 20.0)


def test_another_scenario_has_other_robots(page: Driven) -> None:
    page.choose("Scenario", "figure8")
    page.until(lambda: len(page.bodies()) == 2, "two robots")
    page.choose("Scenario", "triangle-circle")
    page.until(lambda: len(page.bodies()) == 3, "three robots")


def test_pages_of_other_sites_are_refused(page: Driven) -> None:
    import viser
    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect
    from websockets.typing import Origin, Subprotocol

    address = page.url.replace("http", "ws")
    protocol = [Subprotocol(f"viser-v{viser.__version__}")]
    foreign: tuple[str | None, ...] = ("http://evil.example", "null", None, page.url.replace("127.0.0.1", "localhost"))
    for origin in foreign:
        with pytest.raises(InvalidStatus, match="403"):
            connect(address, origin=None if origin is None else Origin(origin), subprotocols=protocol)
    with connect(address, origin=Origin(page.url), subprotocols=protocol, max_size=None) as socket:
        assert socket.recv(timeout=5.0)


def test_a_taken_port_is_an_error_in_one_line(page: Driven, run: BrowserRun) -> None:
    port = str(urlsplit(page.url).port)
    command = [sys.executable, "-m", "dashboard", "--run", RUN, "--connect", run.endpoint, "--port", port]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=20, env=dict(os.environ), check=False
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert port in done.stderr


def shown(page: Driven) -> bool:
    """Whether all of the ghost is seen; part of it never is."""
    found = set(page.page.evaluate(SHOWN))
    return found == {True}


def ghosts(page: Driven) -> FloatArray:
    return page.prop("/ghosts", "batched_positions").reshape(-1, 3)


def plotted(page: Driven) -> list[dict[str, Any]]:
    """The newest value of every line of every plot in which there is a ghost."""
    return [lines for lines in page.page.evaluate(NEWEST) if "ghost" in lines]


def test_another_controller_is_seen_as_a_ghost_beside_its_errors(page: Driven, run: BrowserRun) -> None:
    page.wait_text("RUNNING", 60.0)
    page.press("Reset")  # so that the ghost has little to catch up with
    assert not shown(page)
    assert "RMS" not in page.text()
    run.ask(SetFault(link="1->2", changes={"latency": 0.2, "loss": 0.3}))
    page.choose("Compare with", "leader_follower")
    page.until(lambda: shown(page), "ghost", 60.0)
    page.wait_text(r"(?s)RMS.*leader_follower.*\d x better.*\d x better", 60.0)
    page.press("Pause")
    page.wait_text("PAUSED")
    state = run.state()
    message = run.ghost()
    assert message.stamp == state.stamp
    page.until(lambda: np.allclose(ghosts(page)[:, :2], message.poses[:, :2], atol=1e-5), "ghost where it is", 20.0)
    assert np.abs(ghosts(page) - page.bodies()).max() > 1e-3
    live, other = 1e3 * np.abs(state.distance_errors).max(), 1e3 * np.abs(message.distance_errors).max()
    page.until(lambda: plotted(page)[0]["ghost"] == pytest.approx(other, rel=0.2), "ghost's error in the plot")
    page.until(lambda: plotted(page)[0]["max"] == pytest.approx(live, rel=0.2, abs=1e-3), "its own beside it")
    assert len(plotted(page)) == 3  # distance, angle, tracking
    assert all(lines["ghost"] > 0.0 for lines in plotted(page))


def test_the_live_controller_as_a_ghost_is_the_same(page: Driven, run: BrowserRun) -> None:
    page.choose("Compare with", "nash")
    page.wait_text(r"(?s)┅ nash.*the same", 60.0)
    page.press("Pause")
    page.wait_text("PAUSED")
    page.until(lambda: np.allclose(ghosts(page)[:, :2], page.bodies()[:, :2], atol=1e-6), "ghost under the bodies")
    np.testing.assert_array_equal(run.ghost().poses, run.state().poses)


def test_what_is_compared_is_the_worlds_to_say_and_outlives_a_reset(page: Driven, run: BrowserRun) -> None:
    run.ask(Compare(controller="paper"))
    page.until(lambda: page.chosen("Compare with") == "paper", "paper on the page")
    page.press("Reset")
    page.wait_text(r"t = \d\.")
    page.until(lambda: shown(page), "ghost of the new episode", 60.0)
    run.ask(Compare(controller="off"))
    page.until(lambda: page.chosen("Compare with") == "nothing", "nothing on the page")
    page.until(lambda: not shown(page), "no ghost")
    assert "RMS" not in page.text()
