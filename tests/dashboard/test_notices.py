"""Laws of the notices: a change is shown once, and an old event not at all."""

from dataclasses import dataclass, field

import pytest

from dashboard.notices import AT_ONCE, COLOURS, Notice, Notices
from dashboard.telemetry.links import ring_links
from dashboard.telemetry.snapshot import Snapshot
from formation.faults import Fault
from formation.link_ids import LinkId, plan_links
from network.messages import State
from network.values import Event, Severity
from tests.builders import state


@dataclass
class Shown:
    """The notices of one page."""

    titles: list[str] = field(default_factory=list)
    colours: list[str] = field(default_factory=list)

    def show(self, _: int | None, notice: Notice) -> None:
        self.titles.append(notice.title)
        self.colours.append(notice.colour)


@pytest.fixture
def shown() -> Shown:
    return Shown()


@pytest.fixture
def notices(shown: Shown) -> Notices:
    return Notices(shown.show)


def update(notices: Notices, now: State, *, world_alive: bool = True) -> None:
    snapshot = Snapshot(now, None, {}, now.poses, now.stamp, (), world_alive=world_alive, connected=True)
    notices.update(snapshot, ring_links(now, {}))


def test_an_event_of_an_agent_becomes_a_notice_once_and_those_before_the_page_do_not(
    notices: Notices, shown: Shown
) -> None:
    old, new = Event(1, 0.0, "agent", "agent 1 is here"), Event(2, 1.0, "agent", "agent 2 is gone")
    update(notices, state(events=(old,)))
    for _ in range(3):
        update(notices, state(events=(old, new)))
    assert shown.titles == ["Agent 2 is gone"]


@pytest.mark.parametrize("text", ["agent 2 is here again", "agent 2 is lost"])
def test_the_colour_of_a_notice_is_its_events_severity_whatever_the_text(
    notices: Notices, shown: Shown, text: str
) -> None:
    update(notices, state())
    severities: tuple[Severity, ...] = ("info", "warning", "error")
    events = [Event(n, 1.0, "agent", text, severity) for n, severity in enumerate(severities, start=1)]
    update(notices, state(events=tuple(events)))
    assert shown.colours == [COLOURS[severity] for severity in severities]
    assert len(set(shown.colours)) == len(severities)


def test_the_end_of_a_cut_is_shown(notices: Notices, shown: Shown) -> None:
    for faults in ({}, {LinkId(1, 2): Fault(cut=True)}, {LinkId(1, 2): Fault(cut=True)}, {}):
        update(notices, state(faults=faults))
    assert shown.titles == ["All links are back"], "the status line has the cut as long as it lasts"


def test_many_links_at_once_are_one_notice(notices: Notices, shown: Shown) -> None:
    robots = AT_ONCE + 1
    update(notices, state(robots))
    update(notices, state(robots, faults=dict.fromkeys(plan_links(robots), Fault(cut=True))))
    assert shown.titles == [f"{robots} links lost"]


def test_a_world_that_falls_silent_is_shown_and_its_return_too(notices: Notices, shown: Shown) -> None:
    for alive in (True, False, False, True):
        update(notices, state(), world_alive=alive)
    assert shown.titles == ["The world publishes nothing", "The world is back"]


def test_a_cut_link_is_not_back_because_its_receiver_was_killed(notices: Notices, shown: Shown) -> None:
    cut = {LinkId(1, 2): Fault(cut=True)}
    for live, faults in (([1, 2, 3], {}), ([1, 2, 3], cut), ([1, 3], cut), ([1, 2, 3], cut), ([1, 2, 3], {})):
        update(notices, state(live=live, faults=faults))
    assert shown.titles == ["All links are back"], "the status line has the cut as long as it lasts"
