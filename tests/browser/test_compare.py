"""The ghost in a browser: seen where it flies, its errors beside the live ones, switched from anywhere."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from formation.arrays import FloatArray
from network.control import Compare, SetFault
from tests.browser.driven import Driven
from tests.browser.flight import Flight

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = [pytest.mark.browser, pytest.mark.processes]
SHOWN = """() => ["/ghosts", "/ghost_edges", "/ghost_trails"].map(
  name => window.__viserSceneTree.getState()[name].effectiveVisibility)"""
NEWEST = """() => Object.values(window.__viserTestpoints.uplots).map(
  plot => Object.fromEntries(plot.chart.series.map((line, i) => [line.label, plot.chart.data[i].at(-1)])))"""


@pytest.fixture(scope="module")
def flight() -> Iterator[Flight]:
    with Flight("triangle-circle", robots=3) as running:
        yield running


@pytest.fixture(scope="module")
def page(browser: "Browser", flight: Flight) -> Iterator[Driven]:
    driven = Driven(browser, flight.url)
    yield driven
    driven.page.close()


def shown(page: Driven) -> bool:
    """Whether all of the ghost is seen; part of it never is."""
    found = set(page.page.evaluate(SHOWN))
    return found == {True}


def ghosts(page: Driven) -> FloatArray:
    return page.prop("/ghosts", "batched_positions").reshape(-1, 3)


def plotted(page: Driven) -> list[dict[str, Any]]:
    """The newest value of every line of every plot in which there is a ghost."""
    return [lines for lines in page.page.evaluate(NEWEST) if "ghost" in lines]


def test_another_controller_is_seen_as_a_ghost_beside_its_errors(page: Driven, flight: Flight) -> None:
    page.wait_text("RUNNING")
    assert not shown(page)
    assert "RMS" not in page.text()
    flight.ask(SetFault(link="1->2", changes={"latency": 0.2, "loss": 0.3}))
    page.choose("Compare with", "leader_follower")
    page.until(lambda: shown(page), "ghost", 60.0)
    page.wait_text(r"(?s)RMS.*leader_follower.*\d x better.*\d x better", 60.0)
    page.press("Pause")
    page.wait_text("PAUSED")
    state = flight.state()
    said = flight.ghost()
    assert said.stamp == state.stamp
    page.until(lambda: np.allclose(ghosts(page)[:, :2], said.poses[:, :2], atol=1e-5), "ghost where it is", 20.0)
    assert np.abs(ghosts(page) - page.bodies()).max() > 1e-3
    live, other = 1e3 * np.abs(state.distance_errors).max(), 1e3 * np.abs(said.distance_errors).max()
    page.until(lambda: plotted(page)[0]["ghost"] == pytest.approx(other, rel=0.2), "ghost's error in the plot")
    assert plotted(page)[0]["max"] == pytest.approx(live, rel=0.2, abs=1e-3)
    assert len(plotted(page)) == 3  # distance, angle, tracking
    assert all(lines["ghost"] > 0.0 for lines in plotted(page))
    page.press("Start")


def test_the_live_controller_as_a_ghost_is_the_same(page: Driven, flight: Flight) -> None:
    page.choose("Compare with", "nash")
    page.wait_text(r"(?s)┅ nash.*the same", 60.0)
    page.press("Pause")
    page.wait_text("PAUSED")
    page.until(lambda: np.allclose(ghosts(page)[:, :2], page.bodies()[:, :2], atol=1e-6), "ghost under the bodies")
    np.testing.assert_array_equal(flight.ghost().poses, flight.state().poses)
    page.press("Start")


def test_what_is_compared_is_the_worlds_to_say_and_outlives_a_reset(page: Driven, flight: Flight) -> None:
    flight.ask(Compare(controller="paper"))
    page.until(lambda: page.chosen("Compare with") == "paper", "paper on the page")
    page.press("Reset")
    page.until(lambda: flight.state().stamp < 20.0, "a new flight")
    page.until(lambda: shown(page), "ghost of the new flight", 60.0)
    flight.ask(Compare(controller="off"))
    page.until(lambda: page.chosen("Compare with") == "nothing", "nothing on the page")
    page.until(lambda: not shown(page), "no ghost")
    assert "RMS" not in page.text()
