"""Laws of the fault panel."""

import pytest

from dashboard.page import Page
from dashboard.panels import faults
from formation.faults import Fault
from formation.link_ids import LinkId, links_named
from tests.builders import state
from tests.dashboard.fakes import settle


def test_every_target_of_the_fault_panel_is_made_of_links_that_the_world_knows() -> None:
    for robots in (2, 3, 16):
        for driven in (False, True):
            for links in faults.targets(robots, driven=driven).values():
                for link in links:
                    assert links_named(link, robots, driven=driven)
    assert "driver → 1" in faults.targets(3, driven=True)
    assert "driver → 1" not in faults.targets(3)


def test_the_panel_shows_the_worst_of_the_chosen_links() -> None:
    table = {LinkId(1, 2): Fault(latency=0.3), LinkId(2, 3): Fault(latency=0.1, cut=True)}
    assert faults.worst(table, ("1->2",), 3)["latency"] == 0.3
    assert not faults.worst(table, ("1->2",), 3)["cut"]
    every = faults.worst(table, ("all",), 3)
    assert (every["latency"], every["cut"]) == (0.3, True)


@pytest.mark.parametrize("choice", ["Robot ", "Robot x", "Robot -5: from and to", "", "9 → 1"])
def test_a_target_that_is_not_offered_is_no_link_and_is_set_back(page: Page, choice: str) -> None:
    panel = page._faults
    panel._target.value = choice
    assert list(panel.target) == []
    assert faults.worst({LinkId(1, 2): Fault(loss=1.0)}, panel.target, 3)["loss"] == 0.0
    panel.draw(state(), driven=False)
    settle(page)
    assert list(panel.target) == ["all"]
