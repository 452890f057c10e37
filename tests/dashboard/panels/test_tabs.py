"""What no page has open is drawn now and then only."""

import pytest

from dashboard.page import Page
from dashboard.panels import tabs
from dashboard.panels.tabs import LIVE, NAMES, NETWORK, ROBOTS, Tabs
from formation.scenario.files import load
from tests.dashboard.fakes import page_of


@pytest.fixture
def drawn(page: Page) -> Tabs:
    return page._tabs


def test_a_page_that_has_told_nothing_may_have_any_tab_open(drawn: Tabs) -> None:
    drawn.tell(1, [LIVE])
    assert drawn.seen([1]) == {LIVE}
    assert drawn.seen([1, 2]) == {*NAMES}
    drawn.tell(2, [ROBOTS, NETWORK])
    assert drawn.seen([1, 2]) == {LIVE, ROBOTS, NETWORK}
    assert drawn.seen([]) == set()


def test_only_tabs_that_there_are_can_be_open_and_a_page_that_is_gone_has_none(drawn: Tabs) -> None:
    drawn.tell(1, ["", "Robots", "x" * 64])
    assert drawn.seen([1]) == {ROBOTS}
    drawn.forget(1)
    assert drawn.seen([1]) == {*NAMES}


def test_what_a_page_writes_opens_tabs_and_they_are_drawn_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tabs, "HIDDEN_SECONDS", 1e9)
    with page_of(load("triangle-circle")) as page:
        page._told(1, ["tabs", LIVE])
        pages = dict.fromkeys([1])
        monkeypatch.setattr(page._server, "get_clients", lambda: pages)
        page._frame()
        table = page._tabs._robot_table
        table.content = matrix = page._tabs._link_matrix.content = "old"
        page._panels_drawn_at = 0.0
        page._frame()
        assert (table.content, page._tabs._link_matrix.content != matrix) == ("old", True)
        page._told(1, ["tabs", ROBOTS])
        page._frame()
        assert "R1" in table.content


def test_a_hidden_tab_is_drawn_after_a_while(monkeypatch: pytest.MonkeyPatch, drawn: Tabs) -> None:
    now = [1e9]
    monkeypatch.setattr(tabs, "monotonic", lambda: now[0])
    assert drawn._due(ROBOTS, [LIVE])
    assert not drawn._due(ROBOTS, [LIVE])
    assert drawn._due(ROBOTS, [ROBOTS])
    now[0] += tabs.HIDDEN_SECONDS
    assert drawn._due(ROBOTS, [LIVE])
