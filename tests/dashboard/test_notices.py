"""Laws of the notices: a change is shown once, and an old event not at all."""

from dataclasses import dataclass, field
from typing import Any

import pytest

from dashboard.notices import AT_ONCE, COLOURS, Notices
from dashboard.telemetry.links import ring_links
from dashboard.telemetry.subscriber import Snapshot
from formation.faults import Fault
from formation.link_ids import LinkId, plan_links
from network.messages import State
from network.values import Event, Severity
from tests.builders import state


@dataclass
class FakeServer:
    """One page, whose notices are kept."""

    titles: list[str] = field(default_factory=list)
    colours: list[tuple[int, int, int]] = field(default_factory=list)

    def on_client_connect(self, callback: Any) -> None:
        pass

    def get_clients(self) -> dict[int, Any]:
        return {1: self}

    def add_notification(self, title: str, text: str, *, color: tuple[int, int, int], **_: object) -> None:
        self.titles.append(title)
        self.colours.append(color)


@pytest.fixture
def server() -> FakeServer:
    return FakeServer()


@pytest.fixture
def notices(server: FakeServer) -> Notices:
    return Notices(server)  # type: ignore[arg-type]


def update(notices: Notices, now: State, *, world_alive: bool = True) -> None:
    snapshot = Snapshot(now, None, {}, now.poses, now.stamp, (), world_alive=world_alive, connected=True)
    notices.update(snapshot, ring_links(now, {}))


def test_an_event_of_an_agent_becomes_a_notice_once_and_those_before_the_page_do_not(
    notices: Notices, server: FakeServer
) -> None:
    old, new = Event(1, 0.0, "agent", "agent 1 is here"), Event(2, 1.0, "agent", "agent 2 is gone")
    update(notices, state(events=(old,)))
    for _ in range(3):
        update(notices, state(events=(old, new)))
    assert server.titles == ["Agent 2 is gone"]


@pytest.mark.parametrize("text", ["agent 2 is here again", "agent 2 is lost"])
def test_the_colour_of_a_notice_is_its_events_severity_whatever_the_text(
    notices: Notices, server: FakeServer, text: str
) -> None:
    update(notices, state())
    severities: tuple[Severity, ...] = ("info", "warning", "error")
    events = [Event(n, 1.0, "agent", text, severity) for n, severity in enumerate(severities, start=1)]
    update(notices, state(events=tuple(events)))
    assert server.colours == [COLOURS[severity] for severity in severities]
    assert len(set(server.colours)) == len(severities)


def test_a_cut_and_its_end_are_shown(notices: Notices, server: FakeServer) -> None:
    for faults in ({}, {LinkId(1, 2): Fault(cut=True)}, {LinkId(1, 2): Fault(cut=True)}, {}):
        update(notices, state(faults=faults))
    assert server.titles == ["Link 1 → 2 cut", "All links are back"]


def test_many_links_at_once_are_one_notice(notices: Notices, server: FakeServer) -> None:
    robots = AT_ONCE + 1
    update(notices, state(robots))
    update(notices, state(robots, faults=dict.fromkeys(plan_links(robots), Fault(cut=True))))
    assert server.titles == [f"{robots} links lost"]


def test_a_world_that_falls_silent_is_shown_and_its_return_too(notices: Notices, server: FakeServer) -> None:
    for alive in (True, False, False, True):
        update(notices, state(), world_alive=alive)
    assert server.titles == ["The world publishes nothing", "The world is back"]


def test_a_cut_link_is_not_back_because_its_receiver_was_killed(notices: Notices, server: FakeServer) -> None:
    cut = {LinkId(1, 2): Fault(cut=True)}
    for live, faults in (([1, 2, 3], {}), ([1, 2, 3], cut), ([1, 3], cut), ([1, 2, 3], cut), ([1, 2, 3], {})):
        update(notices, state(live=live, faults=faults))
    assert server.titles == ["Link 1 → 2 cut", "All links are back"]
