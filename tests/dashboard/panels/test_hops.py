"""The strip of robots: hop by hop, and short for a crowd."""

import dataclasses

import pytest

from dashboard.page import Page
from dashboard.panels.hops import BROKEN, FEW, MOST, ON, hops, oldest_way
from dashboard.telemetry.links import ring_links
from dashboard.telemetry.snapshot import Snapshot
from formation.faults import Fault
from formation.link_ids import LinkId
from formation.scenario.files import load
from network.messages import Status
from tests.builders import state, status


def of(page: Page, robots: int, scenario: str, ages: dict[int, float], **changes: object) -> Snapshot:
    statuses: dict[int, Status] = {i: status(i, robots if i == 1 else i - 1, way_age=age) for i, age in ages.items()}
    now = state(robots, live=tuple(range(1, robots + 1)), **changes)  # type: ignore[arg-type]
    return dataclasses.replace(page._feed.now().snapshot, state=now, scenario=load(scenario), statuses=statuses)


def test_ages_add_up_hop_by_hop_and_a_cut_stands_where_it_is(page: Page) -> None:
    cut = {LinkId(2, 3): Fault(cut=True)}
    snapshot = of(page, 4, "follow-the-leader", {1: 0.0, 2: 0.02, 3: 3.0, 4: 3.05}, faults=cut)
    assert snapshot.state is not None
    title, shown = hops(snapshot, ring_links(snapshot.state, snapshot.statuses))
    assert "hop by hop" in title
    assert [hop.text for hop in shown] == ["knows", "20 ms", "3.0 s", "3.0 s"]
    assert [hop.mark for hop in shown] == [ON, BROKEN, ON, ""]
    assert [hop.level < 1.0 for hop in shown] == [True, True, False, False]
    assert oldest_way(snapshot) == pytest.approx(3.05)


def test_of_a_driven_formation_ages_are_since_the_driver_gave_the_order(page: Page) -> None:
    snapshot = of(page, 4, "drive-me", {1: 0.04, 2: 0.02, 3: 0.05, 4: 0.07})
    assert snapshot.state is not None
    _, shown = hops(snapshot, ring_links(snapshot.state, snapshot.statuses))
    assert [hop.text for hop in shown] == ["40 ms", "60 ms", "90 ms", "110 ms"]


def test_where_every_robot_knows_the_path_nothing_is_said_of_the_way(page: Page) -> None:
    snapshot = of(page, 3, "triangle-circle", {1: 0.0, 2: 0.0, 3: 0.0})
    assert snapshot.state is not None
    title, shown = hops(snapshot, ring_links(snapshot.state, snapshot.statuses))
    assert (title, [(hop.text, hop.mark) for hop in shown]) == ("", [("", "")] * 3)
    assert oldest_way(snapshot) is None


@pytest.mark.parametrize("down", [0, 2, 400])
def test_a_crowd_is_counted_and_those_that_need_a_look_come_first(page: Page, down: int) -> None:
    robots = 1000
    snapshot = of(page, robots, "triangle-circle", {}, dismissed=tuple(range(1, down + 1)))
    assert snapshot.state is not None
    now = dataclasses.replace(snapshot.state, live=list(range(down + 1, robots + 1)))
    snapshot = dataclasses.replace(snapshot, state=now)
    _, shown = hops(snapshot, ring_links(now, {}))
    assert len(shown) <= MOST + 1
    assert [hop.name for hop in shown[:-1]] == [f"R{i}" for i in range(1, min(down, MOST) + 1)]
    assert all(hop.text == "KILLED" for hop in shown[:-1])
    assert robots > FEW
