"""A path that is drawn point after point becomes a scenario that loads."""

import tomllib
from typing import Any

import numpy as np
import pytest

from dashboard.page import Page
from dashboard.steering.drawing import MOST, drawn
from formation.scenario.files import load, parse
from formation.scenario.toml_text import as_toml
from network.control import UseScenario

CORNERS = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]


@pytest.mark.parametrize("name", ["triangle-circle", "follow-the-leader", "drive-me", "square-figure8"])
@pytest.mark.parametrize("closed", [False, True])
def test_a_drawing_is_the_scenario_with_another_path_that_passes_the_points(name: str, closed: bool) -> None:
    scenario = load(name)
    found = drawn(scenario, CORNERS, closed=closed)
    assert found.scenario is not None, found.reason
    again = parse(tomllib.loads(as_toml(found.scenario)))
    assert again == found.scenario
    assert (again.formation, again.bodies, again.path.known_to) == (
        scenario.formation,
        scenario.bodies,
        scenario.path.known_to,
    )
    way = again.path.position(np.linspace(0.0, again.duration, 2000))
    for corner in CORNERS:
        assert np.hypot(*(way - corner).T).min() < 2e-3
    assert (again.path.period is not None) == closed


@pytest.mark.parametrize("points", [[], [(0.0, 0.0)], [(1.0, 1.0)] * 5])
def test_too_few_points_are_refused_in_a_line(points: list[tuple[float, float]]) -> None:
    found = drawn(load("triangle-circle"), points, closed=True)
    assert found.scenario is None
    assert "3 points" in found.reason


class Client:
    """A page, as the panel needs it."""

    def __init__(self, number: int) -> None:
        self.client_id = number
        self.files: list[tuple[str, bytes]] = []

    def send_file_download(self, name: str, content: bytes, **_: Any) -> None:
        self.files.append((name, content))


def test_clicks_of_the_page_that_draws_are_points_and_the_file_is_sent_to_it(page: Page) -> None:
    panel, one, other = page._steering._drawing, Client(1), Client(2)
    asked = list[Any]()
    page._requests.ask = lambda operation, page: asked.append(operation)  # type: ignore[method-assign]
    assert not panel.wants(1)
    panel._place("Draw", 1)
    assert panel.wants(1)
    assert not panel.wants(2)
    for corner in [*CORNERS, (5.0, 5.0)]:
        panel.add(1, *corner)
    panel._place("Undo", 1)
    page._panels_drawn_at = 0.0
    page._frame()
    assert "3 points" in panel._shown.content
    panel._use("Save", other)  # type: ignore[arg-type]
    ((name, text),) = other.files
    assert name == "drawn.toml"
    table = tomllib.loads(text.decode())
    assert parse(table).path.position(np.array(0.0)) == pytest.approx([0.0, 0.0])
    panel._use("Run it", one)  # type: ignore[arg-type]
    (operation,) = asked
    assert isinstance(operation, UseScenario)
    assert operation.table["path"] == table["path"]  # type: ignore[index]
    assert not panel.wants(1)


def test_a_drawing_does_not_grow_without_bound(page: Page) -> None:
    panel = page._steering._drawing
    for i in range(2 * MOST):
        panel.add(1, float(i), 0.0)
    assert len(panel._points) == MOST
