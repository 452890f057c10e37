"""Laws of the status line: the worst comes first, and while all is well it is about who knows the path."""

from collections.abc import Mapping

import pytest

from dashboard.overlay.chips import chips
from dashboard.overlay.status_line import StatusLine, status_line
from dashboard.telemetry.links import ring_links
from dashboard.telemetry.snapshot import Snapshot
from formation.faults import Fault
from formation.link_ids import LinkId
from formation.scenario.files import load
from network.messages import State, Status
from network.values import LinkCounts
from tests.builders import state, status

CUT = {LinkId(1, 2): Fault(cut=True)}


def snapshot(now: State, statuses: Mapping[int, Status], scenario: str) -> Snapshot:
    return Snapshot(now, load(scenario), statuses, now.poses, now.stamp, (), world_alive=True, connected=True)


def line(now: State, statuses: Mapping[int, Status], scenario: str = "square-figure8") -> StatusLine:
    return status_line(snapshot(now, statuses, scenario), ring_links(now, statuses))


def test_all_is_well() -> None:
    told = {i: status(i, i - 1 or 4, way_age=0.01 * i) for i in range(1, 5)}
    assert line(state(4), told).headline == "Every robot knows the path."
    found = line(state(4), told, "follow-the-leader")
    assert found.headline == "Robot 1 knows the path; 2, 3 and 4 learn it hop by hop within 40 ms."
    assert len(found.headline) <= 70


@pytest.mark.parametrize("scenario", ["square-figure8", "follow-the-leader"])
def test_a_cut_link_is_worse_than_a_lost_agent_and_that_worse_than_a_late_link(scenario: str) -> None:
    late = {3: status(3, 2, age=0.4, counts=LinkCounts(sent=100, delivered=69, lost=31))}
    found = line(state(4), late, scenario)
    assert (found.colour, found.headline) == ("warn", "Link 2 → 3 is late: 400 ms, 31 % lost.")
    found = line(state(4, live=[1, 2, 3]), late, scenario)
    assert (found.colour, found.headline) == ("bad", "Robot 4 has no agent.")
    found = line(state(4, live=[1, 2, 3], faults=CUT), {**late, 2: status(2, 1, age=6.0)}, scenario)
    assert (found.colour, found.headline) == ("bad", "Link 1 → 2 cut 6.0 s ago.")


def test_robots_whose_way_is_used_up_are_named_and_have_chips() -> None:
    lost = {i: status(i, i - 1, age=6.0, way_age=6.0, lost=True) for i in (2, 3)}
    assert "Robots 2 and 3 used up the way" in line(state(4, faults=CUT), lost, "follow-the-leader").rest
    again = {i: status(i, i - 1, age=0.01, way_age=0.02, lost=True) for i in (2, 3)}
    assert line(state(4), again, "follow-the-leader").headline == "Robots 2 and 3 are not yet on the way last told."
    assert [chip.key for chip in chips(snapshot(state(4), again, "follow-the-leader"), [])] == ["knows"]
    found = {chip.key: chip for chip in chips(snapshot(state(4), lost, "follow-the-leader"), [])}
    assert found.keys() == {"knows", "way 2", "way 3", "told"}
    assert (found["way 3"].number, found["way 3"].colour) == ("6.0 s", "bad")
    assert chips(snapshot(state(4), lost, "square-figure8"), []) == []
